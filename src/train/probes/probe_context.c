#include "train/probes/probe_context.h"

#include <math.h>

void vw_probe_read(const struct vw_probe_context *context, const vw_float4 *rows, bool stepped,
                   struct vw_probe *probe) {
    const struct vw_field_measurement measured = vw_validation_read(context->validation, rows, NULL);
    bool valid = measured.finite && !(stepped && rows->z != 0.0f);
    probe->val_psnr = valid ? measured.val_psnr : NAN;
    probe->val_psnr_pooled = valid ? measured.val_psnr_pooled : NAN;
    probe->val_l1 = valid ? measured.val_l1 : NAN;
}

#include "train/probes/probe_context.h"

#include <math.h>

void probe_read(const struct probe_context *context, const vw_float4 *rows, bool stepped, struct vw_probe *probe) {
    const struct measurement measured = validation_read(context->validation, rows, NULL);
    bool valid = measured.finite && !(stepped && rows->z != 0.0f);
    probe->val_psnr = valid ? measured.val_psnr : NAN;
    probe->val_psnr_pooled = valid ? measured.val_psnr_pooled : NAN;
    probe->val_l1 = valid ? measured.val_l1 : NAN;
}

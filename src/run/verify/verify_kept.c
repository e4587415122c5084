#include "run/verify/verify_kept.h"

#include <string.h>

#include "base/inside.h"
#include "run/out_files.h"
#include "run/outputs/checksums.h"

static enum vw_status check_file(const char *out, const char *name, struct vw_ledger *ledger, bool *bound) {
    struct vw_checksum file;
    enum vw_status status = vw_checksum_make(out, name, &file);
    return status ? status : vw_ledger_is_kept(ledger, name, file.sha256, bound);
}

enum vw_status vw_verify_kept(const char *out, struct vw_ledger *ledger, struct vw_kept_file files[VW_KEPT_FILES_MAX],
                              uint32_t *count) {
    enum vw_status status = VW_OK;
    *count = 0;
    for (size_t i = 0; !status && i < vw_out_file_count && *count < VW_KEPT_FILES_MAX; i++) {
        struct vw_kept_file *file = &files[*count];
        if (vw_out_files[i].protection != VW_OUT_KEPT || !strcmp(vw_out_files[i].name, VW_RETRAININGS_FILE)) continue;
        *file = (struct vw_kept_file){.name = vw_out_files[i].name};
        status = vw_file_check_inside(out, file->name);
        if (status || !vw_file_exists_inside(out, file->name)) continue;
        status = check_file(out, file->name, ledger, &file->bound);
        ++*count;
    }
    return status;
}

#include "run/verify/verify_kept.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "ledger/retraining_store.h"
#include "run/out_files.h"
#include "run/outputs/checksums.h"

static enum vw_status check_retrainings(const char *out, struct vw_ledger *ledger, bool *bound) {
    struct vw_retraining_store *retrainings = NULL;
    uint64_t count = 0, foreign = 0;
    char *path = vw_path_join(out, VW_RETRAININGS_FILE);
    enum vw_status status = path ? vw_retraining_store_open_to_read(path, &retrainings) : VW_ERROR_MEMORY;
    free(path);
    if (!status) vw_retraining_store_bind(retrainings, ledger);
    if (!status) status = vw_retraining_store_count(retrainings, &count, &foreign);
    vw_retraining_store_close(&retrainings);
    *bound = !status && foreign == 0;
    return status == VW_ERROR_INPUT ? VW_OK : status;
}

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
        if (vw_out_files[i].protection != VW_OUT_KEPT) continue;
        *file = (struct vw_kept_file){.name = vw_out_files[i].name};
        status = vw_file_check_inside(out, file->name);
        if (status || !vw_file_exists_inside(out, file->name)) continue;
        status = strcmp(file->name, VW_RETRAININGS_FILE) ? check_file(out, file->name, ledger, &file->bound)
                                                         : check_retrainings(out, ledger, &file->bound);
        ++*count;
    }
    return status;
}

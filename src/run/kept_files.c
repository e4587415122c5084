#include "run/kept_files.h"

#include <string.h>

#include "run/out_files.h"

static enum vw_status keep(void *context, const char *name, const char *sha256) {
    struct vw_ledger *ledger = *(struct vw_ledger **)context;
    return strcmp(name, VW_FIELD_FILE) ? vw_ledger_keep(ledger, name, sha256) : vw_ledger_set_field(ledger, sha256);
}

static enum vw_status is_kept(void *context, const char *name, const char *sha256, bool *kept) {
    struct vw_ledger *ledger = *(struct vw_ledger **)context;
    struct vw_ledger_run run;
    if (strcmp(name, VW_FIELD_FILE)) return vw_ledger_is_kept(ledger, name, sha256, kept);
    enum vw_status status = vw_ledger_get_run(ledger, &run);
    if (!status) *kept = run.field_sha256 && !strcmp(run.field_sha256, sha256);
    return status;
}

struct vw_file_binding vw_kept_files_bind(struct vw_ledger **ledger) {
    return (struct vw_file_binding){.keep = keep, .is_kept = is_kept, .context = ledger};
}

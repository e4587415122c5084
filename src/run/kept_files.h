// The binding of files that commands read back from OUT to the ledger: checkpoints and the state of a stopped backward
// pass to its table kept, the field to run.field_sha256. A file whose hash it does not contain is not believed.
#ifndef VIEWWORTH_RUN_KEPT_FILES_H
#define VIEWWORTH_RUN_KEPT_FILES_H

#include "train/files/hashed_file.h"
#include "viewworth/ledger.h"

// Returns the binding to `*ledger`, which may be NULL until the first file is saved or read.
struct vw_file_binding vw_kept_files_bind(struct vw_ledger **ledger);

#endif

// The rows of many ledgers in one SQLite file (merged.db). It has the tables of a ledger (schema.c), each with the
// column "job" before the others: two jobs may have the same run_id (they differ in epochs alone), and the same scene
// with other splits. Rows are as the ledgers have them, with their hashes; run.final_hash is the chain head that each
// ledger had. Tables that a ledger lacks have no rows of its job.
#ifndef VIEWWORTH_LEDGER_MERGE_H
#define VIEWWORTH_LEDGER_MERGE_H

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_merged_ledger;

// Begins a merged ledger that replaces the file `path` when it is finished; until then its rows are in PATH.part.
enum vw_status vw_merged_create(const char *path, struct vw_merged_ledger **merged);
// Verifies a ledger and adds its rows; `job` is unlike those before. VW_ERROR_MISMATCH names what was edited.
enum vw_status vw_merged_add(struct vw_merged_ledger *merged, const char *job, struct vw_ledger *ledger);
// Gives the file its name.
enum vw_status vw_merged_finish(struct vw_merged_ledger *merged);
// Closes the merged ledger. Without vw_merged_finish() its rows are removed, and an existing file stays as it was.
void vw_merged_close(struct vw_merged_ledger **merged);

#endif

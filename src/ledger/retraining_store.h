// Retrainings in an SQLite file of their own (OUT/retrainings.db), so that a benchmark, comparison or sweep
// resumes and reuses what another one trained. Ordinary tables:
// - retraining(retraining_id, scene_hash, views, view_count, seed, epochs, val_psnr, val_ssim, val_l1, test_psnr,
//   test_ssim, test_l1, seconds, row_hash): a training on some photos. retraining_id: 64 hex digits, hash of all that
//   decides its bits. views: image_ids, ascending, separated by spaces. NULL: no value. row_hash: hash of the other
//   columns; an edited row is refused. It catches mistakes, not a forger, who can hash anew: `verify --retrainings`.
// - view(retraining_id, image_id, psnr, row_hash): what the retraining reaches on each validation and test photo, in
//   dB, and on train photos that were asked for; of a retraining that was measured after every step, what the steps on
//   each train photo gain.
// Each append is one synced transaction.
#ifndef VIEWWORTH_LEDGER_RETRAINING_STORE_H
#define VIEWWORTH_LEDGER_RETRAINING_STORE_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"
#include "viewworth/status.h"

struct vw_retraining_store;

// Opens the file, or makes it; with NULL a store in memory. VW_ERROR_INPUT when it is something else, of another
// version, or damaged.
enum vw_status vw_retraining_store_open(const char *path, struct vw_retraining_store **retrainings);
// Opens it to read, changing nothing. VW_ERROR_INPUT also when there is none.
enum vw_status vw_retraining_store_open_to_read(const char *path, struct vw_retraining_store **retrainings);
void vw_retraining_store_close(struct vw_retraining_store **retrainings);

// Looks up a retraining: `*found` tells if its id is recorded, `*result` is its result. VW_ERROR_MISMATCH if its row
// was edited.
enum vw_status vw_retraining_store_find(struct vw_retraining_store *retrainings, const char *retraining_id, bool *found,
                                        struct vw_retrain_result *result);
// Reads what a recorded retraining reaches on single photos: fills psnr_db of views[0 ... view_count - 1].
// VW_ERROR_MISMATCH when a row was edited, or when one is missing.
enum vw_status vw_retraining_store_find_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                              struct vw_retrain_view *views, uint32_t view_count);
// Reads the same, but does not fail if a row is missing: `*found` tells if all rows exist.
enum vw_status vw_retraining_store_recall_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                                struct vw_retrain_view *views, uint32_t view_count, bool *found);
// Appends a finished one; its epochs must be set. An id that is recorded already keeps its first result, and gets rows
// of photos that it lacks.
enum vw_status vw_retraining_store_add(struct vw_retraining_store *retrainings, const char *retraining_id,
                                       const char *scene_hash, const struct vw_retrain_params *retraining,
                                       const struct vw_retrain_result *result, const struct vw_retrain_view *views,
                                       uint32_t view_count);

#endif

// Retrainings: trainings on some of a scene's photos, judged by the quality of the trained field. Evaluation knows
// training only as a vw_retrain_function, so that its tests run it on games with known values.
//
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
#ifndef VIEWWORTH_LEDGER_RETRAINING_H
#define VIEWWORTH_LEDGER_RETRAINING_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

// The quantity that is equal in trainings on lists of different lengths.
enum vw_equal {
    VW_EQUAL_STEPS,  // all take the steps of the whole list: those of a photo that is left out are taken on the others
    VW_EQUAL_EPOCHS, // each photo is trained on as often as in the whole list: the steps of others are skipped
};
const char *vw_equal_name(enum vw_equal equal); // "steps", "epochs"

// The result of a retraining for a single photo.
struct vw_retrain_view {
    uint32_t image_id;
    double psnr_db; // PSNR of the trained field on it; or the gain of its steps, see vw_retrain_photos
};

// The quantity that a retraining measures for single train photos, in addition to its result.
enum vw_retrain_photos {
    VW_RETRAIN_PHOTOS_PSNR,  // PSNR of the trained field on photos that it may not have seen
    VW_RETRAIN_PHOTOS_GAINS, // gain in validation PSNR by the steps on a photo; PSNR is measured after every step
};

struct vw_retrain_params {
    const uint32_t *views; // borrowed; image_ids trained on, ascending; none: the untrained field
    uint32_t view_count;
    uint64_t seed;   // seeds order, pixels, jitter and initialisation
    uint32_t epochs; // 0: the default of the function
    // Train photos whose psnr_db is filled in as `photos_of` says: any of them, ascending, or, of gains, those of
    // `views`. Borrowed; NULL: none. Asking for PSNR makes no other retraining of it.
    struct vw_retrain_view *photos;
    uint32_t photo_count;
    enum vw_retrain_photos photos_of;
};

// Quality of the trained field on the validation and test photos, over their usable pixels. NaN where a split has no
// photo.
struct vw_retrain_result {
    double val_psnr, test_psnr; // dB, mean over the split's views of the per-view PSNR
    double val_l1, test_l1;     // mean over the split's views of the mean absolute error over pixels and channels
    double val_ssim, test_ssim; // mean over the split's views that have one (image/image.h); NaN also where views are
                                // not measured whole
    double seconds;             // CPU time; for display only
};

// Makes retrainings, in any order, or returns the recorded results of equal ones.
typedef enum vw_status vw_retrain_function(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                                           struct vw_retrain_result *results);

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

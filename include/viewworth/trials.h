// The trials of a benchmark or a comparison, in an SQLite file of their own (OUT/trials.db), so that either resumes, and reuses what
// another one has found. Ordinary tables:
// - trial(trial_id, scene_hash, views, view_count, seed, epochs, val_psnr, val_ssim, val_l1, test_psnr, test_ssim, test_l1, seconds,
//   row_hash): a training on some photos.
//   trial_id: 64 hex digits, hash of all that decides its bits. views: image_ids, ascending, with spaces between. NULL: no value.
//   row_hash: of the row's other columns, so that one that was edited is not taken for what was measured. It tells mistakes: whoever
//   edits can hash anew.
// - judgement(scene_hash, config_hash, place, judgement, method, value, low, high, count): what the benchmark found, as in benchmark.csv.
// Each append is one synced transaction.
#ifndef VIEWWORTH_TRIALS_H
#define VIEWWORTH_TRIALS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/hash.h"
#include "viewworth/status.h"
#include "viewworth/trial.h"

struct vw_trials;

// One figure of a benchmark.
enum { VW_JUDGEMENT_BYTES = 48 };
struct vw_judgement {
    char judgement[VW_JUDGEMENT_BYTES]; // what was judged: "auc/blur", "lds/val_psnr", ...
    const char *method;                 // whom: a method's name, or that of a control; borrowed
    double value;                       // NaN becomes NULL
    double low, high;                   // 95 % interval; NaN where there is none
    uint32_t count;                     // of what it was taken over: pairs, photos, subsets, trainings
};

// Opens the file, or makes it. VW_ERROR_INPUT when it is something else, of another version, or damaged.
enum vw_status vw_trials_open(const char *path, struct vw_trials **trials);
void vw_trials_close(struct vw_trials **trials);

// Whether a trial of that id has ended, and its outcome. VW_ERROR_MISMATCH when its row was edited.
enum vw_status vw_trials_find(struct vw_trials *trials, const char *trial_id, bool *found, struct vw_outcome *outcome);
// Appends one that has ended, whose epochs must be said. An id that is there already keeps its first outcome.
enum vw_status vw_trials_add(struct vw_trials *trials, const char *trial_id, const char *scene_hash, const struct vw_trial *trial,
                             const struct vw_outcome *outcome);
// Replaces the judgements of a scene and config.
enum vw_status vw_trials_set_judgements(struct vw_trials *trials, const char *scene_hash, const char *config_hash,
                                        const struct vw_judgement *judgements, uint32_t count);

#endif

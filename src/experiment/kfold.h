// Folds: the train and validation photos validate in turn. The scene is trained K times; training k validates on the
// photos of fold k and trains on those of the others. Test photos stay test photos.
#ifndef VIEWWORTH_EXPERIMENT_KFOLD_H
#define VIEWWORTH_EXPERIMENT_KFOLD_H

#include <stdint.h>

#include "experiment/experiment.h"
#include "run/session.h"
#include "value/evaluation/agreement.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

enum { VW_FOLDS_LEAST = 2, VW_FOLDS_MOST = 10 };

struct vw_kfold_params {
    struct vw_experiment_params common; // seeds is ignored: training k has the seed config->seed + k - 1
    uint32_t folds;                     // K, VW_FOLDS_LEAST to VW_FOLDS_MOST
};

// One training.
struct vw_kfold_fold {
    uint32_t number;                            // from 1
    uint32_t train_count, validation_count;     // photos
    uint64_t steps;                             // in the ledger
    double first_val_psnr_db, last_val_psnr_db; // before training and at the end; NaN: unknown
};

struct vw_kfold {
    const struct vw_kfold_params *params; // borrowed
    struct vw_session session;            // the scene with its own splits
    struct vw_kfold_fold folds[VW_FOLDS_MOST];
    struct vw_ledger_score *scores; // owned: over folds, see experiment/fold_scores.h
    uint32_t score_count;
    struct vw_agreement_summary agreement; // Spearman's correlation of vw_value_default_method between two folds, over
                                           // the photos that trained in both
    char *scores_path, *matrix_path, *list_path, *report_path; // owned; report_path is NULL when there is no report
};

// Assigns a fold to every view, from 0; UINT32_MAX for test and excluded views. Photos are ordered by a hash of seed
// and name, so that the order of the scene file does not matter, and dealt to the folds in turn: sizes differ by at
// most one. The caller frees `*fold_of`. Returns VW_ERROR_USAGE when a fold would be empty or leave fewer than two
// photos to train.
enum vw_status vw_kfold_divide(const struct vw_scene *scene, uint64_t seed, uint32_t folds, uint32_t **fold_of);

// Makes the trainings, as many at a time as params->common.together says, and pools their scores. Writes to OUT:
// - fold-1/ ... fold-K/: the runs as `value` writes them, without report and matrix, and train.txt, val.txt, test.txt:
//   their photos, by name
// - scores.csv: the pooled scores; matrix.csv: the photos' effects on each other, a column from the training in which
//   its photo validated, empty where both photos are of one fold; dv_psnr.csv (header name,score): the pooled default
//   score, as a list of `compare`
// - report.html
// A run that is there is resumed, a finished one stays as it is. VW_ERROR_USAGE when OUT contains other folds. Free the
// result also after a failure.
enum vw_status vw_kfold_make(const struct vw_kfold_params *params, struct vw_kfold *kfold);
void vw_kfold_free(struct vw_kfold *kfold);

#endif

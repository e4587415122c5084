// Methods of the literature that score photos by retrainings alone, each in a file of its own. They know training only
// as a vw_retrain_function. README.md says what each of them is.
#ifndef VIEWWORTH_LAB_METHODS_REGISTRY_H
#define VIEWWORTH_LAB_METHODS_REGISTRY_H

#include <stdbool.h>
#include <stdint.h>

#include "lab/evaluation/exact_values.h"
#include "ledger/retraining.h"

// Features of each photo that are known without a training.
struct vw_feature_table {
    uint32_t count;
    const char *const *names; // [feature]
    const double *values;     // [photo][feature], finite, in any unit
};

// Input of one valued seed's scores. All borrowed.
struct vw_retraining_input {
    const uint32_t *photos; // image_ids, ascending
    uint32_t photo_count;   // at least 2
    vw_retrain_function *retrain;
    void *context;                           // argument of `retrain`
    enum vw_equal equal;                     // retrainings have equal steps or epochs; decides their cost
    uint64_t first_seed;                     // retrainings have seeds from this one on, fewer than budget * epochs
    uint64_t key;                            // key of random draws
    uint32_t budget;                         // run-equivalents: trainings on all photos for `epochs` epochs
    uint32_t epochs;                         // epochs of such a training
    const struct vw_feature_table *features; // NULL: none
};

// A method gives the same scores whatever `retrain` does at a time, and a smaller budget makes the first retrainings
// of a larger one.
struct vw_retraining_method {
    const char *name, *meaning;
    bool has_sign;                 // a score below 0 says that the photo harms
    enum vw_exact_value estimates; // limit of its scores as the budget grows; VW_EXACT_COUNT: no such value
    uint32_t (*least_budget)(const struct vw_retraining_input *input);
    uint32_t (*epochs)(uint32_t whole); // epochs of each of its retrainings; NULL: of a whole training
    // Fills scores[photo], more = better; NaN where nothing tells of a photo. The budget is at least the least one.
    enum vw_status (*score)(const struct vw_retraining_input *input, double *scores);
};

// Their names in the order of the table, for texts.
#define VW_RETRAINING_METHODS "tmc_shapley, data_banzhaf, leave_one_out, data_oob, dvrl, g_shapley"
extern const struct vw_retraining_method *const vw_retraining_methods[];
extern const uint32_t vw_retraining_method_count;

// The rows, each defined in the file of its method.
extern const struct vw_retraining_method vw_tmc_shapley;
extern const struct vw_retraining_method vw_data_banzhaf;
extern const struct vw_retraining_method vw_left_out_method;
extern const struct vw_retraining_method vw_data_oob;
extern const struct vw_retraining_method vw_dvrl;
extern const struct vw_retraining_method vw_g_shapley;

// Returns true if the name is that of a method and a budget, as "tmc_shapley_40" or "tmc_shapley_4N".
bool vw_is_method_and_budget(const char *name);

// Cost of scores: a shorter retraining, or one on fewer photos at equal epochs, counts as its share of a whole one; to
// measure the untrained field costs nothing. Equal retrainings count each time.
struct vw_retraining_cost {
    double run_equivalents;
    double seconds; // CPU time as recorded; for display only
    uint64_t retrainings;
};
// Scores the photos and counts the cost. VW_ERROR_USAGE below the least budget.
enum vw_status vw_retraining_method_score(const struct vw_retraining_method *method,
                                          const struct vw_retraining_input *input, double *scores,
                                          struct vw_retraining_cost *cost);

#endif

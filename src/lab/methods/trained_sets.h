// Sets of photos that a method retrains on, and what their trainings reach.
#ifndef VIEWWORTH_LAB_METHODS_TRAINED_SETS_H
#define VIEWWORTH_LAB_METHODS_TRAINED_SETS_H

#include "lab/methods/registry.h"

struct vw_trained_sets {
    uint32_t count, photo_count;
    bool *has;                             // owned; [set][photo]
    uint32_t *views;                       // owned; [set][photo]
    struct vw_retrain_params *retrainings; // owned; [set]: the caller sets all but views and view_count
    struct vw_retrain_result *results;     // owned; [set]
};

// Sets without photos. Free them also after a failure.
enum vw_status vw_trained_sets_allocate(const struct vw_retraining_input *input, uint32_t count,
                                        struct vw_trained_sets *sets);
// Trains on all of them.
enum vw_status vw_trained_sets_train(const struct vw_retraining_input *input, struct vw_trained_sets *sets);
void vw_trained_sets_free(struct vw_trained_sets *sets);

#endif

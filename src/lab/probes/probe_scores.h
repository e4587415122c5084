// The noise of a run's measurements, and the scores of its photos from probes.
#ifndef VIEWWORTH_LAB_PROBES_PROBE_SCORES_H
#define VIEWWORTH_LAB_PROBES_PROBE_SCORES_H

#include "lab/probes/prober.h"
#include "viewworth/ledger.h"

// A run and its probes, all borrowed.
struct vw_probed_run {
    const struct vw_step_record *records; // step 0, 1, ...
    const struct vw_probe *probes;        // by step and index
    const struct vw_ledger_image *images; // by image_id, which is the index of the view
    const struct vw_ledger_score *scores; // the ledger's
    uint32_t probe_count, image_count, score_count;
};

// Noise. NaN if no probe of that kind has a value.
struct vw_noise_floor {
    uint32_t repeated_count, zero_learning_rate_count, resampled_count; // probes of each kind that have values
    // Largest |delta of val_psnr| of a repeated validation and of a step with learning rate 0: both are exactly 0 if
    // validation is a pure function of the params (decision 1).
    double repeated_db, zero_learning_rate_db;
    // Root mean square, over the probed steps, of the standard deviation of the delta when pixels are resampled.
    double resampled_db; // by val_psnr
    double resampled_l1; // by val_l1
};
void vw_noise_floor_find(const struct vw_probed_run *run, struct vw_noise_floor *floor);

// same_state_psnr: the mean change of val_psnr by a step on the photo, over the probed states and the draws of pixels
// at each (option (c) of the paper, see viewworth/value.h). visits: number of draws. The standard error is that of the
// means per state (NaN below two states), because the draws of a state share the state. resampling_stderr is the part
// of the draws: sqrt(mean over states of the draws' variance / visits), NaN if no state has two draws. There is no
// interval of the value or the rank, because these errors ignore what the states of a run share.
//
// dv_psnr and dv_loss: the ledger's. resampling_stderr is the part of the error that comes from the random pixels of
// the photo's own steps: sqrt(visits times the mean, over the photo's probed steps, of the variance of the delta over
// the resampled steps and the step itself). It does not include the pixels of earlier steps, which change the state
// that each step starts from. NaN without probed steps.
struct vw_probe_score {
    uint32_t image_id;
    const char *method, *unit;
    double value, standard_error, resampling_stderr;
    uint32_t visits;
};
// Lists the scores, at most three per image, those of same_state_psnr first, each method in image order. There are none
// of same_state_psnr without such a probe that has a value. `*scores` is owned by the caller (free).
enum vw_status vw_probe_scores_make(const struct vw_probed_run *run, struct vw_probe_score **scores, uint32_t *count);

#endif

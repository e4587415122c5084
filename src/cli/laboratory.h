// The real trainer as a vw_trial_function: device and scene are opened once, effects decided once on the whole scene, and every outcome
// kept in a file of trials, from which an equal trial is recalled.
#ifndef VIEWWORTH_CLI_LABORATORY_H
#define VIEWWORTH_CLI_LABORATORY_H

#include "cli/options.h"
#include "cli/stage.h"
#include "cli/whole_views.h"
#include "viewworth/hash.h"
#include "viewworth/trials.h"

struct vw_laboratory {
    const struct vw_options *options; // borrowed
    struct vw_stage stage;            // may be open before the laboratory is
    bool whole_views;                 // measure whole views, with SSIM, and not an even share of their pixels; false unless set
    struct vw_kept_views kept;        // with whole_views: of which a picture is kept; a trial that lacks one is made again. None unless set
    struct vw_trials *trials;
    uint32_t *train_views, train_count; // scene indices of the photos that may be trained on
    char base_id[VW_HASH_HEX_BYTES];    // of the training on all of them with seed 0
    char scene_hash[VW_HASH_HEX_BYTES];
    uint64_t made, recalled;  // trials so far
    uint64_t planned;         // trials in all, as far as known; for what is said on the way
    double started_s, said_s; // likewise
};

// `laboratory` is zero, but perhaps for its stage. OUT must exist; the trials are in OUT/trials.db. Close it also after a failure.
enum vw_status vw_laboratory_open(const struct vw_options *options, struct vw_laboratory *laboratory);
void vw_laboratory_close(struct vw_laboratory *laboratory);

// The id of a trial, of all that decides its bits: the same on the same device and driver.
void vw_laboratory_name(const struct vw_laboratory *laboratory, const struct vw_trial *trial, char id[VW_HASH_HEX_BYTES]);

// What every photo that may be trained on is: "clean", or what spoils it; `known` tells whether any is said to be either. The array is
// owned by the caller, NULL when memory is short; the texts are the scene's.
const char **vw_laboratory_list_truths(const struct vw_laboratory *laboratory, bool *known);

// A vw_trial_function; `context` is the laboratory. Photos are image_ids of train views. VW_ERROR_INTERRUPTED between two trials when the
// user asked to stop (cli/interrupt.h).
enum vw_status vw_laboratory_try(void *context, const struct vw_trial *trial, struct vw_outcome *outcome);

#endif

// The real trainer as a vw_retrain_function: device and scene are opened once, effects decided once on the whole scene,
// and every outcome kept in a file of retrainings, from which an equal retraining is recalled.
#ifndef VIEWWORTH_LABORATORY_H
#define VIEWWORTH_LABORATORY_H

#include "cli/options.h"
#include "run/session.h"
#include "experiment/whole_views.h"
#include "base/hash.h"
#include "ledger/retrainings.h"

struct vw_retrainer {
    const struct vw_options *options; // borrowed
    struct vw_session session;        // may be open before the retrainer is
    bool whole_views; // measure whole views, with SSIM, and not an even share of their pixels; false unless set
    struct vw_saved_views kept; // with whole_views: of which a picture is kept; a retraining that lacks one is made
                                // again. None unless set
    struct vw_retrainings *retrainings;
    uint32_t *train_views, train_count; // scene indices of the photos that may be trained on
    char base_id[VW_HASH_HEX_BYTES];    // of the training on all of them with seed 0
    char scene_hash[VW_HASH_HEX_BYTES];
    uint64_t made, recalled;  // retrainings so far
    uint64_t planned;         // retrainings in all, as far as known; for what is said on the way
    double started_s, said_s; // likewise
};

// `retrainer` is zero, but perhaps for its session. OUT must exist; the retrainings are in OUT/retrainings.db. Close it
// also after a failure.
enum vw_status vw_retrainer_open(const struct vw_options *options, struct vw_retrainer *retrainer);
void vw_retrainer_close(struct vw_retrainer *retrainer);

// The id of a retraining, of all that decides its bits: the same on the same device and driver.
void vw_retrainer_name(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                       char id[VW_HASH_HEX_BYTES]);

// What every photo that may be trained on is: "clean", or what corrupts it; `known` tells whether any is said to be
// either. The array is owned by the caller, NULL when memory is short; the texts are the scene's.
const char **vw_retrainer_list_labels(const struct vw_retrainer *retrainer, bool *known);

// A vw_retrain_function; `context` is the retrainer. Photos are image_ids of train views. VW_ERROR_INTERRUPTED between
// two retrainings when the user asked to stop (cli/interrupt.h).
enum vw_status vw_retrain(void *context, const struct vw_retrain_params *retraining, struct vw_retrain_result *outcome);

#endif

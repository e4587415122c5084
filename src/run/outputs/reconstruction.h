// The quality of the renders of validation photos at the end of a run, beside that of trivial predictions.
#ifndef VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H
#define VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H

#include "train/trainer.h"
#include "value/verdict.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_reconstruction_params {
    const struct vw_scene *scene;
    struct vw_trainer *trainer; // nothing in flight
    double rays;                // that the renders may use; each photo gets a window of at least SSIM's size
};

// Renders the middle of the validation photos, at most VW_RECONSTRUCTION_VIEWS_MAX of them and whatever their weights,
// and measures those that show something there.
enum { VW_RECONSTRUCTION_VIEWS_MAX = 16 };
enum vw_status vw_reconstruction_measure(const struct vw_reconstruction_params *params,
                                         struct vw_reconstruction *reconstruction);

#endif

// The trained field beside photos that it was not trained on: what the verdict on a run is made of (value/verdict.h).
#ifndef VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H
#define VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H

#include "train/trainer.h"
#include "value/verdict.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// All borrowed for the call.
struct vw_reconstruction_params {
    const struct vw_scene *scene;
    const char *scene_options_json; // that it was opened with (run/session.h)
    struct vw_gpu *gpu;
    struct vw_trainer *trainer; // nothing in flight
};

// Whatever size a run trains at, photos are measured at the same one: as their files have them, divided so often that
// none has a longer side than this.
enum { VW_RECONSTRUCTION_SIDE_PX = 640, VW_RECONSTRUCTION_VIEWS_MAX = 8 };
// Returns that division, a --downscale.
uint32_t vw_reconstruction_downscale(const struct vw_scene *scene, uint32_t trained_downscale);

// Returns the most rays that measuring takes.
double vw_reconstruction_rays(const struct vw_scene *scene, uint32_t trained_downscale);

// Opens the scene at the size that is measured; `*sized` stays NULL if the scene has it. VW_ERROR_INPUT if its photos
// are no longer those of the scene.
enum vw_status vw_reconstruction_open_scene(const struct vw_reconstruction_params *params, struct vw_scene **sized);

// Renders whole test photos, or validation photos where there is no test photo: at most VW_RECONSTRUCTION_VIEWS_MAX,
// evenly spaced in the order of the scene. Photos without a usable pixel do not count, nor do twins: those that the
// nearest train photo shows as well as a copy does.
enum vw_status vw_reconstruction_measure(const struct vw_reconstruction_params *params,
                                         struct vw_reconstruction *reconstruction);

#endif

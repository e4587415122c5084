// reconstruction.json: how near the renders come to the validation photos at the end of a run, beside what trivial
// predictions reach, so that the report can say it without the scene and a device.
#ifndef VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H
#define VIEWWORTH_RUN_OUTPUTS_RECONSTRUCTION_H

#include <jansson.h>
#include <stdint.h>

#include "run/out_files.h"
#include "run/outputs/checksums.h"
#include "train/trainer.h"
#include "value/verdict.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_reconstruction_params {
    const struct vw_scene *scene;
    struct vw_trainer *trainer; // nothing in flight
    double rays;                // that the renders may use; each photo gets a window of at least SSIM's size
    const char *out;
};

// Renders the middle of the validation photos, at most VW_RECONSTRUCTION_VIEWS_MAX of them and whatever their weights,
// measures those that show something there, and writes OUT/reconstruction.json: the object of value/verdict.h, and
// "scene_hash" in hex. Notes the file in `made`.
enum { VW_RECONSTRUCTION_VIEWS_MAX = 16 };
enum vw_status vw_reconstruction_write(const struct vw_reconstruction_params *params, struct vw_checksums *made,
                                       struct vw_reconstruction *reconstruction);

// Checks that the file is of the scene with this hash. VW_ERROR_INPUT names the file and what is wrong; `path` is for
// messages.
enum vw_status vw_reconstruction_check(const char *path, json_t *json, const char *scene_hash, uint32_t image_count);

#endif

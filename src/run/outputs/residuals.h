// residuals.json: photos beside their renders and errors at the end of a run, as small pictures, so that a report can
// show them without the scene and a device.
#ifndef VIEWWORTH_RUN_OUTPUTS_RESIDUALS_H
#define VIEWWORTH_RUN_OUTPUTS_RESIDUALS_H

#include <jansson.h>
#include <stdint.h>

#include "run/out_files.h"
#include "run/outputs/checksums.h"
#include "run/outputs/panes.h"
#include "run/scoring.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// The rays of all pictures are at most this share of the run's own (a train ray counts three times, since it goes back
// as well), or VW_RESIDUALS_RAYS_MIN.
#define VW_RESIDUALS_SHARE 0.05
enum { VW_RESIDUALS_RAYS_MIN = 8192, VW_RESIDUALS_MAX = 256, VW_RESIDUALS_HEIGHT_PX = 72, VW_RESIDUALS_LARGE_PX = 300 };

// Returns the photo's score `quality`; 2: unknown.
double vw_residuals_quality(const struct vw_scoring *scoring, uint32_t view);
double vw_residuals_rays(const struct vw_scoring *scoring, const struct vw_config *config);

struct vw_residuals_params {
    struct vw_panes_params panes;
    const struct vw_scoring *scoring; // scores of the run
    const struct vw_config *config;
    const char *out;
};

// Writes OUT/residuals.json: {"scene_hash": hex, "photos": [{"image": index, "psnr": dB, "picture": base64}, ...]}.
// A picture is a WebP file: photo, render and error (mean over the channels, black to white for 0 to 0.4) side by side,
// each at most VW_RESIDUALS_HEIGHT_PX high. psnr is that of the picture's pixels, null when unknown. The validation
// photos come first, then train photos from the lowest quality up, as many as the share allows. The validation photo in
// the middle by psnr has a picture of up to VW_RESIDUALS_LARGE_PX, for which the share comes before train photos,
// unless its file would be too large; its psnr is still that of the small picture.
// Notes the file in `made`.
enum vw_status vw_residuals_write(const struct vw_residuals_params *params, struct vw_checksums *made);

// Checks that pictures are of `image_count` images of the scene with this hash. VW_ERROR_INPUT names the file and what
// is wrong; `path` is for messages.
enum vw_status vw_residuals_check(const char *path, json_t *residuals, const char *scene_hash, uint32_t image_count);

#endif

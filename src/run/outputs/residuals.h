// residuals.json: photos beside their renders and errors at the end of a run, as small pictures, so that a report can
// show them without the scene and a device.
#ifndef VIEWWORTH_RUN_OUTPUTS_RESIDUALS_H
#define VIEWWORTH_RUN_OUTPUTS_RESIDUALS_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/scoring.h"
#include "train/trainer.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Returns the hash in hex; NULL when memory is short.
json_t *vw_scene_hash_to_json(const struct vw_scene *scene);

// ---- A photo beside its render, both small ----

struct vw_panes_params {
    const struct vw_scene *scene;
    struct vw_trainer *trainer; // nothing in flight
    bool on_background;         // transparent pixels show the background
    bool fitted;                // validation fits a gain and a bias to each view: so do the renders
};

struct vw_panes {
    uint32_t size_px[2]; // size of each
    float *photo;        // rgb, as training sees it
    float *render;
    uint8_t *counts; // by pixel
};

// Makes the panes of a view; `panes` must be all zero. Free them also after a failure.
enum vw_status vw_panes_make(const struct vw_panes_params *params, uint32_t view, uint32_t height_px,
                             struct vw_panes *panes);
void vw_panes_free(struct vw_panes *panes);
// Fits the gain and bias of a channel that bring the render nearest to the photo (least squares), where errors are at
// most `most`; errors of NULL: everywhere. 1 and 0 where nothing tells.
void vw_panes_fit(const struct vw_panes *panes, uint32_t channel, const float *errors, double most, double *gain,
                  double *bias);

// ---- Pictures of them ----

// The rays of all pictures are at most this share of the run's own (a train ray counts three times, since it goes back
// as well), or VW_RESIDUALS_RAYS_MIN.
#define VW_RESIDUALS_SHARE 0.05
enum { VW_RESIDUALS_RAYS_MIN = 8192, VW_RESIDUALS_MAX = 256, VW_RESIDUALS_HEIGHT_PX = 72, VW_RESIDUALS_LARGE_PX = 300 };
enum { VW_RESIDUALS_DIGITS = 6 };

// Returns the photo's score `quality`; 2: unknown.
double vw_residuals_quality(const struct vw_scoring *scoring, uint32_t view);
double vw_residuals_rays(const struct vw_scoring *scoring, const struct vw_config *config);

struct vw_residuals_params {
    struct vw_panes_params panes;
    const struct vw_scoring *scoring; // scores of the run
    const struct vw_config *config;
};

// Makes {"scene_hash": hex, "photos": [{"image": index, "psnr": dB, "picture": base64}, ...]}.
// A picture is a WebP file: photo, render and error (mean over the channels, black to white for 0 to 0.4) side by side,
// each at most VW_RESIDUALS_HEIGHT_PX high. psnr is that of the picture's pixels, null when unknown. The validation
// photos come first, then train photos from the lowest quality up, as many as the share allows. The validation photo in
// the middle by psnr has a picture of up to VW_RESIDUALS_LARGE_PX, for which the share comes before train photos,
// unless its file would be too large; its psnr is still that of the small picture.
// The caller drops the reference, also after a failure; NULL when memory is short.
enum vw_status vw_residuals_make(const struct vw_residuals_params *params, json_t **residuals);

#endif

// A photo beside its render, both small.
#ifndef VIEWWORTH_RUN_OUTPUTS_PANES_H
#define VIEWWORTH_RUN_OUTPUTS_PANES_H

#include <stdbool.h>
#include <stdint.h>

#include "train/trainer.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

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

// Chooses a size of at most `height_px`, and at most four times as wide as high.
void vw_panes_choose_size(const struct vw_image *image, uint32_t height_px, uint32_t size_px[2]);
// Makes the panes of a view; `panes` must be all zero. Free them also after a failure.
enum vw_status vw_panes_make(const struct vw_panes_params *params, uint32_t view, uint32_t height_px,
                             struct vw_panes *panes);
void vw_panes_free(struct vw_panes *panes);

#endif

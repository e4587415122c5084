// Plain data that several parts of the library share: hashes, the pixels of a photo, and step records.
#ifndef VIEWWORTH_TYPES_H
#define VIEWWORTH_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum {
    VW_HASH_BYTES = 32,
    VW_HASH_HEX_BYTES = 65, // 64 hex digits and the terminating zero
};

// Views of a scene. Ranks compare every two photos, so that more would keep a command busy for minutes.
enum { VW_VIEWS_MOST = 1 << 15 };

// Returns whether a number may be the weight of a validation photo: 0, or within bounds in which no mean loses digits.
static inline bool vw_val_weight_is_valid(double weight) { return weight == 0 || (weight >= 1e-3 && weight <= 1e3); }

// ---- Pixels ----

enum vw_pixel_format { VW_PIXEL_UINT8, VW_PIXEL_UINT16, VW_PIXEL_FLOAT32 };

// RGBA, 4 interleaved channels, rows top to bottom, unassociated (straight) alpha, values as stored (sRGB-encoded).
// Alpha is 1 if the file has none. A grey image becomes RGB. Float files contain linear light: they are sRGB-encoded
// when loaded and decoded when saved (decision 10).
struct vw_image {
    uint32_t width_px, height_px;
    enum vw_pixel_format format;
    bool has_alpha;         // some pixel has an alpha below 1
    uint64_t clamped_count; // channel values above 1 that were clamped (float files)
    uint64_t masked_count;  // pixels of the file with a NaN, infinite or negative channel; they have RGBA 0
    uint8_t *unusable; // owned; width_px * height_px bytes, 1 for those pixels; NULL if masked_count is 0. A downscaled
                       // pixel is unusable if at least half of the pixels that it covers are
    void *pixels;      // owned; freed by vw_image_clear. NULL in a view of a scene: not decoded yet (vw_scene_decode)
    bool lent;         // the pixels are their scene's and stay there
};

// ---- Step records ----
//
// The result of one training step. Training hands it to the ledger, and scores are computed from it.

struct vw_view_error {
    double mse; // mean squared error over the view's validation pixels and channels, before the 1e-10 floor
    double l1;  // mean absolute error over the same
};

enum { VW_RECORD_UNTRAINED = UINT32_MAX };

struct vw_step_record {
    uint64_t step;     // 0 is the untrained field
    uint32_t epoch;    // counts from 0; step 0 has epoch 0
    uint32_t view;     // photo trained on, as an index in vw_scene.views; VW_RECORD_UNTRAINED for step 0
    double train_loss; // mean over rays and channels; NaN for step 0
    bool validated;    // false: no validation was asked for, the val_ fields are NaN and `views` is NULL
    bool nonfinite;    // the step was skipped or a validation value is not finite: values are NaN, NULL in the ledger
    uint64_t clamped_count;            // gradient contributions that were clamped to the fixed-point range
    uint32_t floored_views;            // validation views whose MSE is below the floor of 1e-10; they count as 100 dB
    double val_psnr;                   // dB, weighted mean over validation views of their PSNR
    double val_psnr_pooled;            // dB, from the MSE over all validation pixels; NaN for imported steps
    double val_l1;                     // mean absolute error over all validation pixels and channels
    const struct vw_view_error *views; // one per validation view, in scene order; borrowed, valid during the call
    uint32_t view_count;
};

VW_PUBLIC_END

#endif

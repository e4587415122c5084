// The values that travel between the parts of the library: hashes, pixels of a photo, and what a training step leaves
// behind.
#ifndef VIEWWORTH_TYPES_H
#define VIEWWORTH_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum {
    VW_HASH_BYTES = 32,
    VW_HASH_HEX_BYTES = 65, // 64 hex digits and the end
};

// ---- Pixels ----

enum vw_pixel_format { VW_PIXEL_UINT8, VW_PIXEL_UINT16, VW_PIXEL_FLOAT32 };

// RGBA, 4 channels, interleaved, rows top to bottom, unassociated (straight) alpha, values as stored (sRGB-encoded);
// alpha is 1 where the file has none. Grey is spread to RGB. Float files hold linear light and are sRGB-encoded when
// loaded (and decoded when saved).
struct vw_image {
    uint32_t width_px, height_px;
    enum vw_pixel_format format;
    bool has_alpha;         // the file has an alpha channel and some pixel's alpha is below 1
    uint64_t clamped_count; // float input: channel values above 1 that were clamped
    uint64_t masked_count; // pixels of the file with a NaN, infinite or negative channel (design, decision 10): RGBA 0,
                           // and unusable
    uint8_t *unusable; // owned; NULL while masked_count is 0, else width_px * height_px bytes, 1 for those pixels. A
                       // downscaled pixel is unusable when they make up half of what it covers, or more.
    void *pixels; // owned; freed by vw_image_clear
};

// ---- Step records ----
//
// What one training step leaves behind: the only thing that travels from training to the ledger and on to the scores.

struct vw_view_error {
    double mse; // mean squared error over the view's validation pixels and channels, before the 1e-10 floor
    double l1;  // mean absolute error over the same
};

enum { VW_RECORD_UNTRAINED = UINT32_MAX };

// What was measured beside a run's own steps, after which the state is restored: validation after something other than
// the step was done to the state before it (`value --noise-floor`), after a step of any photo from the state behind it
// (--same-state), and how fast validation changes along the step (--first-order).
enum vw_probe_kind {             // those of the noise floor come first
    VW_PROBE_REPEATED,           // nothing: the same validation once more, which must give the same bits
    VW_PROBE_ZERO_LEARNING_RATE, // the step with learning rate 0, which must give the same bits
    VW_PROBE_RESAMPLED,          // the step with other pixels of the same photo: what sampling alone does to its delta
    VW_PROBE_SAME_STATE,         // from the state behind the step, the next step, taken with pixels of the photo `view`
    VW_PROBE_FIRST_ORDER, // values are changes: the measures' derivatives along the step, where it starts, times its
                          // length
    VW_PROBE_KIND_COUNT
};

struct vw_probe {
    uint64_t step;  // the step that was probed
    uint32_t index; // 0, 1, ... within the step
    enum vw_probe_kind kind;
    double val_psnr, val_psnr_pooled, val_l1; // as in vw_step_record; NaN when not finite
    uint32_t view;                            // index in vw_scene.views; VW_RECORD_UNTRAINED: the step's own photo
};

struct vw_step_record {
    uint64_t step;          // 0 is the untrained field
    uint32_t epoch;         // counts from 0; step 0 has epoch 0
    uint32_t view;          // index in vw_scene.views of the photo trained on; VW_RECORD_UNTRAINED for step 0
    double train_loss;      // mean over rays and channels; NaN for step 0
    bool validated;         // false when validation was not asked for: the val_ fields are NaN and `views` is NULL
    bool nonfinite;         // the step was skipped or a validation value is not finite: values are NaN and become NULL
    uint64_t clamped_count; // gradient contributions clamped to the fixed-point range in this step
    uint32_t floored_views; // validation views whose MSE fell below the floor and counts as 100 dB
    double val_psnr;        // dB, mean over validation views of the per-view PSNR, MSE floored at 1e-10 (100 dB)
    double val_psnr_pooled; // dB, of the MSE over all validation pixels; NaN without `views`: not measured (imported
                            // steps)
    double val_l1;          // mean absolute error over all validation pixels and channels
    const struct vw_view_error
        *views; // one per validation view, in scene order; borrowed, valid for the call that passes it
    uint32_t view_count;
    const struct vw_probe
        *probes; // in order of their index; borrowed likewise; NULL and 0 for a step that was not probed
    uint32_t probe_count;
};

VW_PUBLIC_END

#endif

// Paired pilots: short trainings that differ in the effects that they simulate and in nothing else. They take the same
// steps on the same photos and pixels from the same seed, and are scored on the same pixels of train photos that all of
// them leave out; photos of the splits val and test decide nothing. The difference of two pilots is what an effect
// gains. Seed, photos, pixels and steps are fixed, and no decision reads a clock.
#ifndef VIEWWORTH_DETECT_PILOTS_H
#define VIEWWORTH_DETECT_PILOTS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

enum {
    PILOT_RAYS = 64,        // per step of the hash grid, or fewer if the run takes fewer
    PILOT_SPLAT_RAYS = 512, // likewise of splats: two squares
    PILOT_SPLATS = 4096,
    PILOT_FOLDS = 2,       // trainings of each pilot: of another seed each, and without other photos
    PILOT_PHOTOS_MAX = 64, // evenly spaced, so that each is visited a few times, as appearance needs
    PILOT_HELD_OUT_MIN = 4,
    PILOT_HELD_OUT_MAX = PILOT_PHOTOS_MAX / 4,
    PILOTS_MAX = 64,
};

// The photos that a training learns from, and those that judge it: scene indices, ascending.
struct vw_pilot_fold {
    uint32_t train_views[PILOT_PHOTOS_MAX], train_count;
    uint32_t held_out[PILOT_HELD_OUT_MAX], held_out_count;
};

struct vw_pilot {
    uint32_t effects; // a bit for each effect that it simulates, by its place in the registry
    double psnr_db[PILOT_FOLDS][PILOT_HELD_OUT_MAX];       // for the photos held out; NaN if one has no usable pixel
    double plain_psnr_db[PILOT_FOLDS][PILOT_HELD_OUT_MAX]; // the same without a fit of gain and bias
    double ms_per_step;                                    // shown, and decides nothing
    uint64_t device_bytes;
};

struct vw_pilots {
    struct vw_gpu *gpu;           // borrowed
    const struct vw_scene *scene; // borrowed
    struct vw_config config;      // common to all pilots
    uint32_t steps;               // per training
    bool masks;                   // mask files are obeyed
    bool fits;                    // a gain and a bias are fitted to a photo's left half, and its right half is scored
    struct vw_pilot_fold folds[PILOT_FOLDS];
    uint32_t photo_count; // over all folds; 0: too few for a decision
    struct vw_pilot made[PILOTS_MAX];
    uint32_t made_count;
};

struct vw_pilots_params {
    struct vw_gpu *gpu;
    const struct vw_scene *scene;
    const struct vw_config *planned; // the run whose effects are decided: pilots have its loss and background
    uint32_t steps;
    bool masks, fits;
};

// Returns the config of every pilot for a run with the config `planned`: few splats for a run of splats, otherwise a
// small hash grid. A training has its fold's seed.
struct vw_config vw_pilots_config(const struct vw_config *planned, uint32_t steps);
// Chooses the photos.
enum vw_status vw_pilots_open(const struct vw_pilots_params *params, struct vw_pilots *pilots);

// Makes the pilots with these sets of effects that were not made yet, as many together as the device takes at a time.
enum vw_status vw_pilots_make(struct vw_pilots *pilots, const uint32_t *sets, uint32_t count);
// Returns a pilot that was made; NULL when it was not.
const struct vw_pilot *vw_pilots_find(const struct vw_pilots *pilots, uint32_t set);

// The gain of the effects of one pilot over those of another.
struct vw_pilot_gain {
    double mean_db, stderr_db; // over the photos held out; NaN where fewer than two tell
    double low_db;             // a cautious gain, below the mean
    uint32_t photo_count;      // that tell
};
// Compares two pilots. One standard error below the mean is cautious enough: short trainings understate what richer
// fields gain.
struct vw_pilot_gain vw_pilot_gain(const struct vw_pilots *pilots, const struct vw_pilot *with,
                                   const struct vw_pilot *without);
// Returns what a gain and a bias, fitted to the left half of each photo held out, gain on its right half. The field
// learned from other photos, so that it cannot have learned their exposures; photos alone make the error. The cautious
// gain is the lower end of a one-sided 95 % interval (Student's t).
struct vw_pilot_gain vw_pilot_gain_of_fits(const struct vw_pilots *pilots, const struct vw_pilot *pilot);

#endif

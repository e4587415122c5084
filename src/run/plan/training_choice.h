// The field and the size of the photos, for trainings that leave them open (--field auto, --downscale auto).
//
// Splats are trained, and a hash grid where an option or an effect asks for what they lack. On a CPU the photos are
// divided until a training of the level sees each pixel often enough: a field of many more pixels than it is shown
// stays a smear. A GPU trains at the stored size, up to 2 megapixels. Figures: src/lab/results/splats.md.
#ifndef VIEWWORTH_RUN_PLAN_TRAINING_CHOICE_H
#define VIEWWORTH_RUN_PLAN_TRAINING_CHOICE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_training_choice_params {
    struct vw_gpu *gpu;       // borrowed; NULL: there is none, as if it were a CPU
    const char *accuracy;     // the level; NULL: standard
    uint64_t explicit_fields; // numbers of the config that stay: bits of vw_config_explicit()
    bool lasting;             // lasting credit is asked for, which splats lack
};

struct vw_training_choice {
    char field[160], size[160]; // the choice and its reason, a line each; "": it was given
};

// Chooses what is open: config->field where it is VW_FIELD_AUTO, scene->downscale where it is 0. Opens the scene, by
// its headers, for the latter. Logs the lines.
enum vw_status vw_training_choose(const struct vw_training_choice_params *params, struct vw_scene_params *scene,
                                  struct vw_config *config, struct vw_training_choice *choice);

// Returns by how much photos of so many pixels are divided for a training at that level.
uint32_t vw_training_downscale(const char *accuracy, enum vw_gpu_kind device, double pixels);

#endif

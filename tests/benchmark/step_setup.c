#include "benchmark/step_setup.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "interface.h"
#include "train/shared_submissions.h"

static const char USAGE[] =
    "usage: benchmark_step [STEPS] [VALIDATION RAYS] [--run-defaults] [--profile] [--bits |\n"
    "       --describe | --occupancy] [--splats] [scene=PATH] [NAME=NUMBER]...\n"
    "names: steps rounds batch together photos width_px height_px rays samples val_rays levels log2_table width\n"
    "       splats downscale\n"
    "forced: chunk_samples slice_samples slice_parts ray_lanes grid_texel rows_texel skip_zeros draws_pixels\n"
    "        resubmits scatter (0: atomics, 1: split, 2: walk)\n";

void step_setup_print_usage(void) { fputs(USAGE, stderr); }

enum { UNSET = UINT32_MAX }; // a choice that is not forced, but made by the kind of device

static void choose_yardstick(struct setup *setup) {
    struct vw_config *config = &setup->config;
    *config = vw_config_of_field(VW_FIELD_HASH);
    config->epochs = 1000000;
    config->rays = 500, config->samples = 32, config->importance_samples = 0, config->val_rays = 2048;
    config->loss = VW_LOSS_L2;
    config->optimizer = VW_OPTIMIZER_DENSE_ADAM;
    config->beta1 = 0.9;
    config->levels = 8, config->features = 2, config->log2_table = 14, config->base_resolution = 8,
    config->growth = 1.45;
    config->width = 32;
    setup->scene =
        (struct synthetic_scene_params){.train_views = 16, .val_views = 4, .width_px = 160, .height_px = 120};
    setup->steps = 160;
    setup->rounds = 5;
    setup->together = 1;
    setup->real.downscale = 1;
    setup->batch = 8;
    setup->chunk_samples = setup->slice_samples = setup->slice_parts = setup->ray_lanes = UNSET;
    setup->grid_texel = setup->rows_texel = setup->skip_zeros = setup->draws_pixels = setup->scatter = UNSET;
    setup->resubmits = 1;
}

static void choose_run_defaults(struct setup *setup) {
    setup->config = vw_config_of_field(VW_FIELD_HASH);
    setup->config.epochs = 1000000;
}

static void choose_splats(struct setup *setup) {
    setup->config = vw_config_of_field(VW_FIELD_SPLATS);
    setup->config.ssim_weight = 0.0; // as the yardstick
    setup->config.epochs = 1000000;
}

static bool set_flag(struct setup *setup, const char *word) {
    if (!strcmp(word, "--profile")) setup->profile = true;
    else if (!strcmp(word, "--bits")) setup->bits = true;
    else if (!strcmp(word, "--describe")) setup->describe = true;
    else if (!strcmp(word, "--occupancy")) setup->occupancy = true;
    else if (!strcmp(word, "--run-defaults")) choose_run_defaults(setup);
    else if (!strcmp(word, "--splats")) choose_splats(setup);
    else if (!strncmp(word, "scene=", 6)) setup->real.path = word + 6;
    else return false;
    return true;
}

enum { MOST = 100000000 };

static bool set_number(struct setup *setup, const char *name, size_t name_length, const char *text) {
    const struct {
        const char *name;
        uint32_t *value;
        uint32_t least, most;
    } settings[] = {
        {"steps", &setup->steps, 1, MOST},
        {"rounds", &setup->rounds, 1, ROUNDS_MAX},
        {"batch", &setup->batch, 1, MOST},
        {"together", &setup->together, 1, VW_TRAINERS_TOGETHER_MAX},
        {"photos", &setup->scene.train_views, 1, MOST},
        {"width_px", &setup->scene.width_px, 1, MOST},
        {"height_px", &setup->scene.height_px, 1, MOST},
        {"rays", &setup->config.rays, 1, MOST},
        {"samples", &setup->config.samples, 1, MOST},
        {"val_rays", &setup->config.val_rays, 1, MOST},
        {"levels", &setup->config.levels, 1, MOST},
        {"log2_table", &setup->config.log2_table, 1, MOST},
        {"width", &setup->config.width, 1, MOST},
        {"splats", &setup->config.splats, 1, MOST},
        {"downscale", &setup->real.downscale, 1, 64},
        {"chunk_samples", &setup->chunk_samples, VW_FIELD_GROUP, MOST},
        {"slice_samples", &setup->slice_samples, 128, VW_FIELD_GROUP},
        {"slice_parts", &setup->slice_parts, 1, 64},
        {"ray_lanes", &setup->ray_lanes, 1, 32},
        {"grid_texel", &setup->grid_texel, 0, 1},
        {"rows_texel", &setup->rows_texel, 0, 1},
        {"skip_zeros", &setup->skip_zeros, 0, 1},
        {"draws_pixels", &setup->draws_pixels, 0, 1},
        {"resubmits", &setup->resubmits, 0, 1},
        {"scatter", &setup->scatter, SCATTER_ATOMICS, SCATTER_WALK},
    };
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    for (size_t i = 0; i < VW_ARRAY_COUNT(settings) && end != text && !*end; i++) {
        if (strlen(settings[i].name) != name_length || strncmp(settings[i].name, name, name_length)) continue;
        if (number < settings[i].least || number > settings[i].most) return false;
        *settings[i].value = (uint32_t)number;
        return true;
    }
    return false;
}

bool step_setup_read(int argc, char **argv, struct setup *setup) {
    static const char *const bare[] = {"steps", "val_rays"}; // meaning of numbers without a name, in order
    size_t bare_count = 0;
    bool good = true;
    choose_yardstick(setup);
    for (int i = 1; i < argc && good; i++) {
        const char *equals = strchr(argv[i], '=');
        if (set_flag(setup, argv[i])) continue;
        if (equals) good = set_number(setup, argv[i], (size_t)(equals - argv[i]), equals + 1);
        else if (bare_count < VW_ARRAY_COUNT(bare)) {
            good = set_number(setup, bare[bare_count], strlen(bare[bare_count]), argv[i]);
            bare_count++;
        } else good = false;
    }
    return good;
}

struct vw_device_choices step_setup_choose(const struct setup *setup, const struct vw_gpu *gpu) {
    struct vw_device_choices choices;
    vw_device_choose(vw_gpu_get_info(gpu), &choices);
    if (setup->chunk_samples != UNSET) choices.chunk_samples = setup->chunk_samples;
    if (setup->slice_samples != UNSET) choices.slice_samples = setup->slice_samples;
    if (setup->slice_parts != UNSET) choices.slice_parts = setup->slice_parts;
    if (setup->ray_lanes != UNSET) choices.ray_lanes = setup->ray_lanes;
    if (setup->grid_texel != UNSET) choices.grid_texel = setup->grid_texel;
    if (setup->rows_texel != UNSET) choices.rows_texel = setup->rows_texel;
    if (setup->skip_zeros != UNSET) choices.skip_zeros = setup->skip_zeros;
    if (setup->draws_pixels != UNSET) choices.draws_pixels = setup->draws_pixels;
    if (setup->scatter != UNSET) choices.scatter = (enum vw_scatter_form)setup->scatter;
    return choices;
}

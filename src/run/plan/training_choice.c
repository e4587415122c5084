#include "run/plan/training_choice.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "image/pixel.h"
#include "run/plan/accuracy_levels.h"
#include "train/effects/registry.h"
#include "viewworth/log.h"

enum { DOWNSCALE_MOST = 64, WHY_BYTES = 120, OPTION_BYTES = 64 };
static const double GPU_PIXELS = 2.1e6; // 1,920 x 1,080 and a little

// ---- The field -----------------------------------------------------------------------------------------------------

// Returns whether the config can have the field; if not, `option` names what stands against it.
static bool can_have(enum vw_field field, const struct vw_training_choice_params *params,
                     const struct vw_config *config, char option[OPTION_BYTES]) {
    struct vw_config of_field = *config;
    vw_config_take_field(field, params->explicit_fields, &of_field);
    const char *refusal = !vw_effects_suit(config->effects, field) ? "--effects"
                          : vw_config_check(&of_field)             ? vw_error_message()
                                                                   : "";
    snprintf(option, OPTION_BYTES, "%.*s", (int)strcspn(refusal, ": "), refusal);
    return !*refusal;
}

// Returns the field; `why` says why it is not another.
static enum vw_field choose_field(const struct vw_training_choice_params *params, const struct vw_config *config,
                                  char why[WHY_BYTES]) {
    char option[OPTION_BYTES];
    if (!can_have(VW_FIELD_SPLATS, params, config, option)) {
        snprintf(why, WHY_BYTES, "since %s as given is not for splats", option);
        bool only_mlp =
            !can_have(VW_FIELD_HASH, params, config, option) && can_have(VW_FIELD_MLP, params, config, option);
        return only_mlp ? VW_FIELD_MLP : VW_FIELD_HASH;
    }
    bool only_splats = !can_have(VW_FIELD_HASH, params, config, option);
    if (only_splats) snprintf(why, WHY_BYTES, "since %s as given is not for a hash grid", option);
    else if (params->lasting) snprintf(why, WHY_BYTES, "since splats have no lasting credit");
    else snprintf(why, WHY_BYTES, "which are crisper for the same time; --field hash: a hash grid");
    return params->lasting && !only_splats ? VW_FIELD_HASH : VW_FIELD_SPLATS;
}

// ---- The size ------------------------------------------------------------------------------------------------------

uint32_t vw_training_downscale(const char *accuracy, enum vw_gpu_kind device, double pixels) {
    uint32_t level = 0, downscale = 1;
    if (vw_accuracy_find(accuracy ? accuracy : vw_accuracy_standard, &level)) return 1;
    double most = device == VW_GPU_CPU ? vw_accuracy_photo_pixels(level) : GPU_PIXELS;
    while (pixels / downscale / downscale > most && downscale < DOWNSCALE_MOST) downscale++;
    return downscale;
}

// Chooses by the mean over train photos; the line tells the sides of the first.
static void choose_size(const struct vw_training_choice_params *params, const struct vw_scene *scene,
                        uint32_t *downscale, char *line, size_t line_bytes) {
    enum vw_gpu_kind device = params->gpu ? vw_gpu_get_info(params->gpu)->kind : VW_GPU_CPU;
    const struct vw_camera *first = NULL;
    double pixels = 0;
    for (uint32_t v = scene->view_count; v-- > 0;) {
        const struct vw_camera *camera = &scene->views[v].camera;
        if (scene->views[v].split != VW_SPLIT_TRAIN) continue;
        pixels += (double)camera->width_px * camera->height_px / scene->split_count[VW_SPLIT_TRAIN];
        first = camera;
    }
    *downscale = vw_training_downscale(params->accuracy, device, pixels);
    if (!first) return;
    int used = snprintf(line, line_bytes, "%" PRIu32 " x %" PRIu32, vw_downscaled_px(first->width_px, *downscale),
                        vw_downscaled_px(first->height_px, *downscale));
    if (*downscale > 1)
        snprintf(line + used, line_bytes - (size_t)used,
                 ", 1/%" PRIu32 " of the photos' sides; --downscale 1 takes about %" PRIu32
                 " times as long for as good a training",
                 *downscale, *downscale * *downscale);
    else snprintf(line + used, line_bytes - (size_t)used, ", as the photos are stored");
}

// ---- Both ----------------------------------------------------------------------------------------------------------

// Opens the scene as its photos are stored, by its headers.
static enum vw_status open_stored(const struct vw_scene_params *asked, struct vw_scene **scene) {
    struct vw_scene_params stored = *asked;
    stored.headers_only = true;
    stored.downscale = 1;
    stored.corrupt = 0;
    return vw_scene_open(&stored, scene);
}

enum vw_status vw_training_choose(const struct vw_training_choice_params *params, struct vw_scene_params *scene,
                                  struct vw_config *config, struct vw_training_choice *choice) {
    *choice = (struct vw_training_choice){0};
    enum vw_status status = VW_OK;
    if (config->field == VW_FIELD_AUTO) {
        char why[WHY_BYTES];
        vw_config_take_field(choose_field(params, config, why), params->explicit_fields, config);
        snprintf(choice->field, sizeof choice->field, "%s, %s", vw_field_name(config->field), why);
        vw_log_info("field    %s", choice->field);
        status = vw_config_check(config);
    }
    if (status || scene->downscale) return status;
    struct vw_scene *opened = NULL;
    status = open_stored(scene, &opened);
    if (!status) {
        choose_size(params, opened, &scene->downscale, choice->size, sizeof choice->size);
        vw_log_info("size     %s", choice->size);
    }
    vw_scene_close(&opened);
    return status;
}

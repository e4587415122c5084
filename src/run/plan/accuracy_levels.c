#include "run/plan/accuracy_levels.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "viewworth/run.h"

// The parts of a level, by their options.
enum part { RAYS, SAMPLES, PLACED, VAL_RAYS, LOG2_TABLE, LEVELS, WIDTH, EPOCHS, PART_COUNT };
static const char *const parts[PART_COUNT] = {
    "rays", "samples", "importance-samples", "val-rays", "log2-table", "levels", "width", "epochs"};

struct vw_accuracy_level {
    struct vw_accuracy_about about;
    uint32_t volume[PART_COUNT], splats[PART_COUNT]; // without rays: the defaults of the field
    double photo_pixels;                             // most that a photo has, on a CPU
};
const char vw_accuracy_standard[] = "standard";
static const struct vw_accuracy_level levels[] = {
    {{"draft", 0, "less detail, and scores of two seeds agree less"},
     {250, 8, 8, 1024, 14, 8, 32, 24},
     {[RAYS] = 6144, [VAL_RAYS] = 4096, [EPOCHS] = 8},
     9e3},
    {{"quick", 24, "less detail, and ranks that a longer training may change"},
     {250, 16, 16, 1024, 14, 10, 32, 24},
     {[RAYS] = 6144, [VAL_RAYS] = 4096, [EPOCHS] = 15},
     18e3},
    {{vw_accuracy_standard, 45, "less detail, and ranks that a longer training may change"}, {0}, {0}, 25e3},
    {{"reference", 80, ""},
     {500, 32, 64, 2048, 16, 12, 32, 80},
     {[RAYS] = 6144, [VAL_RAYS] = 8192, [EPOCHS] = 120},
     144e3},
};

uint32_t vw_accuracy_level_count(void) { return VW_ARRAY_COUNT(levels); }
const struct vw_accuracy_about *vw_accuracy_level_about(uint32_t level) { return &levels[level].about; }

enum vw_status vw_accuracy_find(const char *name, uint32_t *level) {
    char names[200] = "";
    for (*level = 0; *level < VW_ARRAY_COUNT(levels); ++*level)
        if (strcmp(levels[*level].about.name, name) == 0) return VW_OK;
    for (size_t i = 0, used = 0; i < VW_ARRAY_COUNT(levels); i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", levels[i].about.name);
    return vw_fail(VW_ERROR_USAGE, "--accuracy: \"%s\" is not one of %s", name, names);
}

double vw_accuracy_photo_pixels(uint32_t level) { return levels[level].photo_pixels; }

static uint32_t *part_at(const struct vw_config *config, enum part part) {
    return (uint32_t *)((char *)config + vw_config_find(parts[part])->offset);
}

// Returns whether a level sets it for the config's field. NeRF's network is as wide at every level.
static bool has(const struct vw_config *config, enum part part) {
    return vw_config_find(parts[part])->fields >> config->field & 1 && (part != WIDTH || config->field != VW_FIELD_MLP);
}

static bool is_free(uint64_t explicit_fields, enum part part) {
    return !(explicit_fields & vw_config_explicit(parts[part]));
}

void vw_accuracy_apply(uint32_t level, uint64_t explicit_fields, struct vw_config *config) {
    const uint32_t *values = config->field == VW_FIELD_SPLATS ? levels[level].splats : levels[level].volume;
    const struct vw_config defaults = vw_config_of_field(config->field);
    for (enum part part = 0; part < PART_COUNT; part++)
        if (is_free(explicit_fields, part) && has(config, part))
            *part_at(config, part) = values[RAYS] ? values[part] : *part_at(&defaults, part);
}

void vw_accuracy_copy(const struct vw_config *from, uint64_t explicit_fields, struct vw_config *config) {
    for (enum part part = 0; part < PART_COUNT; part++)
        if (is_free(explicit_fields, part)) *part_at(config, part) = *part_at(from, part);
}

// Estimates the work of a training; a train ray counts three times, since it goes back as well. A pixel of splats
// counts less, since a step draws one photo, and validation every one: without it, a step takes 0.37 to 0.68 of the
// time.
static double work_of(const struct vw_config *config) {
    bool splats = config->field == VW_FIELD_SPLATS;
    double samples = splats ? 1 : config->samples + config->importance_samples, weight = splats ? 1.5 : 3;
    return config->epochs * samples * (weight * config->rays + config->val_rays);
}

double vw_accuracy_most_against(const struct vw_config *config) {
    struct vw_config most = *config;
    vw_accuracy_apply(VW_ARRAY_COUNT(levels) - 1, 0, &most);
    return work_of(&most) / work_of(config);
}

double vw_accuracy_unvalidated_share(const struct vw_config *config) {
    struct vw_config unvalidated = *config;
    unvalidated.val_rays = 0;
    return work_of(&unvalidated) / work_of(config);
}

void vw_accuracy_options(const struct vw_config *config, char text[VW_ACCURACY_TEXT_BYTES]) {
    size_t used = 0;
    for (enum part part = 0; part < PART_COUNT; part++)
        if (has(config, part))
            used += (size_t)snprintf(text + used, VW_ACCURACY_TEXT_BYTES - used, "%s--%s %u", used ? " " : "",
                                     parts[part], *part_at(config, part));
    if (config->decay_epochs && config->decay_epochs != config->epochs)
        snprintf(text + used, VW_ACCURACY_TEXT_BYTES - used, " --decay-epochs %u", config->decay_epochs);
}

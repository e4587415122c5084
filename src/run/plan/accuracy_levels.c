#include "run/plan/accuracy_levels.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "viewworth/run.h"

static const struct vw_accuracy_level levels[] = {
    {"draft", 250, 16, 512, 14, 32, 12, 0,
     "less detail, and scores of two seeds agree less: few rays, samples and epochs"},
    {"quick", 500, 16, 512, 14, 32, 24, 24, "less detail along the rays: half the samples"},
    {"standard", 500, 32, 512, 14, 32, 30, 45, "less detail, and scores from fewer validation pixels: fewer rays"},
    {"reference", 1000, 32, 2048, 14, 32, 60, 90, ""},
};

const struct vw_accuracy_level *vw_accuracy_levels(uint32_t *count) {
    *count = VW_ARRAY_COUNT(levels);
    return levels;
}

const struct vw_accuracy_level *vw_accuracy_find(const char *name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(levels); i++)
        if (strcmp(levels[i].name, name) == 0) return &levels[i];
    return NULL;
}

enum vw_status vw_accuracy_check(const char *name) {
    char names[200] = "";
    if (vw_accuracy_find(name)) return VW_OK;
    for (size_t i = 0, used = 0; i < VW_ARRAY_COUNT(levels); i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", levels[i].name);
    return vw_fail(VW_ERROR_USAGE, "--accuracy: \"%s\" is not one of %s", name, names);
}

// The parts of a level: the option of that name, the bit of vw_run_params.explicit_fields, and the places in the
// level and in the config.
static const struct {
    const char *option;
    uint32_t field;
    size_t here, there;
} parts[] = {
#define PART(option, bit, name)                                                                                        \
    { option, bit, offsetof(struct vw_accuracy_level, name), offsetof(struct vw_config, name) }
    PART("rays", VW_EXPLICIT_RAYS, rays),
    PART("samples", VW_EXPLICIT_SAMPLES, samples),
    PART("val-rays", VW_EXPLICIT_VAL_RAYS, val_rays),
    PART("log2-table", VW_EXPLICIT_LOG2_TABLE, log2_table),
    PART("width", VW_EXPLICIT_WIDTH, width),
    PART("epochs", VW_EXPLICIT_EPOCHS, epochs),
};

static const uint32_t *part_of(const void *whole, size_t offset) {
    return (const uint32_t *)((const char *)whole + offset);
}

// Tells whether a level sets a field of this config: table and width belong to the hash grid, and of splats only the
// length of the training depends on it.
static bool is_of_field(uint32_t field, const struct vw_config *config) {
    if (config->field == VW_FIELD_SPLATS) return field == VW_EXPLICIT_EPOCHS;
    return config->field == VW_FIELD_HASH || !(field & (VW_EXPLICIT_LOG2_TABLE | VW_EXPLICIT_WIDTH));
}

void vw_accuracy_apply(const struct vw_accuracy_level *level, uint32_t explicit_fields, struct vw_config *config) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++)
        if (!(explicit_fields & parts[i].field) && is_of_field(parts[i].field, config))
            *(uint32_t *)((char *)config + parts[i].there) = *part_of(level, parts[i].here);
}

static bool is_shown(uint32_t field, const struct vw_config *config) {
    if (config->field == VW_FIELD_SPLATS) return field & (VW_EXPLICIT_RAYS | VW_EXPLICIT_VAL_RAYS | VW_EXPLICIT_EPOCHS);
    return config->field == VW_FIELD_HASH || field != VW_EXPLICIT_LOG2_TABLE;
}

void vw_accuracy_options(const struct vw_config *config, char text[VW_ACCURACY_TEXT_BYTES]) {
    size_t used = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++)
        if (is_shown(parts[i].field, config))
            used += (size_t)snprintf(text + used, VW_ACCURACY_TEXT_BYTES - used, "%s--%s %u", i ? " " : "",
                                     parts[i].option, *part_of(config, parts[i].there));
}

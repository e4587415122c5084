#include "run/plan/presets.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"

static const struct vw_preset presets[] = {
    {"draft", 250, 16, 512, 14, 32, 12, 0,
     "detail, and part of how well scores of two seeds agree: few rays, samples and epochs"},
    {"quick", 500, 16, 512, 14, 32, 24, 24, "detail along the rays: half the samples"},
    {"standard", 500, 32, 512, 14, 32, 30, 45, "scores as on all validation pixels, and some detail: fewer rays"},
    {"reference", 1000, 32, 2048, 14, 32, 60, 90, ""},
};

const struct vw_preset *vw_presets(uint32_t *count) {
    *count = VW_ARRAY_COUNT(presets);
    return presets;
}

const struct vw_preset *vw_preset_find(const char *name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(presets); i++)
        if (strcmp(presets[i].name, name) == 0) return &presets[i];
    return NULL;
}

// The parts of a preset: the option of that name, and its places in the preset and in the config.
static const struct {
    const char *option;
    size_t here, there;
} parts[] = {
#define PART(option, field)                                                                                            \
    { option, offsetof(struct vw_preset, field), offsetof(struct vw_config, field) }
    PART("rays", rays),   PART("samples", samples), PART("val-rays", val_rays), PART("log2-table", log2_table),
    PART("width", width), PART("epochs", epochs),
};

static const uint32_t *part_of(const void *whole, size_t offset) {
    return (const uint32_t *)((const char *)whole + offset);
}

static void apply(const struct vw_preset *preset, const struct vw_options *options, struct vw_config *config) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++)
        if (!options || !vw_options_have(options, parts[i].option))
            *(uint32_t *)((char *)config + parts[i].there) = *part_of(preset, parts[i].here);
}

void vw_preset_apply(const struct vw_preset *preset, struct vw_config *config) { apply(preset, NULL, config); }

void vw_preset_apply_beside(const struct vw_preset *preset, const struct vw_options *options,
                            struct vw_config *config) {
    apply(preset, options, config);
}

void vw_preset_options(const struct vw_config *config, char text[VW_PRESET_TEXT_BYTES]) {
    size_t used = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++)
        used += (size_t)snprintf(text + used, VW_PRESET_TEXT_BYTES - used, "%s--%s %u", i ? " " : "", parts[i].option,
                                 *part_of(config, parts[i].there));
}

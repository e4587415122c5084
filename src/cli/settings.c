#include "cli/settings.h"

#include <stddef.h>
#include <string.h>

#include "viewworth/memory.h"

static const struct vw_setting settings[] = {
    {"draft", 125, 16, 256, 12, 16, 15, "fine detail, and part of the agreement of scores between seeds"},
    {"quick", 250, 24, 512, 14, 32, 20, "some of the agreement of scores between seeds"},
    {"standard", 500, 32, 512, 14, 32, 30, "the finest detail, and validation on more rays"},
    {"reference", 1000, 64, 2048, 16, 64, 40, ""},
};

const struct vw_setting *vw_settings(uint32_t *count) {
    *count = VW_ARRAY_COUNT(settings);
    return settings;
}

const struct vw_setting *vw_setting_find(const char *name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(settings); i++)
        if (strcmp(settings[i].name, name) == 0) return &settings[i];
    return NULL;
}

void vw_setting_apply(const struct vw_setting *setting, struct vw_config *config) {
    config->rays = setting->rays;
    config->samples = setting->samples;
    config->val_rays = setting->val_rays;
    config->log2_table = setting->log2_table;
    config->width = setting->width;
    config->epochs = setting->epochs;
}

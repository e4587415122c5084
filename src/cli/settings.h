// The ladder of settings by which `value --accuracy` and `--budget` choose, cheapest first.
#ifndef VIEWWORTH_CLI_SETTINGS_H
#define VIEWWORTH_CLI_SETTINGS_H

#include <stdint.h>

#include "cli/options.h"
#include "viewworth/train.h"

struct vw_setting {
    const char *name; // "draft", "standard", "reference", and rungs between
    uint32_t rays, samples, val_rays, log2_table, width, epochs; // as the options of these names
    // What --budget wants to have time for before it chooses the rung: below that, more epochs of the rung before are worth more (README,
    // "What accuracy costs in time").
    uint32_t budget_epochs;
    const char *gives_up; // one line: what it gives up against the next; "" for the dearest
};

// "standard" is exactly vw_config_default.
const struct vw_setting *vw_settings(uint32_t *count);
const struct vw_setting *vw_setting_find(const char *name); // NULL when there is none
// Sets what a setting sets, and leaves the rest of the config alone.
void vw_setting_apply(const struct vw_setting *setting, struct vw_config *config);
// The same with what the command line gives itself, which wins.
void vw_setting_apply_beside(const struct vw_setting *setting, const struct vw_options *options, struct vw_config *config);
// The options that set what a setting sets, as the config has it: "--rays 125 --samples 16 ... --epochs 15".
enum { VW_SETTING_TEXT_BYTES = 200 };
void vw_setting_options(const struct vw_config *config, char text[VW_SETTING_TEXT_BYTES]);

#endif

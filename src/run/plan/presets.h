// The ladder of presets by which `value --accuracy` and `--budget` choose, cheapest first.
#ifndef VIEWWORTH_SETTINGS_H
#define VIEWWORTH_SETTINGS_H

#include <stdint.h>

#include "cli/options.h"
#include "viewworth/train.h"

struct vw_preset {
    const char *name; // "draft", "standard", "reference", and candidates between
    uint32_t rays, samples, val_rays, log2_table, width, epochs; // as the options of these names
    // What --budget wants to have time for before it chooses the candidate: below that, more epochs of the candidate
    // before are worth more (README, "What accuracy costs in time").
    uint32_t budget_epochs;
    const char *trade_off; // one line: what it gives up against the next; "" for the dearest
};

// "standard" is exactly vw_config_default.
const struct vw_preset *vw_presets(uint32_t *count);
const struct vw_preset *vw_preset_find(const char *name); // NULL when there is none
// Sets what a preset sets, and leaves the rest of the config alone.
void vw_preset_apply(const struct vw_preset *preset, struct vw_config *config);
// The same with what the command line gives itself, which wins.
void vw_preset_apply_beside(const struct vw_preset *preset, const struct vw_options *options, struct vw_config *config);
// The options that set what a preset sets, as the config has it: "--rays 125 --samples 16 ... --epochs 15".
enum { VW_PRESET_TEXT_BYTES = 200 };
void vw_preset_options(const struct vw_config *config, char text[VW_PRESET_TEXT_BYTES]);

#endif

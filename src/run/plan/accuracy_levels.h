// The accuracy levels that --accuracy and --budget choose from, cheapest first.
#ifndef VIEWWORTH_RUN_PLAN_ACCURACY_LEVELS_H
#define VIEWWORTH_RUN_PLAN_ACCURACY_LEVELS_H

#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_accuracy_level {
    const char *name;                                            // "draft", "quick", "standard", "reference"
    uint32_t rays, samples, val_rays, log2_table, width, epochs; // as the options of these names
    // --budget chooses the level only if there is time for so many epochs: with fewer, more epochs of the next cheaper
    // level are worth more.
    uint32_t budget_epochs;
    const char *trade_off; // one line: what it loses against the next; "" for the most expensive one
};

// Lists the levels; "standard" is exactly vw_config_default.
const struct vw_accuracy_level *vw_accuracy_levels(uint32_t *count);
const struct vw_accuracy_level *vw_accuracy_find(const char *name); // NULL when there is none
enum vw_status vw_accuracy_check(const char *name);                 // VW_ERROR_USAGE lists the names
// Sets what a level sets, except for explicit fields (VW_EXPLICIT_*), and leaves the rest of the config alone.
void vw_accuracy_apply(const struct vw_accuracy_level *level, uint32_t explicit_fields, struct vw_config *config);
// The options that set the same fields to the values in the config: "--rays 125 --samples 16 ... --epochs 15".
enum { VW_ACCURACY_TEXT_BYTES = 200 };
void vw_accuracy_options(const struct vw_config *config, char text[VW_ACCURACY_TEXT_BYTES]);

#endif

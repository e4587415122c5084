// The accuracy levels that --accuracy and --budget choose from, cheapest first, by their index.
#ifndef VIEWWORTH_RUN_PLAN_ACCURACY_LEVELS_H
#define VIEWWORTH_RUN_PLAN_ACCURACY_LEVELS_H

#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_accuracy_about {
    const char *name; // "draft", "quick", "standard", "reference"
    // --budget chooses the level only if there is time for so many epochs: with fewer, more epochs of the next cheaper
    // level are worth more.
    uint32_t budget_epochs;
    const char *trade_off; // one line: what it loses against the next; "" for the most expensive one
};

extern const char vw_accuracy_standard[]; // the level of who names none
uint32_t vw_accuracy_level_count(void);
const struct vw_accuracy_about *vw_accuracy_level_about(uint32_t level);
enum vw_status vw_accuracy_find(const char *name, uint32_t *level); // VW_ERROR_USAGE lists the names
// Returns the most pixels of a photo that a training at that level on a CPU sees often enough.
double vw_accuracy_photo_pixels(uint32_t level);
// Sets what a level sets for the config's field, except for explicit fields (vw_config_explicit()), and leaves the rest
// of the config alone. "standard" sets what vw_config_of_field() has.
void vw_accuracy_apply(uint32_t level, uint64_t explicit_fields, struct vw_config *config);
// Sets the same to the values of another config.
void vw_accuracy_copy(const struct vw_config *from, uint64_t explicit_fields, struct vw_config *config);
// Returns how many times as long the most expensive level would train as the config does, by their rays, samples and
// epochs; at most 1 if the config costs as much.
double vw_accuracy_most_against(const struct vw_config *config);
// Returns the share of the time of a training that it would take without validation, likewise.
double vw_accuracy_unvalidated_share(const struct vw_config *config);
// The options that set the same fields to the values in the config: "--rays 125 --samples 16 ... --epochs 15".
enum { VW_ACCURACY_TEXT_BYTES = 240 };
void vw_accuracy_options(const struct vw_config *config, char text[VW_ACCURACY_TEXT_BYTES]);

#endif

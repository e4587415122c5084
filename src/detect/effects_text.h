// The decisions on effects as one line, as a table for people, and as the JSON of run.effects_json.
#ifndef VIEWWORTH_DETECT_EFFECTS_TEXT_H
#define VIEWWORTH_DETECT_EFFECTS_TEXT_H

#include <jansson.h>
#include <stdint.h>

#include "viewworth/train.h"

enum { VW_EFFECT_LINE_BYTES = 640 };

// Writes which effects are on and why, and which were tried: "distortion (files), unbounded (+2.2 dB); tried: sky".
void vw_effects_to_line(const struct vw_effect_decision *decisions, uint32_t count, char line[VW_EFFECT_LINE_BYTES]);
extern const char vw_effects_heading[];
// Writes one line of the table, without its end.
void vw_effect_to_line(const struct vw_effect_decision *decision, char line[VW_EFFECT_LINE_BYTES]);
// Returns [{name, called_for, evidence, evidence_stderr, evidence_low, threshold, meaning, on, ms_per_step,
// device_bytes, measured_on}]; null for unknown values. NULL when memory is short.
json_t *vw_effects_to_json(const struct vw_effect_decision *decisions, uint32_t count);
// Reads the decisions of a ledger (run.effects_json), in the order of the effects known today; effects that it does not
// name are off.
enum vw_status vw_effects_from_json(const char *json, struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX],
                                    uint32_t *count);

#endif

#include "detect/effects_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/json.h"
#include "base/rows.h"

// Appends a name to a list, with its reason; the first one after `lead`.
static void append(char line[VW_EFFECT_LINE_BYTES], bool *any, const char *lead, const char *name, const char *reason) {
    size_t used = strlen(line);
    snprintf(line + used, VW_EFFECT_LINE_BYTES - used, "%s%s%s", *any ? ", " : lead, name, reason);
    *any = true;
}

static void write_reason(const struct vw_effect_decision *decision, char reason[32]) {
    bool measured = isfinite(decision->evidence_stderr);
    if (!decision->called_for) snprintf(reason, 32, " (--effects)");
    else if (measured) snprintf(reason, 32, " (%+.1f dB)", decision->evidence);
    else snprintf(reason, 32, " (files)");
}

void vw_effects_to_line(const struct vw_effect_decision *decisions, uint32_t count, char line[VW_EFFECT_LINE_BYTES]) {
    bool any_on = false, any_off = false, any_tried = false;
    line[0] = 0;
    for (uint32_t i = 0; i < count; i++) {
        char reason[32];
        write_reason(&decisions[i], reason);
        if (decisions[i].on) append(line, &any_on, "", decisions[i].name, reason);
    }
    if (!any_on) snprintf(line, VW_EFFECT_LINE_BYTES, "none");
    for (uint32_t i = 0; i < count; i++)
        if (decisions[i].called_for && !decisions[i].on)
            append(line, &any_off, "; called for, but off: ", decisions[i].name, "");
    for (uint32_t i = 0; i < count; i++)
        if (!decisions[i].called_for && !decisions[i].on && isfinite(decisions[i].evidence_stderr))
            append(line, &any_tried, "; tried: ", decisions[i].name, "");
}

const char vw_effects_heading[] =
    "effect             on   called for  evidence          threshold  ms per step  bytes      which is";

void vw_effect_to_line(const struct vw_effect_decision *decision, char line[VW_EFFECT_LINE_BYTES]) {
    char evidence[32] = "unknown", threshold[16] = "", cost_ms[16] = "", cost_bytes[16] = "";
    if (isfinite(decision->evidence)) snprintf(evidence, sizeof evidence, "%.2f", decision->evidence);
    if (isfinite(decision->evidence_stderr))
        snprintf(evidence, sizeof evidence, "%+.2f +- %.2f", decision->evidence, decision->evidence_stderr);
    if (isfinite(decision->threshold))
        snprintf(threshold, sizeof threshold, decision->threshold < 0.01 ? "above 0" : "%.2f", decision->threshold);
    if (isfinite(decision->ms_per_step)) snprintf(cost_ms, sizeof cost_ms, "%+.2g", decision->ms_per_step);
    if (isfinite(decision->device_bytes)) snprintf(cost_bytes, sizeof cost_bytes, "%+.0f", decision->device_bytes);
    snprintf(line, VW_EFFECT_LINE_BYTES, "%-18s %-4s %-11s %-17s %-10s %-12s %-10s %s%s%s", decision->name,
             decision->on ? "yes" : "no", decision->called_for ? "yes" : "no", evidence, threshold, cost_ms, cost_bytes,
             decision->meaning, decision->measured_on[0] ? "; " : "", decision->measured_on);
}

// ---- JSON ----

static const struct vw_column columns[] = {
    VW_COLUMN(struct vw_effect_decision, TEXT, name),
    VW_COLUMN(struct vw_effect_decision, FLAG, called_for),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, evidence),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, evidence_stderr),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, evidence_low),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, threshold),
    VW_COLUMN(struct vw_effect_decision, TEXT, meaning),
    VW_COLUMN(struct vw_effect_decision, FLAG, on),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, ms_per_step),
    VW_COLUMN(struct vw_effect_decision, REAL_OR_NULL, device_bytes),
    VW_COLUMN(struct vw_effect_decision, CHARS, measured_on),
};

json_t *vw_effects_to_json(const struct vw_effect_decision *decisions, uint32_t count) {
    const struct vw_rows rows = VW_ROWS(columns, decisions, count);
    return vw_rows_to_json(&rows);
}

// Reads a flag or a number; NaN for null, and for keys that older ledgers lack.
static void read_cell(const json_t *entry, const struct vw_column *column, struct vw_effect_decision *decision) {
    const json_t *value = json_object_get(entry, column->name);
    void *member = (char *)decision + column->offset;
    if (column->kind == VW_COLUMN_FLAG) *(bool *)member = json_is_true(value);
    else if (column->kind == VW_COLUMN_REAL_OR_NULL)
        *(double *)member = json_is_number(value) ? json_number_value(value) : NAN;
}

static enum vw_status read_decision(const json_t *entry, struct vw_effect_decision *decisions, uint32_t count) {
    const char *name = json_string_value(json_object_get(entry, "name"));
    const char *measured_on = json_string_value(json_object_get(entry, "measured_on"));
    struct vw_effect_decision *decision = name ? vw_effects_find(decisions, count, name) : NULL;
    if (!name) return vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger: an entry has no name");
    if (!decision)
        return vw_fail(VW_ERROR_INPUT,
                       "run.effects_json of the ledger: \"%s\" is not an effect of this version; use a newer one",
                       name);
    for (size_t c = 0; c < VW_ARRAY_COUNT(columns); c++) read_cell(entry, &columns[c], decision);
    snprintf(decision->measured_on, sizeof decision->measured_on, "%s", measured_on ? measured_on : "");
    return VW_OK;
}

enum vw_status vw_effects_from_json(const char *json, struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX],
                                    uint32_t *count) {
    json_error_t error;
    json_t *array = vw_json_load(json, strlen(json), 0, &error);
    enum vw_status status =
        json_is_array(array) ? VW_OK : vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger is not a JSON array");
    vw_effects_list(decisions, count);
    for (size_t i = 0; !status && i < json_array_size(array); i++)
        status = read_decision(json_array_get(array, i), decisions, *count);
    json_decref(array);
    return status;
}

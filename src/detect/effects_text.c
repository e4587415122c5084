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

static void write_reason(const struct vw_effect_verdict *verdict, char reason[32]) {
    bool measured = isfinite(verdict->evidence_stderr);
    if (!verdict->called_for) snprintf(reason, 32, " (--effects)");
    else if (measured) snprintf(reason, 32, " (%+.1f dB)", verdict->evidence);
    else snprintf(reason, 32, " (files)");
}

void vw_effects_to_line(const struct vw_effect_verdict *verdicts, uint32_t count, char line[VW_EFFECT_LINE_BYTES]) {
    bool any_on = false, any_off = false, any_tried = false;
    line[0] = 0;
    for (uint32_t i = 0; i < count; i++) {
        char reason[32];
        write_reason(&verdicts[i], reason);
        if (verdicts[i].on) append(line, &any_on, "", verdicts[i].name, reason);
    }
    if (!any_on) snprintf(line, VW_EFFECT_LINE_BYTES, "none");
    for (uint32_t i = 0; i < count; i++)
        if (verdicts[i].called_for && !verdicts[i].on)
            append(line, &any_off, "; called for, but off: ", verdicts[i].name, "");
    for (uint32_t i = 0; i < count; i++)
        if (!verdicts[i].called_for && !verdicts[i].on && isfinite(verdicts[i].evidence_stderr))
            append(line, &any_tried, "; tried: ", verdicts[i].name, "");
}

const char vw_effects_heading[] =
    "effect             on   called for  evidence          threshold  ms per step  bytes      which is";

void vw_effect_to_line(const struct vw_effect_verdict *verdict, char line[VW_EFFECT_LINE_BYTES]) {
    char evidence[32] = "unknown", threshold[16] = "", cost_ms[16] = "", cost_bytes[16] = "";
    if (isfinite(verdict->evidence)) snprintf(evidence, sizeof evidence, "%.2f", verdict->evidence);
    if (isfinite(verdict->evidence_stderr))
        snprintf(evidence, sizeof evidence, "%+.2f +- %.2f", verdict->evidence, verdict->evidence_stderr);
    if (isfinite(verdict->threshold))
        snprintf(threshold, sizeof threshold, verdict->threshold < 0.01 ? "above 0" : "%.2f", verdict->threshold);
    if (isfinite(verdict->ms_per_step)) snprintf(cost_ms, sizeof cost_ms, "%+.2g", verdict->ms_per_step);
    if (isfinite(verdict->device_bytes)) snprintf(cost_bytes, sizeof cost_bytes, "%+.0f", verdict->device_bytes);
    snprintf(line, VW_EFFECT_LINE_BYTES, "%-18s %-4s %-11s %-17s %-10s %-12s %-10s %s%s%s", verdict->name,
             verdict->on ? "yes" : "no", verdict->called_for ? "yes" : "no", evidence, threshold, cost_ms, cost_bytes,
             verdict->meaning, verdict->measured_on[0] ? "; " : "", verdict->measured_on);
}

// ---- JSON ----

static const struct vw_column columns[] = {
    VW_COLUMN(struct vw_effect_verdict, TEXT, name),
    VW_COLUMN(struct vw_effect_verdict, FLAG, called_for),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, evidence),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, evidence_stderr),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, evidence_low),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, threshold),
    VW_COLUMN(struct vw_effect_verdict, TEXT, meaning),
    VW_COLUMN(struct vw_effect_verdict, FLAG, on),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, ms_per_step),
    VW_COLUMN(struct vw_effect_verdict, REAL_OR_NULL, device_bytes),
    VW_COLUMN(struct vw_effect_verdict, CHARS, measured_on),
};

json_t *vw_effects_to_json(const struct vw_effect_verdict *verdicts, uint32_t count) {
    const struct vw_rows rows = VW_ROWS(columns, verdicts, count);
    return vw_rows_to_json(&rows);
}

// Reads a flag or a number; NaN for null, and for keys that older ledgers lack.
static void read_cell(const json_t *entry, const struct vw_column *column, struct vw_effect_verdict *verdict) {
    const json_t *value = json_object_get(entry, column->name);
    void *member = (char *)verdict + column->offset;
    if (column->kind == VW_COLUMN_FLAG) *(bool *)member = json_is_true(value);
    else if (column->kind == VW_COLUMN_REAL_OR_NULL)
        *(double *)member = json_is_number(value) ? json_number_value(value) : NAN;
}

static enum vw_status read_verdict(const json_t *entry, struct vw_effect_verdict *verdicts, uint32_t count) {
    const char *name = json_string_value(json_object_get(entry, "name"));
    const char *measured_on = json_string_value(json_object_get(entry, "measured_on"));
    struct vw_effect_verdict *verdict = name ? vw_effects_find(verdicts, count, name) : NULL;
    if (!name) return vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger: an entry has no name");
    if (!verdict)
        return vw_fail(VW_ERROR_INPUT,
                       "run.effects_json of the ledger: \"%s\" is not an effect of this version; use a newer one",
                       name);
    for (size_t c = 0; c < VW_ARRAY_COUNT(columns); c++) read_cell(entry, &columns[c], verdict);
    snprintf(verdict->measured_on, sizeof verdict->measured_on, "%s", measured_on ? measured_on : "");
    return VW_OK;
}

enum vw_status vw_effects_from_json(const char *json, struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX],
                                    uint32_t *count) {
    json_error_t error;
    json_t *array = vw_json_load(json, strlen(json), 0, &error);
    enum vw_status status =
        json_is_array(array) ? VW_OK : vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger is not a JSON array");
    vw_effects_list(verdicts, count);
    for (size_t i = 0; !status && i < json_array_size(array); i++)
        status = read_verdict(json_array_get(array, i), verdicts, *count);
    json_decref(array);
    return status;
}

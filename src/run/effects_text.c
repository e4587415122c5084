#include "run/effects_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/json.h"

const char vw_effects_heading[] = "effect          on   called for  evidence   threshold  which is";

void vw_effect_to_line(const struct vw_effect_verdict *verdict, char line[VW_EFFECT_LINE_BYTES]) {
    char evidence[32] = "unknown";
    if (isfinite(verdict->evidence)) snprintf(evidence, sizeof evidence, "%.4g", verdict->evidence);
    snprintf(line, VW_EFFECT_LINE_BYTES, "%-15s %-4s %-11s %-10s %-10.4g %s", verdict->name, verdict->on ? "yes" : "no",
             verdict->called_for ? "yes" : "no", evidence, verdict->threshold, verdict->meaning);
}

json_t *vw_effects_to_json(const struct vw_effect_verdict *verdicts, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_effect_verdict *verdict = &verdicts[i];
        vw_json_append(&array,
                       json_pack("{s:s, s:b, s:o, s:o, s:s, s:b}", "name", verdict->name, "called_for",
                                 verdict->called_for, "evidence", vw_json_real(verdict->evidence), "threshold",
                                 vw_json_real(verdict->threshold), "meaning", verdict->meaning, "on", verdict->on));
    }
    return array;
}

static struct vw_effect_verdict *find(struct vw_effect_verdict *verdicts, uint32_t count, const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(verdicts[i].name, name) == 0) return &verdicts[i];
    return NULL;
}

static enum vw_status read_verdict(const json_t *entry, struct vw_effect_verdict *verdicts, uint32_t count) {
    const char *name = json_string_value(json_object_get(entry, "name"));
    const json_t *evidence = json_object_get(entry, "evidence"), *threshold = json_object_get(entry, "threshold");
    struct vw_effect_verdict *verdict = name ? find(verdicts, count, name) : NULL;
    if (!name) return vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger: an entry has no name");
    if (!verdict)
        return vw_fail(VW_ERROR_INPUT,
                       "run.effects_json of the ledger: \"%s\" is no effect of this version; use a newer one", name);
    verdict->called_for = json_is_true(json_object_get(entry, "called_for"));
    verdict->on = json_is_true(json_object_get(entry, "on"));
    verdict->evidence = json_is_number(evidence) ? json_number_value(evidence) : NAN;
    if (json_is_number(threshold)) verdict->threshold = json_number_value(threshold);
    return VW_OK;
}

enum vw_status vw_effects_from_json(const char *json, struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX],
                                    uint32_t *count) {
    json_error_t error;
    json_t *array = vw_json_load(json, strlen(json), 0, &error);
    enum vw_status status =
        json_is_array(array) ? VW_OK : vw_fail(VW_ERROR_INPUT, "run.effects_json of the ledger is no JSON array");
    vw_effects_list(verdicts, count);
    for (size_t i = 0; !status && i < json_array_size(array); i++)
        status = read_verdict(json_array_get(array, i), verdicts, *count);
    json_decref(array);
    return status;
}

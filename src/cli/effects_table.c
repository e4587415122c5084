#include "cli/effects_table.h"

#include <stdio.h>

#include "cli/json_output.h"

const char vw_effects_heading[] = "effect         on   called for  evidence   threshold  which is";

void vw_effect_to_line(const struct vw_effect_verdict *verdict, char line[VW_EFFECT_LINE_BYTES]) {
    snprintf(line, VW_EFFECT_LINE_BYTES, "%-14s %-4s %-11s %-10.4g %-10.4g %s", verdict->name, verdict->on ? "yes" : "no",
             verdict->called_for ? "yes" : "no", verdict->evidence, verdict->threshold, verdict->meaning);
}

json_t *vw_effects_to_json(const struct vw_effect_verdict *verdicts, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; array && i < count; i++) {
        const struct vw_effect_verdict *verdict = &verdicts[i];
        json_t *entry = json_pack("{s:s, s:b, s:o, s:o, s:s, s:b}", "name", verdict->name, "called_for", verdict->called_for, "evidence",
                                  vw_json_real(verdict->evidence), "threshold", vw_json_real(verdict->threshold), "meaning",
                                  verdict->meaning, "on", verdict->on);
        if (json_array_append_new(array, entry)) {
            json_decref(array);
            array = NULL;
        }
    }
    return array;
}

#include "cli/output/plan_output.h"
#include "cli/output/print.h"

#include "base/clock.h"
#include "run/plan/accuracy_levels.h"

void vw_plan_print(const struct vw_plan *plan, const struct vw_config *config) {
    char text[VW_PRESET_TEXT_BYTES];
    vw_preset_options(config, text);
    if (vw_plan_keeps_time(plan))
        vw_print("budget   %g s; this command took %.1f s\n", plan->budget_s, vw_now_s() - plan->started_s);
    vw_print("again    the same bits by %s\n", text);
}

bool vw_plan_add_json(const struct vw_plan *plan, const struct vw_config *config, json_t *root) {
    char text[VW_PRESET_TEXT_BYTES];
    vw_preset_options(config, text);
    json_t *object = json_pack("{s:f, s:s}", "took_s", vw_now_s() - plan->started_s, "options", text);
    bool failed = !object || json_object_update_missing(object, plan->record);
    failed |= json_object_set_new(root, json_object_get(plan->record, "budget_s") ? "budget" : "accuracy", object) != 0;
    return !failed;
}

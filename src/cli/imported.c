#include "cli/imported.h"

#include <jansson.h>
#include <string.h>

const char vw_imported_device[] = "imported";

bool vw_is_imported(const struct vw_ledger_run *run) { return strcmp(run->device, vw_imported_device) == 0; }

char *vw_imported_config_to_json(const struct vw_config *config) {
    json_t *object = json_pack("{s:f, s:I, s:I}", "beta1", config->beta1, "burn_in_epochs", (json_int_t)config->burn_in_epochs, "epochs",
                               (json_int_t)config->epochs);
    char *text = object ? json_dumps(object, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
    json_decref(object);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the configuration's JSON");
    return text;
}

enum vw_status vw_imported_config_from_json(const char *json, struct vw_config *config) {
    struct vw_config parsed = vw_config_default;
    json_int_t burn_in_epochs = 0, epochs = 0;
    json_error_t error;
    json_t *object = json_loads(json, 0, &error);
    enum vw_status status = VW_OK;
    if (!object || json_unpack_ex(object, &error, JSON_STRICT, "{s:F, s:I, s:I}", "beta1", &parsed.beta1, "burn_in_epochs", &burn_in_epochs,
                                  "epochs", &epochs))
        status = vw_fail(VW_ERROR_INPUT, "config of an imported run: %s", error.text);
    json_decref(object);
    parsed.burn_in_epochs = (uint32_t)burn_in_epochs;
    parsed.epochs = (uint32_t)epochs;
    if (!status) status = vw_config_check(&parsed);
    if (!status) *config = parsed;
    return status;
}

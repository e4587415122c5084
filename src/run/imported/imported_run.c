#include "run/imported/imported_run.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"

const char vw_imported_device[] = "imported";

void vw_imported_run_id(const char *log_sha256, const struct vw_config *config, char run_id[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, log_sha256);
    vw_hasher_add_integer(&hasher, config->burn_in_epochs);
    vw_hasher_add_integer(&hasher, config->epochs);
    vw_hasher_add_real(&hasher, config->beta1);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, run_id);
}

bool vw_is_imported(const struct vw_ledger_run *run) { return strcmp(run->device, vw_imported_device) == 0; }

char *vw_imported_config_to_json(const struct vw_config *config) {
    json_t *object = json_pack("{s:f, s:I, s:I}", "beta1", config->beta1, "burn_in_epochs",
                               (json_int_t)config->burn_in_epochs, "epochs", (json_int_t)config->epochs);
    char *text = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the config's JSON");
    return text;
}

enum vw_status vw_imported_config_from_json(const char *json, struct vw_config *config) {
    struct vw_config parsed = vw_config_default;
    json_int_t burn_in_epochs = 0, epochs = 0;
    json_error_t error;
    json_t *object = vw_json_load(json, strlen(json), 0, &error);
    enum vw_status status = VW_OK;
    if (!object || json_unpack_ex(object, &error, JSON_STRICT, "{s:F, s:I, s:I}", "beta1", &parsed.beta1,
                                  "burn_in_epochs", &burn_in_epochs, "epochs", &epochs))
        status = vw_fail(VW_ERROR_INPUT, "config of an imported run: %s", error.text);
    json_decref(object);
    parsed.burn_in_epochs = (uint32_t)burn_in_epochs;
    parsed.epochs = (uint32_t)epochs;
    if (!status) status = vw_config_check(&parsed);
    if (!status) *config = parsed;
    return status;
}

char *vw_imported_options_to_json(const char *log_sha256, uint64_t validated_every) {
    char *text = validated_every ? vw_format_text("{\"log_sha256\":\"%s\",\"validated_every\":%" PRIu64 "}", log_sha256,
                                                  validated_every)
                                 : vw_format_text("{\"log_sha256\":\"%s\"}", log_sha256);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the log's hash");
    return text;
}

enum vw_status vw_imported_log_sha256(const struct vw_ledger_run *run, char log_sha256[VW_HASH_HEX_BYTES]) {
    json_error_t error;
    json_t *object = vw_json_load(run->scene_options_json, strlen(run->scene_options_json), 0, &error);
    const char *recorded = json_string_value(json_object_get(object, "log_sha256"));
    enum vw_status status = VW_OK;
    if (recorded && strlen(recorded) == VW_HASH_HEX_BYTES - 1) memcpy(log_sha256, recorded, VW_HASH_HEX_BYTES);
    else
        status = vw_fail(VW_ERROR_INPUT,
                         "run.scene_options_json of an imported run: log_sha256 is not a hash; import the log again");
    json_decref(object);
    return status;
}

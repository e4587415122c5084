#include "experiment/sweep/store.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/json.h"
#include "viewworth/log.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 24;

// Hashes the values as they are written.
static bool hash_values(const json_t *values, char hex[VW_HASH_HEX_BYTES]) {
    char *text = vw_json_to_text(values, JSON_COMPACT | JSON_SORT_KEYS);
    uint8_t hash[VW_HASH_BYTES];
    struct vw_hasher hasher;
    if (!text) return false;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth measurements 1");
    vw_hasher_add_text(&hasher, text);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, hex);
    free(text);
    return true;
}

// Returns the values of a whole file, owned by the caller; NULL for a damaged one.
static json_t *read_values(const char *path, const char *text, size_t size_bytes) {
    json_t *root = NULL, *values = NULL;
    const char *checksum = "";
    char hex[VW_HASH_HEX_BYTES];
    bool whole = !vw_json_parse(path, text, size_bytes, &root) &&
                 !json_unpack(root, "{s:s, s:o}", "checksum", &checksum, "measurements", &values) &&
                 json_is_object(values) && hash_values(values, hex) && !strcmp(hex, checksum);
    values = whole ? json_incref(values) : NULL;
    json_decref(root);
    return values;
}

enum vw_status vw_sweep_store_open(const char *out, struct vw_sweep_store *store) {
    void *text = NULL;
    size_t size_bytes = 0;
    *store = (struct vw_sweep_store){.path = vw_path_join(out, "measurements.json")};
    if (!store->path) return VW_ERROR_MEMORY;
    if (vw_file_exists(store->path)) {
        enum vw_status status = vw_file_read(store->path, FILE_LIMIT_BYTES, &text, &size_bytes);
        if (status) return status;
        store->values = read_values(store->path, text, size_bytes);
        if (!store->values) vw_log_warning("%s: is damaged: everything is measured again", store->path);
    }
    free(text);
    if (!store->values) store->values = json_object();
    return store->values ? VW_OK : VW_ERROR_MEMORY;
}

void vw_sweep_store_close(struct vw_sweep_store *store) {
    json_decref(store->values);
    free(store->path);
}

bool vw_sweep_store_find(const struct vw_sweep_store *store, const char *configuration_id, const char *quantity,
                         double *value) {
    const json_t *found = json_object_get(json_object_get(store->values, configuration_id), quantity);
    if (found) *value = json_is_number(found) ? json_number_value(found) : NAN;
    return found;
}

void vw_sweep_store_set(struct vw_sweep_store *store, const char *configuration_id, const char *quantity,
                        double value) {
    json_t *of_configuration = json_object_get(store->values, configuration_id);
    of_configuration = of_configuration ? json_incref(of_configuration) : json_object();
    vw_json_set(&of_configuration, quantity, vw_json_real(value));
    vw_json_set(&store->values, configuration_id, of_configuration);
}

enum vw_status vw_sweep_store_save(const struct vw_sweep_store *store) {
    char hex[VW_HASH_HEX_BYTES];
    if (!hash_values(store->values, hex)) return VW_ERROR_MEMORY;
    return vw_json_write_file(store->path, json_pack("{s:s, s:O}", "checksum", hex, "measurements", store->values));
}

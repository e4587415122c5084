// OUT/field.vwf: "viewworth field 1\n", the length of a JSON text as 8 decimal digits and "\n", the JSON (what the field is), "\n", the
// params block as little-endian 32-bit floats, and a BLAKE2b-256 of everything before it.
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trainer.h"
#include "viewworth/file.h"
#include "viewworth/memory.h"

static const char magic[] = "viewworth field 1\n";
enum { MAGIC_BYTES = sizeof magic - 1, LENGTH_BYTES = 9, HASH_BYTES = 32 };

// What must agree for a field to be rendered: the config's identity, the box, and the effects that are on.
static char *describe(const struct vw_trainer *trainer) {
    const struct vw_box *box = &trainer->scene->box;
    char *identity = vw_config_to_json(&trainer->config, true);
    json_t *effects = json_array();
    for (uint32_t i = 0; i < trainer->effect_count; i++)
        if (trainer->effects[i].on) json_array_append_new(effects, json_string(trainer->effects[i].name));
    json_t *object = identity ? json_pack("{s:o?, s:[f,f,f], s:f, s:o, s:I}", "config", json_loads(identity, 0, NULL), "box_centre_world",
                                          box->centre_world[0], box->centre_world[1], box->centre_world[2], "box_half_extent_world",
                                          box->half_extent_world, "effects", effects, "param_bytes", (json_int_t)trainer->model.param_bytes)
                              : NULL;
    char *text = object ? json_dumps(object, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
    json_decref(object);
    free(identity);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the field's description");
    return text;
}

// Everything before the params: owned by the caller.
static char *make_header(const struct vw_trainer *trainer) {
    char *description = describe(trainer);
    char *header = description ? vw_format_text("%s%08zu\n%s\n", magic, strlen(description), description) : NULL;
    free(description);
    return header;
}

static void hash_bytes(const void *data, size_t size_bytes, uint8_t hash[32]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_bytes(&hasher, data, size_bytes);
    vw_hasher_end(&hasher, hash);
}

enum vw_status vw_trainer_save_field(struct vw_trainer *trainer, const char *path) {
    char *header = make_header(trainer);
    if (!header) return VW_ERROR_MEMORY;
    size_t header_bytes = strlen(header), body_bytes = header_bytes + trainer->model.param_bytes;
    uint8_t *file = vw_allocate(body_bytes + HASH_BYTES, 1);
    enum vw_status status = file ? VW_OK : VW_ERROR_MEMORY;
    if (status == VW_OK) {
        memcpy(file, header, header_bytes);
        status = vw_buffer_read(trainer->field.params, 0, file + header_bytes, trainer->model.param_bytes);
    }
    if (status == VW_OK) {
        hash_bytes(file, body_bytes, file + body_bytes);
        status = vw_file_write(path, file, body_bytes + HASH_BYTES);
    }
    free(header);
    free(file);
    return status;
}

static enum vw_status check_file(const char *path, const char *header, const uint8_t *file, size_t size_bytes, uint64_t param_bytes) {
    uint8_t hash[HASH_BYTES];
    size_t header_bytes = strlen(header);
    if (size_bytes < MAGIC_BYTES + LENGTH_BYTES + HASH_BYTES || memcmp(file, magic, MAGIC_BYTES))
        return vw_fail(VW_ERROR_INPUT, "%s: not a viewworth field; train again with `viewworth train`", path);
    hash_bytes(file, size_bytes - HASH_BYTES, hash);
    if (memcmp(hash, file + size_bytes - HASH_BYTES, HASH_BYTES))
        return vw_fail(VW_ERROR_INPUT, "%s: damaged (its hash does not match); train again", path);
    if (size_bytes != header_bytes + param_bytes + HASH_BYTES || memcmp(file, header, header_bytes))
        return vw_fail(VW_ERROR_INPUT, "%s: trained with another configuration, box or effects than this run's", path);
    return VW_OK;
}

enum vw_status vw_trainer_load_field(struct vw_trainer *trainer, const char *path) {
    char *header = make_header(trainer);
    if (!header) return VW_ERROR_MEMORY;
    uint64_t param_bytes = trainer->model.param_bytes;
    void *file = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read(path, strlen(header) + param_bytes + (1 << 20), &file, &size_bytes);
    if (status == VW_OK) status = check_file(path, header, file, size_bytes, param_bytes);
    if (status == VW_OK) status = vw_buffer_write(trainer->field.params, 0, (uint8_t *)file + strlen(header), param_bytes);
    free(file);
    free(header);
    return status;
}

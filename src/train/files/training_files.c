#include "train/files/training_files.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "gpu/compute.h"

enum { LENGTH_BYTES = 9, HASH_BYTES = 32, DESCRIPTION_BYTES_MAX = 1 << 20 };

uint64_t vw_buffer_list_bytes(const struct vw_buffer_list *list) {
    uint64_t sum = list->tail_bytes;
    for (uint32_t i = 0; i < list->count; i++) sum += list->buffers[i] ? vw_buffer_size_bytes(list->buffers[i]) : 0;
    return sum;
}

static enum vw_status read_buffers(const struct vw_buffer_list *list, uint8_t *next) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < list->count && !status; i++) {
        if (!list->buffers[i]) continue;
        uint64_t size_bytes = vw_buffer_size_bytes(list->buffers[i]);
        status = vw_buffer_read(list->buffers[i], 0, next, size_bytes);
        next += size_bytes;
    }
    if (!status && list->tail_bytes) memcpy(next, list->tail, list->tail_bytes);
    return status;
}

enum vw_status vw_hashed_file_save(const char *path, const char *magic, const char *description,
                                   const struct vw_buffer_list *list) {
    char *header = vw_format_text("%s%08zu\n%s\n", magic, strlen(description), description);
    size_t header_bytes = header ? strlen(header) : 0, body_bytes = header_bytes + vw_buffer_list_bytes(list);
    uint8_t *file = header ? vw_allocate(body_bytes + HASH_BYTES, 1) : NULL;
    enum vw_status status = file ? VW_OK : VW_ERROR_MEMORY;
    if (!status) {
        memcpy(file, header, header_bytes);
        status = read_buffers(list, file + header_bytes);
    }
    if (!status) vw_sha256(file, body_bytes, file + body_bytes);
    if (!status) status = vw_file_write(path, file, body_bytes + HASH_BYTES);
    free(header);
    free(file);
    return status;
}

// Splits a file into its parts. The hash vouches for the rest, so that what it covers needs no further check.
static enum vw_status take_apart(const char *path, const char *magic, const char *remedy, size_t size_bytes,
                                 struct vw_hashed_file *file) {
    const size_t start = strlen(magic) + LENGTH_BYTES;
    uint8_t *bytes = file->bytes, hash[HASH_BYTES];
    if (size_bytes < start + 1 + HASH_BYTES || memcmp(bytes, magic, strlen(magic)))
        return vw_fail(VW_ERROR_INPUT, "%s: begins with another line than %.*s; %s", path, (int)strlen(magic) - 1,
                       magic, remedy);
    vw_sha256(bytes, size_bytes - HASH_BYTES, hash);
    size_t length = strtoul((const char *)bytes + strlen(magic), NULL, 10);
    if (memcmp(hash, bytes + size_bytes - HASH_BYTES, HASH_BYTES) || length > size_bytes - start - 1 - HASH_BYTES)
        return vw_fail(VW_ERROR_INPUT, "%s: damaged (its hash does not match); %s", path, remedy);
    file->description = (char *)bytes + start;
    file->description[length] = 0; // in the place of the line end
    file->payload = bytes + start + length + 1;
    file->payload_bytes = size_bytes - HASH_BYTES - (start + length + 1);
    return VW_OK;
}

enum vw_status vw_hashed_file_open(const char *path, const char *magic, uint64_t payload_limit_bytes,
                                   const char *remedy, struct vw_hashed_file *file) {
    *file = (struct vw_hashed_file){0};
    size_t size_bytes = 0;
    if (!vw_file_exists(path)) return vw_fail(VW_ERROR_INPUT, "%s: no such file; %s", path, remedy);
    enum vw_status status = vw_file_read(path, payload_limit_bytes + DESCRIPTION_BYTES_MAX, &file->bytes, &size_bytes);
    if (!status) status = take_apart(path, magic, remedy, size_bytes, file);
    if (status) vw_hashed_file_close(file);
    return status;
}

void vw_hashed_file_close(struct vw_hashed_file *file) {
    free(file->bytes);
    *file = (struct vw_hashed_file){0};
}

enum vw_status vw_hashed_file_load(const struct vw_hashed_file *file, const struct vw_buffer_list *list) {
    const uint8_t *next = file->payload;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < list->count && !status; i++) {
        if (!list->buffers[i]) continue;
        uint64_t size_bytes = vw_buffer_size_bytes(list->buffers[i]);
        status = vw_buffer_write(list->buffers[i], 0, next, size_bytes);
        next += size_bytes;
    }
    return status;
}

// ---- Checkpoints --------------------------------------------------------------------------------------------------

static const char checkpoint_magic[] = "viewworth checkpoint 1\n";
static const char checkpoint_remedy[] = "remove the file: the run starts from an older checkpoint or anew";

enum vw_status vw_checkpoint_save(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t step,
                                  const struct vw_step_passes *passes) {
    char hex[VW_HASH_HEX_BYTES];
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    uint32_t count = vw_step_training_state(passes, buffers);
    vw_hash_to_hex(run_id, hex);
    char *description = vw_format_text("{\"run_id\":\"%s\",\"step\":%" PRIu64 "}", hex, step);
    if (!description) return VW_ERROR_MEMORY;
    enum vw_status status =
        vw_hashed_file_save(path, checkpoint_magic, description, &(struct vw_buffer_list){buffers, count});
    free(description);
    return status;
}

static enum vw_status check_description(const char *path, const char *text, const uint8_t run_id[VW_HASH_BYTES],
                                        uint64_t last_step, uint64_t *step) {
    char hex[VW_HASH_HEX_BYTES];
    const char *saved_run = "";
    json_int_t saved_step = -1;
    enum vw_status status = VW_OK;
    json_t *object = vw_json_load(text, strlen(text), 0, NULL);
    vw_hash_to_hex(run_id, hex);
    if (!object || json_unpack(object, "{s:s, s:I}", "run_id", &saved_run, "step", &saved_step) || saved_step < 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: does not say which step it holds; %s", path, checkpoint_remedy);
    else if (strcmp(saved_run, hex))
        status = vw_fail(VW_ERROR_INPUT, "%s: of another run; %s", path, checkpoint_remedy);
    else if ((uint64_t)saved_step > last_step)
        status =
            vw_fail(VW_ERROR_USAGE, "%s: holds step %" PRId64 ", not one up to %" PRIu64 "; take an older checkpoint",
                    path, (int64_t)saved_step, last_step);
    json_decref(object);
    if (!status) *step = (uint64_t)saved_step;
    return status;
}

enum vw_status vw_checkpoint_open(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  uint64_t state_bytes, struct vw_hashed_file *file, uint64_t *step) {
    enum vw_status status = vw_hashed_file_open(path, checkpoint_magic, state_bytes, checkpoint_remedy, file);
    if (status) return status;
    status = check_description(path, file->description, run_id, last_step, step);
    if (!status && file->payload_bytes != state_bytes)
        status = vw_fail(VW_ERROR_INPUT, "%s: holds %" PRIu64 " bytes, not the %" PRIu64 " of this run; %s", path,
                         file->payload_bytes, state_bytes, checkpoint_remedy);
    if (status) vw_hashed_file_close(file);
    return status;
}

enum vw_status vw_checkpoint_load(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  const struct vw_step_passes *passes, uint64_t *step) {
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    const struct vw_buffer_list list = {buffers, vw_step_training_state(passes, buffers)};
    struct vw_hashed_file file;
    uint64_t saved_step = 0;
    enum vw_status status =
        vw_checkpoint_open(path, run_id, last_step, vw_buffer_list_bytes(&list), &file, &saved_step);
    if (status) return status;
    status = vw_hashed_file_load(&file, &list);
    vw_hashed_file_close(&file);
    if (!status) *step = saved_step;
    return status;
}

// ---- The field ----------------------------------------------------------------------------------------------------

static const char field_magic[] = "viewworth field 1\n", field_remedy[] = "train again with viewworth train";

// Describes a field by the config's identity, the box and the effects that are on; the caller owns the text.
static char *describe(const struct vw_trainer_parts *trained) {
    const struct vw_model *model = trained->field->model;
    const struct vw_box *box = &model->box;
    char *identity = vw_config_to_json(trained->config, true);
    json_t *effects = json_array();
    for (uint32_t i = 0; i < trained->effect_count; i++)
        if (trained->effects[i].on) vw_json_append(&effects, json_string(trained->effects[i].name));
    json_t *object =
        identity ? json_pack("{s:o, s:[f,f,f], s:f, s:o, s:I}", "config",
                             vw_json_load(identity, strlen(identity), 0, NULL), "box_centre_world",
                             box->centre_world[0], box->centre_world[1], box->centre_world[2], "box_half_extent_world",
                             box->half_extent_world, "effects", effects, "param_bytes", (json_int_t)model->param_bytes)
                 : NULL;
    char *text = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    free(identity);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the field's description");
    return text;
}

enum vw_status vw_field_file_save(const char *path, const struct vw_trainer_parts *trained) {
    char *description = describe(trained);
    const struct vw_buffer_list params = {&trained->field->params, 1};
    enum vw_status status =
        description ? vw_hashed_file_save(path, field_magic, description, &params) : VW_ERROR_MEMORY;
    free(description);
    return status;
}

enum vw_status vw_field_file_open(const char *path, const char *description, uint64_t param_bytes,
                                  struct vw_hashed_file *file) {
    enum vw_status status = vw_hashed_file_open(path, field_magic, param_bytes, field_remedy, file);
    if (status || (!strcmp(file->description, description) && file->payload_bytes == param_bytes)) return status;
    vw_hashed_file_close(file);
    return vw_fail(VW_ERROR_INPUT, "%s: trained with another configuration, box or effects than this run's; %s", path,
                   field_remedy);
}

enum vw_status vw_field_file_load(const char *path, const struct vw_trainer_parts *trained) {
    struct vw_hashed_file file;
    char *description = describe(trained);
    if (!description) return VW_ERROR_MEMORY;
    enum vw_status status = vw_field_file_open(path, description, trained->field->model->param_bytes, &file);
    free(description);
    if (status) return status;
    status = vw_hashed_file_load(&file, &(struct vw_buffer_list){&trained->field->params, 1});
    vw_hashed_file_close(&file);
    return status;
}

// ---- Snapshots ----------------------------------------------------------------------------------------------------

enum vw_status vw_snapshot_create(const struct vw_step_passes *step, struct vw_snapshot *snapshot) {
    enum vw_status status = VW_OK;
    snapshot->objects.gpu = step->field->gpu;
    snapshot->count = vw_step_training_state(step, snapshot->state);
    for (uint32_t i = 0; i < snapshot->count && !status; i++) {
        const struct vw_buffer_row copy = {&snapshot->copies[i], "snapshot", vw_buffer_size_bytes(snapshot->state[i])};
        status = vw_buffers_create(&snapshot->objects, VW_BUFFER_DEVICE, &copy, 1);
    }
    return status;
}

void vw_snapshot_destroy(struct vw_snapshot *snapshot) { vw_gpu_objects_destroy(&snapshot->objects); }

void vw_snapshot_record_save(const struct vw_snapshot *snapshot, struct vw_submission *submission) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_submission_copy(submission, snapshot->state[i], 0, snapshot->copies[i], 0,
                           vw_buffer_size_bytes(snapshot->copies[i]));
}

void vw_snapshot_record_restore(const struct vw_snapshot *snapshot, struct vw_submission *submission) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_submission_copy(submission, snapshot->copies[i], 0, snapshot->state[i], 0,
                           vw_buffer_size_bytes(snapshot->copies[i]));
}

#include "train/files/checkpoint.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "train/files/hashed_file.h"

static const char magic[] = "viewworth checkpoint 1\n";
static const char remedy[] = "remove the file: the run starts from an older checkpoint or anew";

enum vw_status vw_checkpoint_save(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t step,
                                  const struct vw_step_passes *passes, const struct vw_file_binding *binding) {
    char hex[VW_HASH_HEX_BYTES];
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    uint32_t count = vw_step_training_state(passes, buffers);
    vw_hash_to_hex(run_id, hex);
    char *description = vw_format_text("{\"run_id\":\"%s\",\"step\":%" PRIu64 "}", hex, step);
    if (!description) return VW_ERROR_MEMORY;
    enum vw_status status =
        vw_hashed_file_save(path, magic, description, &(struct vw_buffer_list){buffers, count}, binding);
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
        status = vw_fail(VW_ERROR_INPUT, "%s: does not say which step it holds; %s", path, remedy);
    else if (strcmp(saved_run, hex)) status = vw_fail(VW_ERROR_INPUT, "%s: of another run; %s", path, remedy);
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
    enum vw_status status = vw_hashed_file_open(path, magic, state_bytes, remedy, file);
    if (status) return status;
    status = check_description(path, file->description, run_id, last_step, step);
    if (!status && file->payload_bytes != state_bytes)
        status = vw_fail(VW_ERROR_INPUT, "%s: holds %" PRIu64 " bytes, not the %" PRIu64 " of this run; %s", path,
                         file->payload_bytes, state_bytes, remedy);
    if (status) vw_hashed_file_close(file);
    return status;
}

enum vw_status vw_checkpoint_load(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  const struct vw_step_passes *passes, const struct vw_file_binding *binding,
                                  uint64_t *step) {
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    const struct vw_buffer_list list = {buffers, vw_step_training_state(passes, buffers)};
    struct vw_hashed_file file;
    uint64_t saved_step = 0;
    enum vw_status status =
        vw_checkpoint_open(path, run_id, last_step, vw_buffer_list_bytes(&list), &file, &saved_step);
    if (status) return status;
    status = vw_hashed_file_check_kept(&file, path, remedy, binding);
    if (!status) status = vw_hashed_file_load(&file, &list);
    vw_hashed_file_close(&file);
    if (!status) *step = saved_step;
    return status;
}

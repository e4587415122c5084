// A training's state between two steps as a file (decision 11).
#include <inttypes.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "train/hashed_file.h"
#include "train/trainer_private.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "base/hash.h"
#include "base/memory.h"

static const char magic[] = "viewworth checkpoint 1\n";
static const char remedy[] = "remove the file: the run starts from an older checkpoint or anew";

static enum vw_status name_run(const struct vw_trainer *trainer, char hex[VW_HASH_HEX_BYTES]) {
    uint8_t run_id[32];
    enum vw_status status = vw_trainer_run_id(trainer, run_id);
    if (status == VW_OK) vw_hash_to_hex(run_id, hex);
    return status;
}

enum vw_status vw_trainer_save_checkpoint(struct vw_trainer *trainer, const char *path) {
    if (trainer_in_flight(trainer)) return vw_fail(VW_ERROR_USAGE, "%s: steps are in flight; collect them first", path);
    if (trainer->next_step == 0) return vw_fail(VW_ERROR_USAGE, "%s: nothing to keep before the first step", path);
    char run_id[VW_HASH_HEX_BYTES];
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    enum vw_status status = name_run(trainer, run_id);
    if (status != VW_OK) return status;
    uint32_t count = step_training_state(&trainer->step, buffers);
    char *description = vw_format_text("{\"run_id\":\"%s\",\"step\":%" PRIu64 "}", run_id, trainer->next_step - 1);
    if (!description) return VW_ERROR_MEMORY;
    status = hashed_file_save(path, magic, description, &(struct buffer_list){buffers, count});
    free(description);
    return status;
}

static enum vw_status check_description(const struct vw_trainer *trainer, const char *path, const char *text,
                                        uint64_t last_step, uint64_t *step) {
    char run_id[VW_HASH_HEX_BYTES];
    enum vw_status status = name_run(trainer, run_id);
    if (status != VW_OK) return status;
    const char *saved_run = "";
    json_int_t saved_step = -1;
    json_t *object = json_loads(text, 0, NULL);
    if (!object || json_unpack(object, "{s:s, s:I}", "run_id", &saved_run, "step", &saved_step) || saved_step < 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: does not say which step it holds; %s", path, remedy);
    else if (strcmp(saved_run, run_id)) status = vw_fail(VW_ERROR_INPUT, "%s: of another run; %s", path, remedy);
    else if ((uint64_t)saved_step > last_step)
        status =
            vw_fail(VW_ERROR_USAGE, "%s: holds step %" PRId64 ", not one up to %" PRIu64 "; take an older checkpoint",
                    path, (int64_t)saved_step, last_step);
    json_decref(object);
    if (status == VW_OK) *step = (uint64_t)saved_step;
    return status;
}

enum vw_status vw_trainer_load_checkpoint(struct vw_trainer *trainer, const char *path, uint64_t last_step,
                                          uint64_t *step) {
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    const struct buffer_list list = {buffers, step_training_state(&trainer->step, buffers)};
    struct hashed_file file;
    uint64_t saved_step = 0;
    if (trainer_in_flight(trainer))
        return vw_fail(VW_ERROR_USAGE, "%s: steps are in flight; load before the first advance", path);
    enum vw_status status = hashed_file_open(path, magic, buffer_list_bytes(&list), remedy, &file);
    if (status != VW_OK) return status;
    status = check_description(trainer, path, file.description, last_step, &saved_step);
    if (status == VW_OK && file.payload_bytes != buffer_list_bytes(&list))
        status = vw_fail(VW_ERROR_INPUT, "%s: holds %" PRIu64 " bytes, not the %" PRIu64 " of this run; %s", path,
                         file.payload_bytes, buffer_list_bytes(&list), remedy);
    if (status == VW_OK) status = hashed_file_load(&file, &list);
    hashed_file_close(&file);
    if (status != VW_OK) return status;
    trainer->next_step = saved_step + 1;
    trainer->same_state.probed_step = saved_step; // its record, which has the probes, was handed out before
    *step = saved_step;
    return VW_OK;
}

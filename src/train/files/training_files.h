// The state of a training between two steps, as a file (decision 11) and as a copy on the device, and OUT/field.vwf,
// the params block with what must agree for it to be rendered.
#ifndef VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H
#define VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H

#include "train/files/hashed_file.h"
#include "train/step.h"
#include "train/trainer_parts.h"
#include "viewworth/types.h"

// Saves the state after `step` of the run.
enum vw_status vw_checkpoint_save(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t step,
                                  const struct vw_step_passes *passes);
// Reads such a file of `state_bytes`, and the step's number, without a device. The same errors as below; close it.
enum vw_status vw_checkpoint_open(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  uint64_t state_bytes, struct vw_hashed_file *file, uint64_t *step);
// Loads it, and the step's number. VW_ERROR_INPUT when the file is missing, damaged or of another run, VW_ERROR_USAGE
// when it is of a later step than `last_step`: the state is then untouched.
enum vw_status vw_checkpoint_load(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  const struct vw_step_passes *passes, uint64_t *step);

enum vw_status vw_field_file_save(const char *path, const struct vw_trainer_parts *trained);
// Reads a file of that description and size without a device; close it. The same errors as below.
enum vw_status vw_field_file_open(const char *path, const char *description, uint64_t param_bytes,
                                  struct vw_hashed_file *file);
// Loads the params. VW_ERROR_INPUT when the file is damaged, or of another configuration, box or effects.
enum vw_status vw_field_file_load(const char *path, const struct vw_trainer_parts *trained);

// ---- Snapshots ------------------------------------------------------------------------------------------------------

// A copy of a training's state on the device. Whoever tries a step restores the state from the copy, so that later
// steps keep their bits.
struct vw_snapshot {
    struct vw_buffer *state[TRAINING_STATE_BUFFERS_MAX]; // borrowed from the step
    struct vw_buffer *copies[TRAINING_STATE_BUFFERS_MAX];
    uint32_t count;
    struct vw_gpu_objects objects; // owned: the copies
};

enum vw_status vw_snapshot_create(const struct vw_step_passes *step, struct vw_snapshot *snapshot);
void vw_snapshot_destroy(struct vw_snapshot *snapshot);
void vw_snapshot_record_save(const struct vw_snapshot *snapshot, struct vw_submission *submission);
void vw_snapshot_record_restore(const struct vw_snapshot *snapshot, struct vw_submission *submission);

#endif

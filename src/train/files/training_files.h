// The state of a training between two steps, as a file (decision 11) and as a copy on the device, and OUT/field.vwf,
// the params block with what must agree for it to be rendered.
//
// Files are device buffers that can tell whether they are whole: a magic line, the length of a JSON text as 8 decimal
// digits and "\n", the JSON (what the file is), "\n", the buffers' bytes one after another (little-endian), and a
// SHA-256 of everything before it.
#ifndef VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H
#define VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H

#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "train/step.h"
#include "train/trainer_parts.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// Some buffers, whole, in the order they have in the file. NULL entries are skipped.
struct vw_buffer_list {
    struct vw_buffer *const *buffers;
    uint32_t count;
    const void *tail; // bytes of the host that follow them
    size_t tail_bytes;
};

uint64_t vw_buffer_list_bytes(const struct vw_buffer_list *list);

// Waits for the device, then writes the file beside its place, syncs it and moves it there.
enum vw_status vw_hashed_file_save(const char *path, const char *magic, const char *description,
                                   const struct vw_buffer_list *list);

struct vw_hashed_file {
    void *bytes; // owned
    char *description;
    const uint8_t *payload; // the bytes after the description; in `bytes`
    uint64_t payload_bytes;
};

// Reads a file of at most `payload_limit_bytes` of buffers. VW_ERROR_INPUT, naming the path and the `remedy`, when it
// is not such a file or damaged.
enum vw_status vw_hashed_file_open(const char *path, const char *magic, uint64_t payload_limit_bytes,
                                   const char *remedy, struct vw_hashed_file *file);
void vw_hashed_file_close(struct vw_hashed_file *file);
// Puts the payload, whose size the caller has checked, into the buffers; a tail stays in the payload.
enum vw_status vw_hashed_file_load(const struct vw_hashed_file *file, const struct vw_buffer_list *list);

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

// A training's state between two steps as a file (decision 11).
#ifndef VIEWWORTH_TRAIN_FILES_CHECKPOINT_H
#define VIEWWORTH_TRAIN_FILES_CHECKPOINT_H

#include "train/files/hashed_file.h"
#include "train/step.h"
#include "viewworth/types.h"

// Saves the state after `step` of the run.
enum vw_status vw_checkpoint_save(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t step,
                                  const struct vw_step_passes *passes, const struct vw_file_binding *binding);
// Reads such a file of `state_bytes`, and the step's number, without a device. The same errors as below; close it.
enum vw_status vw_checkpoint_open(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  uint64_t state_bytes, struct vw_hashed_file *file, uint64_t *step);
// Loads it, and the step's number. VW_ERROR_INPUT when the file is missing, damaged, of another run or not one that the
// binding (NULL: none) knows, VW_ERROR_USAGE when it is of a later step than `last_step`: the state is then untouched.
enum vw_status vw_checkpoint_load(const char *path, const uint8_t run_id[VW_HASH_BYTES], uint64_t last_step,
                                  const struct vw_step_passes *passes, const struct vw_file_binding *binding,
                                  uint64_t *step);

#endif

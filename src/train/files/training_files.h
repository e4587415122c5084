// The files of a training: its state between two steps (decision 11), and OUT/field.vwf, the params block with what
// must agree for it to be rendered.
#ifndef VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H
#define VIEWWORTH_TRAIN_FILES_TRAINING_FILES_H

#include "train/field.h"
#include "train/files/hashed_file.h"
#include "train/step.h"
#include "viewworth/train.h"
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

struct vw_trained_field { // all borrowed
    struct vw_radiance_field *field;
    const struct vw_config *config;
    const struct vw_effect_verdict *effects;
    uint32_t effect_count;
};

enum vw_status vw_field_file_save(const char *path, const struct vw_trained_field *trained);
// Reads a file of that description and size without a device; close it. The same errors as below.
enum vw_status vw_field_file_open(const char *path, const char *description, uint64_t param_bytes,
                                  struct vw_hashed_file *file);
// Loads the params. VW_ERROR_INPUT when the file is damaged, or of another configuration, box or effects.
enum vw_status vw_field_file_load(const char *path, const struct vw_trained_field *trained);

#endif

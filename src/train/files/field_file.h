// OUT/field.vwf: the params block, and what must agree for it to be rendered.
#ifndef VIEWWORTH_TRAIN_FILES_FIELD_FILE_H
#define VIEWWORTH_TRAIN_FILES_FIELD_FILE_H

#include "train/field.h"
#include "train/files/hashed_file.h"
#include "viewworth/train.h"

struct vw_trained_field { // all borrowed
    struct vw_radiance_field *field;
    const struct vw_config *config;
    const struct vw_effect_verdict *effects;
    uint32_t effect_count;
};

// Saves the field; `binding` may be NULL here and below.
enum vw_status vw_field_file_save(const char *path, const struct vw_trained_field *trained,
                                  const struct vw_file_binding *binding);
// Reads a file of that description and size without a device; close it. The same errors as below.
enum vw_status vw_field_file_open(const char *path, const char *description, uint64_t param_bytes,
                                  struct vw_hashed_file *file);
// Loads the params. VW_ERROR_INPUT when the file is damaged, of another configuration, box or effects, or not one that
// the binding knows.
enum vw_status vw_field_file_load(const char *path, const struct vw_trained_field *trained,
                                  const struct vw_file_binding *binding);

#endif

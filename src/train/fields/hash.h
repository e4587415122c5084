// The parts of the field `hash` that tests and benchmarks use.
#ifndef VIEWWORTH_TRAIN_FIELDS_HASH_H
#define VIEWWORTH_TRAIN_FIELDS_HASH_H

#include "train/fields/registry.h"
#include "train/model.h"

// Places of its passes in a set; the last begins those of the grid's windows.
enum { HASH_FORWARD, HASH_BACKWARD, HASH_GRADIENT, HASH_REDUCE, HASH_SCATTER };

// Records the passes that add the encoding gradients of the chunk's `samples` to the grid's gradient.
void vw_hash_record_scatter(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, uint32_t samples);

#endif

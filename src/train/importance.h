// Samples placed where the field has matter (--importance-samples). Before a chunk of rays goes forward, its even
// samples are rendered without a way back, and place_samples lists all places of the chunk, which the passes behind it
// read. NeRF (Mildenhall et al., ECCV 2020, section 5.2) renders the even samples by a network of their own; here one
// field serves both.
#ifndef VIEWWORTH_TRAIN_IMPORTANCE_H
#define VIEWWORTH_TRAIN_IMPORTANCE_H

#include "gpu/compute.h"
#include "train/field.h"
#include "train/fields/registry.h"

extern const char even_role[], even_validation_role[]; // of the field's passes over even samples, in the timers

struct importance {
    struct field_passes even;
    struct vw_pass *place; // NULL without importance samples
};

// The listed places of a chunk; NULL without importance samples. To be bound at VW_SLOT_KEPT_SAMPLES.
enum vw_status importance_create_places(const struct field *field, uint32_t rays, struct vw_buffer **places);
// For passes of this specialization over these bindings, with `role` as theirs.
enum vw_status importance_create(const struct field *field, const struct field_pass_params *params,
                                 struct importance *importance);
void importance_destroy(struct importance *importance);
// Records the placing of a chunk's samples. Does nothing without importance samples.
void importance_record(const struct model *model, const struct importance *importance, struct vw_batch *batch,
                       const struct vw_push_samples *chunk);

#endif

// Samples placed where the field has matter (--importance-samples). Before a chunk of rays goes forward, its even
// samples are rendered, and place_samples lists all places of the chunk, which the passes after it read. The field
// itself renders the even samples, without a backward pass; or, as in NeRF (Mildenhall et al., ECCV 2020, section 5.2),
// a coarse network of the same shape (--coarse-network own), which a step trains by the loss of its own colours against
// the same pixels, NeRF's equation 6. No gradient goes through the places.
#ifndef VIEWWORTH_TRAIN_IMPORTANCE_H
#define VIEWWORTH_TRAIN_IMPORTANCE_H

#include "gpu/compute.h"
#include "train/field.h"
#include "train/fields/registry.h"

extern const char even_role[], even_validation_role[]; // roles in the timers of the field's passes over even samples

struct vw_importance {
    struct vw_field_passes even;
    struct vw_pass *place;         // NULL without importance samples
    struct vw_pass *backward_rays; // over the even samples; NULL where no coarse network is trained
};

// Returns the bytes of the listed places of a chunk of rays, 0 without importance samples; bound at
// VW_SLOT_PLACES.
uint64_t vw_importance_places_bytes(const struct vw_model *model, uint32_t rays);
// Creates the placing for passes of this specialization. `backward_rays`: the shader that trains a coarse network, if
// there is one; NULL where nothing is trained.
enum vw_status vw_importance_create(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    const struct vw_specialization *specialization,
                                    const struct vw_shader *backward_rays, struct vw_importance *importance);
// Records the placing of a chunk's samples, and the backward pass of a coarse network. Does nothing without importance
// samples.
void vw_importance_record(const struct vw_model *model, const struct vw_importance *importance,
                          struct vw_submission *submission, const struct vw_push_samples *chunk);

#endif

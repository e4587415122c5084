// Changes of the structure of splats, on the host: which splats there are. Splats without a place yet are at the end of
// the params, so transparent that nothing sees them.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_STRUCTURE_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_STRUCTURE_H

#include "train/renderers/splats/splats_renderer.h"

#define VW_SPLAT_UNBORN (-80.0f) // logit of the opacity of a splat that is yet to be added

struct vw_splat_set {
    float *params, *moments[2]; // vec4 columns; moments may be NULL
    uint32_t room, columns;     // splats in a column
    uint64_t seed, step;        // key of the draws
};

// Returns how many splats there are.
uint32_t vw_splats_count_born(const struct vw_splat_set *set);
// Leaves no room beyond these in the columns of params.
void vw_splats_close_up(struct vw_splat_set *set);
// Writes the opacity of each of `count` splats in one place that look most like one of `opacity` and of `factor` times
// less size. `opacity` is from above 0 to 0.99.
void vw_splats_share(double opacity, uint32_t count, double *each, double *factor);
// Moves the splats that have faded to others, and adds new ones until there are `wanted`, at most `room`. Moments of
// those that change are 0.
enum vw_status vw_splats_restructure(const struct vw_splat_set *set, uint32_t wanted);

#endif

// The same-state score's measurements (`value --same-state N`, the paper's option c): from each of N states, at ends of
// epochs, the next step is taken on every photo, one after another, validated, and the state restored. The run itself
// is not touched.
#ifndef VIEWWORTH_TRAIN_PROBES_SAME_STATE_H
#define VIEWWORTH_TRAIN_PROBES_SAME_STATE_H

#include "train/probes/probe_context.h"

// Draws of every photo's pixels at a state. Two are the fewest that tell what the draw does to a score, which is
// printed beside it; for the same work more states say more than more draws, since the draws of a state share what is
// peculiar to it.
enum { SAME_STATE_DRAWS = 2 };

struct vw_same_state_probes {
    struct vw_probe *probes; // owned; those of a step that is probed, with its others before them
    uint64_t probed_step;    // the last one whose state was probed
    uint64_t taken_count;    // probes taken
    double taken_s;          // wall clock that they took
};

// Creates the probes. `others`: the most other probes that a step may have.
enum vw_status vw_same_state_create(const struct vw_probe_context *context, uint32_t others,
                                    struct vw_same_state_probes *probes);
void vw_same_state_destroy(struct vw_same_state_probes *probes);

// Returns whether the state after this step is probed: the one at the end of the middle epoch of each of N nearly equal
// parts of the epochs after burn-in.
bool vw_same_state_due(const struct vw_probe_context *context, uint64_t step);

// Probes the state on the device, which is the one after the record's step, in as many submissions as it takes. Adds
// what it finds to the record's probes: photo by photo in the order of their views, draw by draw. The draws of pixels
// from `first_draw` on are free. Nothing is in flight, and `batch` and all the scalars are free.
enum vw_status vw_same_state_take(struct vw_same_state_probes *probes, const struct vw_probe_context *context,
                                  struct vw_submission *batch, uint32_t first_draw, struct vw_step_record *record);

#endif

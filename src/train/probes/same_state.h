// The same-state score's measurements (`value --same-state N`, the paper's option c): from each of N states, at ends of
// epochs, the next step is taken on every photo in turn, validated, and the state restored. The run itself is not
// touched.
#ifndef VIEWWORTH_TRAIN_SAME_STATE_H
#define VIEWWORTH_TRAIN_SAME_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

struct vw_trainer;
struct vw_batch;
struct vw_step_record;

// Of every photo's pixels at a state. Two are the fewest that tell what the draw does to a score, which is printed
// beside it; for the same work more states say more than more draws, since the draws of a state share what is peculiar
// to it.
enum { SAME_STATE_DRAWS = 2 };

struct same_state_probes {
    struct vw_probe *probes; // those of a step that is probed, with its others before them
    uint64_t probed_step;    // the last one whose state was probed
};

// `others`: how many other probes a step may have.
enum vw_status same_state_create(const struct vw_trainer *trainer, uint32_t others, struct same_state_probes *probes);
void same_state_destroy(struct same_state_probes *probes);

// Whether the state behind this step is probed: that at the end of the middle epoch of each of N nearly equal parts of
// the epochs behind burn-in.
bool same_state_due(const struct vw_trainer *trainer, uint64_t step);

// Probes the state on the device, which is that behind the record's step, in as many submissions as it takes, and adds
// what it finds to the record's probes: photo by photo in the order of their views, draw by draw. Nothing is in flight,
// and `batch` and all the scalars are free.
enum vw_status same_state_take(struct vw_trainer *trainer, struct vw_batch *batch, struct vw_step_record *record);

#endif

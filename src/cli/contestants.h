// Everyone a benchmark judges: the methods of the valued runs, and the controls.
#ifndef VIEWWORTH_CLI_CONTESTANTS_H
#define VIEWWORTH_CLI_CONTESTANTS_H

#include "cli/laboratory.h"
#include "value/contest.h"

enum { VW_CONTESTANTS_MAX = 256 };

struct vw_contestants {
    struct vw_contest contest; // its arrays are those below
    struct vw_contestant list[VW_CONTESTANTS_MAX];
    double *scores[VW_CONTESTANTS_MAX];     // owned; [seed][photo] of each
    uint32_t trainings[VW_CONTESTANTS_MAX]; // that each takes
    const char **truths;                    // owned array
};

// Reads the valued runs in OUT, of --seed and the seeds after it, and measures the controls. Methods that lack a value for some photo are
// left out. Free it also after a failure.
enum vw_status vw_contestants_make(const struct vw_laboratory *laboratory, uint32_t seed_count, struct vw_contestants *contestants);
// Adds one with scores to be filled, [seed][photo], all NaN: NULL when memory is short. `name` is borrowed.
double *vw_contestants_add(struct vw_contestants *contestants, const char *name, uint32_t trainings);
void vw_contestants_free(struct vw_contestants *contestants);

#endif

// Judges: train photos that measure the steps on all other photos, where no fixed photos validate (`--judges`). Each
// keeps squares of its pixels out of its own training. They are divided into groups, each of which is spread evenly
// over the photos; an epoch has one group, the same for all its steps, and in a round of epochs every group judges
// once, in an order of its own. Which photos judge follows from the scene and the epoch's number alone (decision 1).
#ifndef VIEWWORTH_TRAIN_VALIDATION_JUDGES_H
#define VIEWWORTH_TRAIN_VALIDATION_JUDGES_H

#include "train/pixels.h"
#include "viewworth/status.h"

enum { VW_JUDGES_MOST = 256 }; // if there are more photos, so many judge, evenly spread

struct vw_judges {            // without judges one group: the photos that validate
    uint32_t group_count;     // 0: there is no validation
    uint32_t *group_starts;   // owned; group_count + 1 places in the list of views
    uint32_t group_most;      // views of the largest group
    struct vw_kept_out *kept; // owned, with its squares; by view of the scene. NULL: fixed photos validate
    uint32_t view_count;      // in the scene
    uint32_t *order;          // owned: scratch, of the groups in a round
};

// Chooses judges among the train views (scene indices, ascending), in groups of at least `per_epoch`. `*views` has them
// group by group, ascending in each; owned by the caller. VW_ERROR_USAGE when there are fewer than two views.
enum vw_status vw_judges_choose(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count,
                                uint32_t per_epoch, struct vw_judges *judges, uint32_t **views);
// Makes fixed photos the only group.
enum vw_status vw_judges_fix(uint32_t view_count, struct vw_judges *judges);
void vw_judges_free(struct vw_judges *judges);

// Returns the group that judges the steps of an epoch.
uint32_t vw_judges_group_of_epoch(const struct vw_judges *judges, uint32_t epoch);
static inline uint32_t vw_judges_in_group(const struct vw_judges *judges, uint32_t group) {
    return judges->group_starts[group + 1] - judges->group_starts[group];
}

// Keeps the squares of these pixels, all of one view, out of its training.
enum vw_status vw_judges_keep_out(const struct vw_scene *scene, uint32_t view, const struct vw_pixel *pixels,
                                  uint32_t count, struct vw_judges *judges);
struct vw_kept_out vw_judges_kept_out(const struct vw_judges *judges, uint32_t view);

#endif

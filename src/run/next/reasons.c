#include "run/next/reasons.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

static const double FEW_MOST = 0.5;  // in parts of the usual number
static const double FAR_LEAST = 2;   // usual distances
static const uint32_t VAL_LEAST = 3; // photos, for a median of their errors

static const char *const words[VW_NEXT_REASON_COUNT] = {[VW_SEEN_BY_FEW] = "seen by few",
                                                        [VW_HIGH_ERROR] = "high error",
                                                        [VW_EXTRAPOLATES] = "extrapolates",
                                                        [VW_BETWEEN_PHOTOS] = "between photos",
                                                        [VW_SEES_NOTHING] = "sees nothing"};

const char *vw_next_reason_word(enum vw_next_reason reason) { return words[reason]; }

void vw_next_print_reasons(uint32_t reasons, char *text, size_t size_bytes) {
    size_t used = 0;
    text[0] = 0;
    for (uint32_t i = 0; i < VW_NEXT_REASON_COUNT; i++)
        if (reasons >> i & 1 && used < size_bytes)
            used += (size_t)snprintf(text + used, size_bytes - used, "%s%s", used ? ", " : "", words[i]);
}

bool vw_next_reason_is_known(const char *word) {
    for (size_t i = 0; word && i < VW_NEXT_REASON_COUNT; i++)
        if (!strcmp(words[i], word)) return true;
    return false;
}

static void find_neighbours(const struct vw_known_photos *known, struct vw_proposal *proposal) {
    const struct vw_view *pose = proposal->pose;
    const struct vw_view_scales *scales = &known->scales;
    double apart;
    uint32_t nearest = vw_view_nearest(known->scene, scales, known->views, known->count, pose, &proposal->apart);
    proposal->nearest_view = known->views[nearest];
    if (proposal->apart > FAR_LEAST) proposal->reasons |= 1u << VW_EXTRAPOLATES;
    if (known->val_count < VAL_LEAST) return;
    nearest = vw_view_nearest(known->scene, scales, known->val_views, known->val_count, pose, &apart);
    if (apart <= FAR_LEAST && known->val_mse[nearest] > known->usual_mse) proposal->reasons |= 1u << VW_HIGH_ERROR;
}

static void add_seen(const struct vw_known_photos *known, const struct vw_depth_map *map,
                     struct vw_proposal *proposal) {
    struct vw_seen_points points;
    vw_seen_points_find(map, known->maps, known->count, known->count, &points);
    proposal->seen_by = vw_seen_points_median(&points);
    if (!map->seen_count) proposal->reasons |= 1u << VW_SEES_NOTHING;
    else if (proposal->seen_by <= FEW_MOST * known->usual_seen_by) proposal->reasons |= 1u << VW_SEEN_BY_FEW;
    if (!proposal->reasons && proposal->apart < 1) proposal->reasons = 1u << VW_BETWEEN_PHOTOS;
}

static enum vw_status map_proposals(const struct vw_known_photos *known, const struct vw_next *next,
                                    struct vw_depth_map **maps) {
    struct vw_view *poses = vw_allocate(next->proposal_count, sizeof *poses);
    uint32_t *views = vw_allocate(next->proposal_count, sizeof *views);
    enum vw_status status = poses && views ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < next->proposal_count && !status; k++) {
        poses[k] = *next->proposals[k].pose;
        views[k] = next->proposals[k].nearest_view;
    }
    if (!status) status = vw_depth_maps_make(&known->depths, views, poses, next->proposal_count, maps);
    free(poses);
    free(views);
    return status;
}

enum vw_status vw_next_find_reasons(const struct vw_known_photos *known, struct vw_next *next) {
    struct vw_depth_map *maps = NULL;
    for (uint32_t k = 0; k < next->proposal_count; k++) find_neighbours(known, &next->proposals[k]);
    enum vw_status status = map_proposals(known, next, &maps);
    for (uint32_t k = 0; k < next->proposal_count && !status; k++) add_seen(known, &maps[k], &next->proposals[k]);
    free(maps);
    return status;
}

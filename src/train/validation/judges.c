#include "train/validation/judges.h"

#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"

static const uint64_t ROUND_SEED = UINT64_C(0x6a75646765); // differs from the seeds of photo orders

static enum vw_status allocate_groups(uint32_t group_count, struct vw_judges *judges) {
    judges->group_count = group_count;
    judges->group_starts = vw_allocate((size_t)group_count + 1, sizeof *judges->group_starts);
    judges->order = vw_allocate(group_count, sizeof *judges->order);
    return judges->group_starts && judges->order ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_judges_fix(uint32_t view_count, struct vw_judges *judges) {
    enum vw_status status = allocate_groups(1, judges);
    if (!status) judges->group_starts[1] = judges->group_most = view_count;
    return status;
}

// Deals the judges out to the groups in turn: photos that follow each other show the same, and then no group has two.
static void deal(const uint32_t *train_views, uint32_t train_count, uint32_t count, struct vw_judges *judges,
                 uint32_t *views) {
    uint32_t dealt = 0;
    for (uint32_t group = 0; group < judges->group_count; group++) {
        for (uint32_t i = group; i < count; i += judges->group_count)
            views[dealt++] = train_views[(uint64_t)i * train_count / count];
        judges->group_starts[group + 1] = dealt;
        uint32_t own = vw_judges_in_group(judges, group);
        if (own > judges->group_most) judges->group_most = own;
    }
}

enum vw_status vw_judges_choose(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count,
                                uint32_t per_epoch, struct vw_judges *judges, uint32_t **views) {
    uint32_t count = train_count < VW_JUDGES_MOST ? train_count : VW_JUDGES_MOST, groups = count / per_epoch;
    if (count < 2)
        return vw_fail(VW_ERROR_USAGE, "--judges: %u photo has no other to judge it; train on two at least", count);
    enum vw_status status = allocate_groups(groups ? groups : 1, judges);
    if (status) return status;
    judges->view_count = scene->view_count;
    judges->kept = vw_allocate(scene->view_count, sizeof *judges->kept);
    *views = vw_allocate(count, sizeof **views);
    if (!judges->kept || !*views) return VW_ERROR_MEMORY;
    deal(train_views, train_count, count, judges, *views);
    return VW_OK;
}

void vw_judges_free(struct vw_judges *judges) {
    for (uint32_t v = 0; judges->kept && v < judges->view_count; v++) free((void *)judges->kept[v].squares);
    free(judges->kept);
    free(judges->group_starts);
    free(judges->order);
    *judges = (struct vw_judges){0};
}

uint32_t vw_judges_group_of_epoch(const struct vw_judges *judges, uint32_t epoch) {
    vw_random_order(ROUND_SEED, epoch / judges->group_count, judges->group_count, judges->order);
    return judges->order[epoch % judges->group_count];
}

enum vw_status vw_judges_keep_out(const struct vw_scene *scene, uint32_t view, const struct vw_pixel *pixels,
                                  uint32_t count, struct vw_judges *judges) {
    const struct vw_camera *camera = &scene->views[view].camera;
    uint32_t columns = (camera->width_px + VW_JUDGE_SQUARE_PX - 1) / VW_JUDGE_SQUARE_PX,
             rows = (camera->height_px + VW_JUDGE_SQUARE_PX - 1) / VW_JUDGE_SQUARE_PX;
    uint8_t *squares = vw_allocate((size_t)columns * rows, sizeof *squares);
    if (!squares) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t x = (uint32_t)pixels[i].x_px / VW_JUDGE_SQUARE_PX, y = (uint32_t)pixels[i].y_px / VW_JUDGE_SQUARE_PX;
        squares[(size_t)y * columns + x] = 1;
    }
    judges->kept[view] = (struct vw_kept_out){squares, columns};
    return VW_OK;
}

struct vw_kept_out vw_judges_kept_out(const struct vw_judges *judges, uint32_t view) {
    return judges->kept ? judges->kept[view] : (struct vw_kept_out){0};
}

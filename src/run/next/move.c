#include "run/next/move.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

enum axis { RIGHT, UP, BACK, POSITION }; // columns of camera_to_world

static double square_between(const struct vw_view *a, const struct vw_view *b) {
    double step[3];
    for (int i = 0; i < 3; i++) step[i] = a->camera_to_world[i][POSITION] - b->camera_to_world[i][POSITION];
    return vw_dot(step, step, 3);
}

static const struct vw_view *find_nearest(const struct vw_known_views *known, const struct vw_view *pose) {
    const struct vw_view *nearest = &known->scene->views[known->views[0]];
    for (uint32_t i = 1; i < known->count; i++) {
        const struct vw_view *photo = &known->scene->views[known->views[i]];
        if (square_between(photo, pose) < square_between(nearest, pose)) nearest = photo;
    }
    return nearest;
}

// Returns a column of a pose along the axes of a photo; its position from there.
static void express(const struct vw_view *photo, const struct vw_view *pose, enum axis column, double along[3]) {
    for (int axis = 0; axis < 3; axis++) {
        along[axis] = 0;
        for (int i = 0; i < 3; i++) {
            double start = column == POSITION ? photo->camera_to_world[i][POSITION] : 0;
            along[axis] += photo->camera_to_world[i][axis] * (pose->camera_to_world[i][column] - start);
        }
    }
}

// Appends an amount, if there is one after rounding to `unit`.
static void append(char *text, size_t size_bytes, const char *separator, double amount, double unit, const char *format,
                   const char *above, const char *below) {
    size_t used = strlen(text);
    if (!(fabs(amount) >= 0.5 * unit)) return;
    used += (size_t)snprintf(text + used, size_bytes - used, "%s", separator);
    if (used < size_bytes) used += (size_t)snprintf(text + used, size_bytes - used, format, fabs(amount));
    if (used < size_bytes) snprintf(text + used, size_bytes - used, " %s", amount > 0 ? above : below);
}

char *vw_next_describe_move(const struct vw_known_views *known, const struct vw_view *pose) {
    static const char *const names[3][2] = {{"right", "left"}, {"up", "down"}, {"back", "forward"}};
    const struct vw_view *photo = find_nearest(known, pose);
    double step[3], back[3], usual_world = known->scales.between_world * known->scales.typical;
    char steps[128] = "", turns[128] = "";
    express(photo, pose, POSITION, step);
    express(photo, pose, BACK, back);
    for (int axis = 0; axis < 3; axis++)
        append(steps, sizeof steps, *steps ? ", " : "", step[axis] / usual_world, 0.1, "%.1f", names[axis][0],
               names[axis][1]);
    double left_deg = atan2(back[RIGHT], back[BACK]) * 180 / M_PI;
    double up_deg = asin(fmin(fmax(-back[UP], -1), 1)) * 180 / M_PI;
    append(turns, sizeof turns, "turn ", left_deg, 1, "%.0f deg", "left", "right");
    append(turns, sizeof turns, *turns ? ", " : "turn ", up_deg, 1, "%.0f deg", "up", "down");
    const char *folder = strrchr(photo->name, '/');
    return vw_format_text("%s: %s%s%s", folder ? folder + 1 : photo->name,
                          *steps   ? steps
                          : *turns ? ""
                                   : "the same place",
                          *steps && *turns ? "; " : "", turns);
}

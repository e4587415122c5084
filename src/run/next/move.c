#include "run/next/move.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"

// Returns a column of a pose along the axes of a photo; its position from there.
static void express(const struct vw_view *photo, const struct vw_view *pose, enum vw_pose_column column,
                    double along[3]) {
    for (int axis = 0; axis < 3; axis++) {
        along[axis] = 0;
        for (int i = 0; i < 3; i++) {
            double start = column == VW_POSE_POSITION ? photo->camera_to_world[i][VW_POSE_POSITION] : 0;
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

char *vw_next_describe_move(const struct vw_known_photos *known, const struct vw_view *pose) {
    static const char *const names[3][2] = {{"right", "left"}, {"up", "down"}, {"back", "forward"}};
    const struct vw_view *photo = vw_known_photo(known, vw_known_photos_nearest(known, pose));
    double step[3], back[3], usual_world = known->scales.between_world * known->scales.typical;
    char steps[128] = "", turns[128] = "";
    express(photo, pose, VW_POSE_POSITION, step);
    express(photo, pose, VW_POSE_BACK, back);
    for (int axis = 0; axis < 3; axis++)
        append(steps, sizeof steps, *steps ? ", " : "", step[axis] / usual_world, 0.1, "%.1f", names[axis][0],
               names[axis][1]);
    double left_deg = atan2(back[VW_POSE_RIGHT], back[VW_POSE_BACK]) * 180 / M_PI;
    double up_deg = asin(fmin(fmax(-back[VW_POSE_UP], -1), 1)) * 180 / M_PI;
    append(turns, sizeof turns, "turn ", left_deg, 1, "%.0f deg", "left", "right");
    append(turns, sizeof turns, *turns ? ", " : "turn ", up_deg, 1, "%.0f deg", "up", "down");
    const char *folder = strrchr(photo->name, '/');
    return vw_format_text("%s: %s%s%s", folder ? folder + 1 : photo->name,
                          *steps   ? steps
                          : *turns ? ""
                                   : "the same place",
                          *steps && *turns ? "; " : "", turns);
}

#include "check/patch.h"

#include <math.h>
#include <string.h>

static const float FLAT_CONTRAST = 2.0F / 255; // standard deviation below which there is nothing to compare

// Centres and scales the values; false where they are flat, or one is NaN.
static bool normalise(struct vw_patch *patch) {
    float mean = 0, squares = 0;
    for (int i = 0; i < VW_PATCH_PIXELS; i++) mean += patch->values[i];
    mean /= VW_PATCH_PIXELS;
    for (int i = 0; i < VW_PATCH_PIXELS; i++) {
        patch->values[i] -= mean;
        squares += patch->values[i] * patch->values[i];
    }
    if (!(squares > VW_PATCH_PIXELS * FLAT_CONTRAST * FLAT_CONTRAST)) return false;
    float scale = 1 / sqrtf(squares);
    for (int i = 0; i < VW_PATCH_PIXELS; i++) patch->values[i] *= scale;
    return true;
}

// Returns whether the corner of a patch has four pixels around it.
static bool has_corner(const struct vw_plane *plane, const double at_px[2], const double steps_px[2][2], int u, int v) {
    double x = at_px[0] + u * steps_px[0][0] + v * steps_px[1][0];
    double y = at_px[1] + u * steps_px[0][1] + v * steps_px[1][1];
    return x >= 0.501 && y >= 0.501 && x < plane->width_px - 1.001 && y < plane->height_px - 1.001; // despite rounding
}

bool vw_patch_read(const struct vw_plane *plane, const double at_px[2], const double steps_px[2][2],
                   struct vw_patch *patch) {
    for (int corner = 0; corner < 4; corner++)
        if (!has_corner(plane, at_px, steps_px, corner & 1 ? VW_PATCH_REACH_PX : -VW_PATCH_REACH_PX,
                        corner & 2 ? VW_PATCH_REACH_PX : -VW_PATCH_REACH_PX))
            return false;
    for (int v = 0; v < VW_PATCH_SIDE; v++) {
        double down = v - VW_PATCH_REACH_PX;
        double x = at_px[0] - 0.5 - VW_PATCH_REACH_PX * steps_px[0][0] + down * steps_px[1][0];
        double y = at_px[1] - 0.5 - VW_PATCH_REACH_PX * steps_px[0][1] + down * steps_px[1][1];
        for (int u = 0; u < VW_PATCH_SIDE; u++, x += steps_px[0][0], y += steps_px[0][1]) {
            int left = (int)x, top = (int)y;
            const float *above = plane->values + (size_t)top * plane->width_px + left;
            const float *below = above + plane->width_px;
            float right = (float)(x - left), lower_share = (float)(y - top);
            float upper = above[0] + right * (above[1] - above[0]), lower = below[0] + right * (below[1] - below[0]);
            patch->values[v * VW_PATCH_SIDE + u] = upper + lower_share * (lower - upper);
        }
    }
    return normalise(patch);
}

bool vw_patch_is_known(const struct vw_plane *plane, const double at_px[2]) {
    if (!(at_px[0] >= VW_PATCH_REACH_PX && at_px[1] >= VW_PATCH_REACH_PX &&
          at_px[0] < (double)plane->width_px - VW_PATCH_REACH_PX &&
          at_px[1] < (double)plane->height_px - VW_PATCH_REACH_PX))
        return false;
    size_t left = (size_t)at_px[0] - VW_PATCH_REACH_PX, top = (size_t)at_px[1] - VW_PATCH_REACH_PX;
    for (size_t i = 0; i < VW_PATCH_PIXELS; i++)
        if (isnan(plane->values[(top + i / VW_PATCH_SIDE) * plane->width_px + left + i % VW_PATCH_SIDE])) return false;
    return true;
}

float vw_patch_correlate(const struct vw_patch *a, const struct vw_patch *b) {
    float sum = 0;
    for (int i = 0; i < VW_PATCH_PIXELS; i++) sum += a->values[i] * b->values[i];
    return sum;
}

bool vw_patch_rays_of(const struct vw_check_photo *photo, const double at_px[2], struct vw_patch_rays *rays) {
    for (int i = 0; i < 3; i++) rays->origin_world[i] = photo->view->camera_to_world[i][VW_POSE_POSITION];
    for (int i = 0; i < 3; i++) {
        const double beside_px[2] = {at_px[0] + (i == 1), at_px[1] + (i == 2)};
        if (!vw_check_unproject(photo, beside_px, 1, rays->directions_world[i])) return false;
        for (int k = 0; k < 3; k++) rays->directions_world[i][k] -= rays->origin_world[k];
    }
    return true;
}

bool vw_patch_warp(const struct vw_patch_rays *rays, double depth, const struct vw_check_photo *from,
                   double there_px[2], double *there_depth, struct vw_patch *patch) {
    double seen_px[3][2], steps_px[2][2];
    for (int i = 0; i < 3; i++) {
        double place[3], beside_depth;
        for (int k = 0; k < 3; k++) place[k] = rays->origin_world[k] + depth * rays->directions_world[i][k];
        if (!vw_check_project(from, place, seen_px[i], i ? &beside_depth : there_depth)) return false;
    }
    memcpy(there_px, seen_px[0], sizeof seen_px[0]);
    for (int i = 0; i < 4; i++) steps_px[i / 2][i % 2] = seen_px[1 + i / 2][i % 2] - there_px[i % 2];
    return vw_patch_read(&from->small, there_px, (const double(*)[2])steps_px, patch);
}

// Returns the correlation with the patch whose first pixel is `corner`; -1 where that is flat or masked.
static float correlate_at(const struct vw_plane *plane, const float *corner, const struct vw_patch *patch) {
    float sum = 0, squares = 0, product = 0;
    for (int v = 0; v < VW_PATCH_SIDE; v++) {
        const float *row = corner + (size_t)v * plane->width_px, *known = patch->values + v * VW_PATCH_SIDE;
        for (int u = 0; u < VW_PATCH_SIDE; u++) {
            float value = row[u] - corner[0]; // so that squares do not cancel
            sum += value;
            squares += value * value;
            product += value * known[u];
        }
    }
    squares -= sum * sum / VW_PATCH_PIXELS;
    if (!(squares > VW_PATCH_PIXELS * FLAT_CONTRAST * FLAT_CONTRAST)) return -1;
    return product / sqrtf(squares);
}

// Returns the correlation at a pixel; -1 where the patch would reach out of the plane.
static float correlate_around(const struct vw_plane *plane, int x_px, int y_px, const struct vw_patch *patch) {
    int left = x_px - VW_PATCH_REACH_PX, top = y_px - VW_PATCH_REACH_PX;
    if (left < 0 || top < 0 || left + VW_PATCH_SIDE > (int)plane->width_px ||
        top + VW_PATCH_SIDE > (int)plane->height_px)
        return -1;
    return correlate_at(plane, plane->values + (size_t)top * plane->width_px + left, patch);
}

// Returns where the parabola through three values, of which the middle one is the greatest, has its peak.
static double peak_between(float before, float middle, float after) {
    double bend = (double)before - 2.0 * middle + after;
    return before > -1 && after > -1 && bend < 0 ? 0.5 * ((double)before - after) / bend : 0;
}

float vw_patch_find(const struct vw_plane *plane, const double at_px[2], const struct vw_patch *patch, int reach_px,
                    double away_px[2]) {
    float best = -1;
    int middle[2] = {(int)floor(at_px[0]), (int)floor(at_px[1])}, found[2] = {middle[0], middle[1]};
    for (int y = middle[1] - reach_px; y <= middle[1] + reach_px; y++)
        for (int x = middle[0] - reach_px; x <= middle[0] + reach_px; x++) {
            float correlation = correlate_around(plane, x, y, patch);
            if (correlation <= best) continue;
            best = correlation;
            found[0] = x, found[1] = y;
        }
    for (int i = 0; i < 2; i++) {
        float before = correlate_around(plane, found[0] - !i, found[1] - i, patch);
        float after = correlate_around(plane, found[0] + !i, found[1] + i, patch);
        away_px[i] = found[i] + 0.5 + fmin(fmax(peak_between(before, best, after), -0.5), 0.5) - at_px[i];
    }
    return best;
}

#include "check/expected.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static const float ALIKE = 0.6F;        // correlation of two photos that say what a third should show
static const float SHOWN = 0.55F;       // correlation with what they say
enum { NEAR_PX = 2 };                   // where it counts as shown
static const double IN_PLACE_PX = 1.25; // where it counts as in place

enum vw_status vw_expected_create(const struct vw_check_photos *photos, struct vw_expected **expected) {
    *expected = vw_allocate(1, sizeof **expected);
    if (!*expected) return VW_ERROR_MEMORY;
    (*expected)->states = vw_allocate(photos->point_count, sizeof *(*expected)->states);
    return (*expected)->states ? VW_OK : VW_ERROR_MEMORY;
}

void vw_expected_destroy(struct vw_expected **expected) {
    if (*expected) free((*expected)->states);
    free(*expected);
    *expected = NULL;
}

// Returns whether the photo was taken between two others.
static bool are_opposite(const struct vw_check_photos *photos, const struct vw_check_photo *photo, uint32_t a,
                         uint32_t b) {
    double product = 0;
    for (int i = 0; i < 3; i++) {
        double from = photo->view->camera_to_world[i][VW_POSE_POSITION];
        product += (photos->list[a].view->camera_to_world[i][VW_POSE_POSITION] - from) *
                   (photos->list[b].view->camera_to_world[i][VW_POSE_POSITION] - from);
    }
    return product < 0;
}

// Computes how two photos show a point, as the pose sees it; false if they do not show it alike.
static bool expect(const struct vw_check_photos *photos, const struct vw_check_photo *photo,
                   struct vw_expected_point *point) {
    struct vw_patch patches[2];
    struct vw_patch_rays rays;
    if (!vw_patch_rays_of(photo, point->at_px, &rays)) return false;
    for (int i = 0; i < 2; i++) {
        double depth;
        const struct vw_check_photo *reference = &photos->list[point->references[i]];
        if (!vw_patch_warp(&rays, point->depth, reference, point->reference_px[i], &depth, &patches[i])) return false;
        point->magnification[i] = vw_check_focal_px(photo) / point->depth * depth / vw_check_focal_px(reference);
    }
    point->between = are_opposite(photos, photo, point->references[0], point->references[1]);
    float alike = vw_patch_correlate(&patches[0], &patches[1]);
    if (!(alike >= ALIKE)) return false;
    float scale = 1 / sqrtf(2 + 2 * alike); // the sum of two vectors of length 1 is longer
    for (int i = 0; i < VW_PATCH_PIXELS; i++)
        point->patch.values[i] = scale * (patches[0].values[i] + patches[1].values[i]);
    return true;
}

// Adds a point that two photos track, if the pose sees it where there is room for more; returns whether it did.
static bool add(const struct vw_check_photos *photos, const struct vw_check_photo *photo, uint8_t *of_cells,
                const struct vw_expected_point *made, struct vw_expected *expected) {
    if (expected->count == VW_EXPECTED_MOST) return false;
    struct vw_expected_point *point = &expected->list[expected->count];
    *point = *made;
    if (!vw_check_project(photo, photos->points[point->point], point->at_px, &point->depth)) return false;
    double x = point->at_px[0] / photo->small.width_px, y = point->at_px[1] / photo->small.height_px;
    if (!(x >= 0 && y >= 0 && x < 1 && y < 1)) return false;
    uint8_t *of_cell =
        &of_cells[(uint32_t)(y * VW_EXPECTED_CELLS) * VW_EXPECTED_CELLS + (uint32_t)(x * VW_EXPECTED_CELLS)];
    if (*of_cell == VW_EXPECTED_OF_CELL || !expect(photos, photo, point)) return false;
    ++*of_cell;
    expected->count++;
    return true;
}

// Notes that one more photo tracks a point.
static void see(const struct vw_check_photos *photos, const struct vw_check_photo *photo, uint32_t other,
                uint32_t point, uint8_t *of_cells, struct vw_expected *expected) {
    uint32_t *state = &expected->states[point];
    const uint32_t first = photos->count + 1; // states: 0, 1 + a photo that tracks it, `first` + a place in the list
    if (*state == UINT32_MAX) return;
    if (*state >= first) {
        struct vw_expected_point *known = &expected->list[*state - first];
        known->between |= are_opposite(photos, photo, known->references[0], other);
        return;
    }
    const struct vw_expected_point made = {.point = point, .references = {*state - 1, other}};
    if (!*state) *state = other + 1;
    else if (*state != other + 1)
        *state = add(photos, photo, of_cells, &made, expected) ? first + expected->count - 1 : UINT32_MAX;
}

void vw_expected_list(const struct vw_check_photos *photos, const struct vw_check_photo *photo, uint32_t without,
                      struct vw_expected *expected) {
    uint8_t of_cells[VW_EXPECTED_CELLS * VW_EXPECTED_CELLS] = {0};
    expected->count = 0;
    memset(expected->states, 0, photos->point_count * sizeof *expected->states);
    for (uint32_t o = 0; o < photo->other_count; o++) {
        const struct vw_check_photo *other = &photos->list[photo->others[o]];
        for (uint32_t i = 0; i < other->point_count && photo->others[o] != without; i++)
            see(photos, photo, photo->others[o], other->points[i], of_cells, expected);
    }
}

double vw_expected_mark(const struct vw_plane *plane, struct vw_expected *expected) {
    uint32_t in_place = 0, known = 0;
    for (uint32_t i = 0; i < expected->count; i++) {
        struct vw_expected_point *point = &expected->list[i];
        double away_px[2];
        point->known = vw_patch_is_known(plane, point->at_px);
        point->shown = point->known && vw_patch_find(plane, point->at_px, &point->patch, NEAR_PX, away_px) >= SHOWN;
        point->in_place = point->shown && hypot(away_px[0], away_px[1]) <= IN_PLACE_PX;
        known += point->known;
        in_place += point->in_place;
    }
    return known >= VW_EXPECTED_FEW ? (double)in_place / known : NAN;
}

// ---- Regions -------------------------------------------------------------------------------------------------------

enum { GRID = 24 };                      // cells along a side
static const double SPREAD = 0.045;      // standard deviation of a point's weight, of the longer side
static const double SUPPORT_LEAST = 0.9; // sum of weights
static const double MISSING_LEAST = 0.6; // share of them of points that are not shown
// Share of the missing points of a region that photos on both sides see, so that hardly anything of the scene hides
// them; a region of WIDE_SHARE of the photo needs none.
static const double BETWEEN_LEAST = 0.15, WIDE_SHARE = 0.3;
// Limits of what a region may have that something strange covers: points missing elsewhere, of which a large region has
// more at its edges; and places that others agree on, per cell inside by those outside.
static const double ELSEWHERE_MOST = 0.07, ELSEWHERE_BY_SHARE = 0.4, OWN_MOST = 0.3;

// Marks the cells around which points are missing.
static void mark_cells(const struct vw_plane *plane, const struct vw_expected *expected, bool cells[GRID * GRID]) {
    double spread_px = SPREAD * (plane->width_px > plane->height_px ? plane->width_px : plane->height_px);
    for (uint32_t c = 0; c < GRID * GRID; c++) {
        double x = (c % GRID + 0.5) / GRID * plane->width_px, y = (c / GRID + 0.5) / GRID * plane->height_px;
        double support = 0, missing = 0;
        for (uint32_t i = 0; i < expected->count; i++) {
            double away = hypot(expected->list[i].at_px[0] - x, expected->list[i].at_px[1] - y) / spread_px;
            double weight = expected->list[i].known ? exp(-0.5 * away * away) : 0;
            support += weight;
            missing += expected->list[i].shown ? 0 : weight;
        }
        cells[c] = support >= SUPPORT_LEAST && missing >= MISSING_LEAST * support;
    }
}

// Moves a region from the cells to `region`, and returns its size.
static uint32_t take_region(bool cells[GRID * GRID], uint32_t start, bool region[GRID * GRID]) {
    uint32_t open[GRID * GRID], count = 0, taken = 0;
    memset(region, 0, GRID * GRID * sizeof *region);
    open[count++] = start;
    cells[start] = false;
    for (; taken < count; taken++) {
        uint32_t x = open[taken] % GRID, y = open[taken] / GRID;
        const uint32_t beside[4] = {x ? open[taken] - 1 : start, x + 1 < GRID ? open[taken] + 1 : start,
                                    y ? open[taken] - GRID : start, y + 1 < GRID ? open[taken] + GRID : start};
        region[open[taken]] = true;
        for (int i = 0; i < 4; i++) {
            if (!cells[beside[i]]) continue;
            cells[beside[i]] = false;
            open[count++] = beside[i];
        }
    }
    return count;
}

static uint32_t cell_of(const struct vw_plane *plane, const double at_px[2]) {
    uint32_t x = (uint32_t)(at_px[0] / plane->width_px * GRID), y = (uint32_t)(at_px[1] / plane->height_px * GRID);
    return y * GRID + x;
}

// Returns whether the points say that something strange is in the region: points are missing there and not elsewhere,
// and others agree on few places that the photo shows there. Where something near hides what is farther away, they do
// agree on it.
static bool is_strange(const struct vw_check_photos *photos, const struct vw_check_photo *photo,
                       const struct vw_expected *expected, const bool region[GRID * GRID], uint32_t size) {
    double count = 0, missing = 0, inside = 0, between = 0, own_inside = 0, own_outside = 0;
    for (uint32_t i = 0; i < expected->count; i++) {
        const struct vw_expected_point *point = &expected->list[i];
        bool is_inside = region[cell_of(&photo->small, point->at_px)];
        if (!point->known) continue;
        inside += is_inside && !point->shown;
        between += is_inside && !point->shown && point->between;
        count += !is_inside;
        missing += !is_inside && !point->shown;
    }
    for (uint32_t i = 0; i < photo->point_count; i++) {
        double at_px[2], depth;
        if (photo->points[i] < photos->scene->point_count) continue; // the file's word
        if (!vw_check_project(photo, photos->points[photo->points[i]], at_px, &depth)) continue;
        if (!(at_px[0] >= 0 && at_px[1] >= 0 && at_px[0] < photo->small.width_px && at_px[1] < photo->small.height_px))
            continue;
        *(region[cell_of(&photo->small, at_px)] ? &own_inside : &own_outside) += 1;
    }
    double share = (double)size / (GRID * GRID);
    return (between >= BETWEEN_LEAST * inside || share > WIDE_SHARE) &&
           missing <= (ELSEWHERE_MOST + ELSEWHERE_BY_SHARE * share) * count &&
           own_inside * (1 - share) <= OWN_MOST * own_outside * share;
}

double vw_expected_hidden(const struct vw_check_photos *photos, const struct vw_check_photo *photo,
                          const struct vw_expected *expected) {
    bool cells[GRID * GRID], region[GRID * GRID];
    uint32_t most = 0;
    if (expected->count < VW_EXPECTED_FEW) return NAN;
    mark_cells(&photo->small, expected, cells);
    for (uint32_t c = 0; c < GRID * GRID; c++) {
        uint32_t size = cells[c] ? take_region(cells, c, region) : 0;
        if (size > most && is_strange(photos, photo, expected, region, size)) most = size;
    }
    return (double)most / (GRID * GRID);
}

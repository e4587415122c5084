// The surface that photos see, by the trained field: coarse depth maps mark cells of the world, and each cell counts
// the photos that see it.
//
// Cells are cubes, 8 of them along the box's edge, each divided by 24 directions of sight: their largest coordinate and
// the signs of all three. Points beyond the box, whose coordinates u are from -1 to 1, are contracted: to u (2 - 1/m) /
// m for the largest coordinate m > 1 (the contraction of mip-NeRF 360, by the largest coordinate).
#ifndef VIEWWORTH_RUN_NEXT_SEEN_SURFACE_H
#define VIEWWORTH_RUN_NEXT_SEEN_SURFACE_H

#include "run/next/candidate_scores.h"

enum { VW_SEEN_WIDTH_PX = 24, VW_SEEN_NOTHING = UINT32_MAX };

struct vw_seen_surface {
    const struct vw_known_views *known; // borrowed
    struct vw_box box;
    uint32_t *counts; // owned; by cell: photos that see it
    uint32_t *last;   // owned; by cell: 1 + the number of the photo that was counted last
    uint32_t photo_count;
};

// The cells that a photo sees: one for each pixel of a coarse picture, VW_SEEN_NOTHING where nothing is.
struct vw_seen_cells {
    uint32_t *cells; // owned (free)
    uint32_t count;
};

// Counts what the known photos see. Destroy it also after a failure.
enum vw_status vw_seen_surface_create(const struct vw_known_views *known, struct vw_seen_surface *surface);
void vw_seen_surface_destroy(struct vw_seen_surface *surface);

// Renders what a photo of this pose would see.
enum vw_status vw_seen_surface_look(const struct vw_seen_surface *surface, const struct vw_view *pose,
                                    struct vw_seen_cells *seen);
// Counts one more photo, each cell once.
void vw_seen_surface_add(struct vw_seen_surface *surface, const struct vw_seen_cells *seen);

// Returns about how many photos see the place of a cell, from any direction.
uint32_t vw_seen_surface_photos(const struct vw_seen_surface *surface, uint32_t cell);

// Returns the cell of a point, seen along a direction from the camera to it.
uint32_t vw_seen_surface_cell(const struct vw_box *box, const double point_world[3], const double direction_world[3]);

#endif

// Small depth maps of poses, as the field sees them: the surface points of a pose, and which known photos see a point.
#ifndef VIEWWORTH_RUN_NEXT_DEPTH_MAPS_H
#define VIEWWORTH_RUN_NEXT_DEPTH_MAPS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { VW_DEPTH_MAP_WIDTH_PX = 24, VW_DEPTH_MAP_HEIGHT_PX = 18 };
enum { VW_DEPTH_MAP_PIXELS = VW_DEPTH_MAP_WIDTH_PX * VW_DEPTH_MAP_HEIGHT_PX };
enum { VW_SEEN_POINTS_MOST = VW_DEPTH_MAP_PIXELS / 4 };

// Renders the depths of poses of the same size, one after another, owned by the caller: vw_trainer_render_poses(), or
// what a test puts in its place.
struct vw_depth_source {
    enum vw_status (*render)(void *context, const uint32_t *views, const struct vw_view *poses, uint32_t count,
                             float **depths_world);
    void *context;
};

struct vw_depth_map {
    struct vw_view pose;                     // with a pinhole camera of the map's size; its pixels need not be square
    float depths_world[VW_DEPTH_MAP_PIXELS]; // along the axis, rows top to bottom; 0: nothing is there
    double nearest_world, median_world;      // 5 % quantile and median of the depths; 0: nothing is there
    uint32_t seen_count;                     // pixels that see something
};

// Makes the map of each pose, owned by the caller (free). An effect that sees photos sees poses[i] by that of views[i].
enum vw_status vw_depth_maps_make(const struct vw_depth_source *source, const uint32_t *views,
                                  const struct vw_view *poses, uint32_t count, struct vw_depth_map **maps);

// A point of a surface, and the camera position that it is looked at from.
struct vw_sight {
    double from_world[3], point_world[3];
};

// Finds the surface point that a pixel sees. Returns false where nothing is there.
bool vw_depth_map_point(const struct vw_depth_map *map, uint32_t pixel, struct vw_sight *sight);
// Returns whether the map's camera sees the same side of a point: it is in the picture, at most a tenth deeper than
// what is there, and the two rays to it are at most 60 degrees apart.
bool vw_depth_map_sees(const struct vw_depth_map *map, const struct vw_sight *sight);

// Points that a pose sees, by every second pixel of every second row of its map, and the maps that see each of them.
struct vw_seen_points {
    double points_world[VW_SEEN_POINTS_MOST][3];
    double seen_by[VW_SEEN_POINTS_MOST]; // maps, up to a limit
    uint32_t count;                      // 0: it sees nothing
};

// Finds them among `count` maps; of each point, no more than `most` maps are looked for.
void vw_seen_points_find(const struct vw_depth_map *map, const struct vw_depth_map *maps, uint32_t count, uint32_t most,
                         struct vw_seen_points *points);
// Returns the median of the maps that see a point; 0 without points.
double vw_seen_points_median(const struct vw_seen_points *points);

#endif

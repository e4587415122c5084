// The photos that a run knows where places for the next ones are looked for, each with a small depth map as the field
// sees it, and the steps that make and choose places.
#ifndef VIEWWORTH_RUN_NEXT_NEXT_PRIVATE_H
#define VIEWWORTH_RUN_NEXT_NEXT_PRIVATE_H

#include "base/statistics.h"
#include "run/next/next.h"
#include "scene/view_distance.h"

struct vw_trainer;

enum { VW_DEPTH_MAP_WIDTH_PX = 24, VW_DEPTH_MAP_HEIGHT_PX = 18 };
enum { VW_DEPTH_MAP_PIXELS = VW_DEPTH_MAP_WIDTH_PX * VW_DEPTH_MAP_HEIGHT_PX };
enum { VW_SEEN_POINTS_MOST = VW_DEPTH_MAP_PIXELS / 4 };

struct vw_depth_map {
    struct vw_view pose;                     // with a pinhole camera of the map's size; its pixels need not be square
    float depths_world[VW_DEPTH_MAP_PIXELS]; // along the axis, rows top to bottom; 0: nothing is there
    double nearest_world, median_world;      // 5 % quantile and median of the depths; 0: nothing is there
    uint32_t seen_count;                     // pixels that see something
};

// Points that a pose sees, by every second pixel of every second row of its map, and the maps that see each of them.
struct vw_seen_points {
    double points_world[VW_SEEN_POINTS_MOST][3];
    double seen_by[VW_SEEN_POINTS_MOST]; // maps, up to a limit
    uint32_t count;                      // 0: it sees nothing
};

// Renders the depths of poses of the same size, one after another, owned by the caller; 0: a ray ends nowhere. An
// effect that sees photos sees poses[i] by that of views[i].
typedef enum vw_status vw_depth_renderer(void *context, const uint32_t *views, const struct vw_view *poses,
                                         uint32_t count, float **depths_world);

struct vw_known_photos {
    const struct vw_scene *scene; // borrowed
    vw_depth_renderer *render;
    void *context;                // borrowed; the renderer has it
    uint64_t seed;                // the run's
    struct vw_view_scales scales; // units of distances between poses
    uint32_t *views;              // owned, as all below; scene indices of photos trained on
    uint32_t count;
    struct vw_depth_map *maps; // one per photo, as all to the next comment
    struct vw_seen_points *points;
    double *values; // scratch
    struct vw_ordered *ordered;
    uint32_t usual;       // place of the photo whose focal length, as a share of its longer side, is in the middle
    double usual_count;   // pixels of a map that see something, as below: the median photo's
    double usual_seen_by; // other photos that see a point of one: the median photo's median
    uint32_t *val_views;  // scene indices of validation photos, those of known errors alone
    double *val_mse;      // the field's squared error at each of them; 0 until it is measured
    uint32_t val_count;
    double usual_mse; // the median of these errors
};

// Looks at the photos of a scene by a renderer and its context. Destroy it also after a failure.
enum vw_status vw_known_photos_create(const struct vw_scene *scene, uint64_t seed, vw_depth_renderer *render,
                                      void *context, struct vw_known_photos *known);
// Measures the field's errors. Photos whose error is not finite are no longer in val_views.
enum vw_status vw_known_photos_measure(struct vw_known_photos *known, struct vw_trainer *trainer);
void vw_known_photos_destroy(struct vw_known_photos *known);
// Returns the photo at a place of `views`.
const struct vw_view *vw_known_photo(const struct vw_known_photos *known, uint32_t photo);
// Returns the place of the one of the nearest position, of equal ones the first.
uint32_t vw_known_photos_nearest(const struct vw_known_photos *known, const struct vw_view *pose);

// Makes the map of each pose, owned by the caller (free), as the renderer sees it by `views`.
enum vw_status vw_depth_maps_make(const struct vw_known_photos *known, const uint32_t *views,
                                  const struct vw_view *poses, uint32_t count, struct vw_depth_map **maps);
// Finds the surface point that a pixel sees. Returns false where nothing is there.
bool vw_depth_map_point(const struct vw_depth_map *map, uint32_t pixel, double point_world[3]);
// Returns whether a map's camera sees the side of a point that is seen from a place: the point is in its picture, at
// most a tenth deeper than what is there, and the two rays to it are at most 60 degrees apart.
bool vw_depth_map_sees(const struct vw_depth_map *map, const double from_world[3], const double point_world[3]);
// Finds the points of a map and the known photos that see them, of each point no more than `most`.
void vw_seen_points_find(const struct vw_depth_map *map, const struct vw_known_photos *known, uint32_t most,
                         struct vw_seen_points *points);
// Returns the median of the photos that see a point; 0 without points.
double vw_seen_points_median(const struct vw_seen_points *points);

// Makes the draw-th pose of a known photo, without a camera and a range of depths. Half of them lie between its camera
// and two of the six nearest ones: their mean with random weights. The others lie beside or beyond it: 0.5 to 2 usual
// distances away in a random direction. A pose looks at what those cameras look at, in the same mean, a quarter of them
// at one of the eight points of the photo that the fewest photos see; its up is theirs. Returns false where no camera
// can be placed so.
bool vw_next_draw_pose(const struct vw_known_photos *known, uint32_t photo, uint32_t draw,
                       double camera_to_world[3][4]);
// Makes up to 400 candidates of such poses, 20 per known photo, at least 200 and at most 2,000 in all. It keeps those
// that are
//   new              a quarter of a usual distance or more away from all photos of the scene,
//   outside matter   nothing is on the line from the nearest known camera to the pose and a quarter beyond it, and
//                    nothing is nearer to the pose than half of the least distance of that camera to matter,
//   inside the seen  they see half as much as the median known photo or more, and two known photos see half of that or
//                    more, from the same side, so that structure from motion can register a photo from there.
// VW_ERROR_INPUT when none is left. Free the candidates also after a failure (vw_camera_path_free).
enum vw_status vw_next_candidates_make(const struct vw_known_photos *known, struct vw_camera_path *candidates);

// Proposes up to `wanted` candidates, one after another, of equal ones the first: the one of the largest distance to
// the nearest view that is known or chosen (vw_view_apart()), times the root of the field's squared error there. This
// is farthest view sampling of NeRF Director (Xiao et al., CVPR 2024), weighted by errors: the mean over validation
// photos, weighted by 1 / (d^2 + 1/4), d being the candidate's distance from each. The root is at least 1e-6, and 1
// without validation photos. Other scores proposed no better photos (src/lab/results/next_photos.md).
enum vw_status vw_next_choose(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next);
// Fills in all members of the proposals but their gains. A place is or has
//   seen by few     points that at most half as many known photos see, in the median, as see those of the median photo,
//   high error      a validation photo at most two usual distances away, the nearest of three or more, whose error is
//                   above their median,
//   extrapolates    more than two usual distances away from the nearest known photo,
//   sees nothing    no matter in view; it is not said to be seen by few,
//   between photos  none of these, and less than a usual distance away from the nearest known photo.
enum vw_status vw_next_describe(const struct vw_known_photos *known, struct vw_next *next);

// Writes the files of vw_next_make(). The trainer has the field.
enum vw_status vw_next_write(const struct vw_next_params *params, const struct vw_next *next,
                             const struct vw_scene *scene, struct vw_trainer *trainer);

#endif

// A scene: posed photos, their cameras and splits, and the box the field lives in. Immutable once opened, and hashed.
//
// World coordinates are double and stay on the host. The field sees *box* coordinates: box = (world - centre) / (2
// half_extent) + 1/2, so that the box is the unit cube.
#ifndef VIEWWORTH_SCENE_H
#define VIEWWORTH_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_split { VW_SPLIT_TRAIN, VW_SPLIT_VAL, VW_SPLIT_TEST, VW_SPLIT_EXCLUDED };
const char *vw_split_name(enum vw_split split); // "train", "val", "test", "excluded"

// Why a pixel of a photo is not to be looked at, as bytes of vw_view.mask.
enum {
    VW_MASK_HIDE = 0,
    VW_MASK_BEYOND_LENS = 1,
    VW_MASK_KEEP = 255
}; // by the mask file; the lens model has no inverse there

// How a lens bends rays, after OpenCV. Pixel (column, row) has its centre at (column + 0.5, row + 0.5) px; y runs down.
// With x = X/Z, y = Y/Z in the OpenCV camera frame (x right, y down, z forward), r2 = x*x + y*y:
//   VW_LENS_POLYNOMIAL: radial = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//     x' = x radial + 2 p1 x y + p2 (r2 + 2 x x);  y' = y radial + p1 (r2 + 2 y y) + 2 p2 x y
//   VW_LENS_FISHEYE: theta = atan(r), theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8); (x', y')
//   = theta' / r (x, y) column = focal_x x' + centre_x, row = focal_y y' + centre_y
enum vw_lens { VW_LENS_POLYNOMIAL, VW_LENS_FISHEYE };

struct vw_camera {
    uint32_t width_px, height_px;    // of the photo as loaded (after --downscale); intrinsics match it
    double focal_x_px, focal_y_px;   // > 0
    double centre_x_px, centre_y_px; // principal point
    enum vw_lens lens;
    double k1, k2, k3, k4, k5, k6, p1, p2; // 0 without distortion
};

struct vw_view {
    char *name;         // owned; path relative to the scene folder, as the scene file spells it; unique
    char *provider;     // owned; "" when unknown
    char *ground_truth; // owned; recipes: the injected defect ("noise", "blur", ...) or "clean"; NULL elsewhere
    enum vw_split split;
    struct vw_camera camera;
    double camera_to_world[3][4]; // rotation and position; OpenGL camera axes: x right, y up, looking along -z; world
                                  // units
    double near_world, far_world; // depths along the axis between which the points that it sees lie; 0, 0 when unknown
    struct vw_image image;
    bool has_mask; // a mask file is there
    uint8_t *mask; // owned; a byte per pixel of image, rows top to bottom: VW_MASK_*. NULL: VW_MASK_KEEP everywhere
    uint8_t sha256[VW_HASH_BYTES]; // of the image file's bytes; of the 8-bit pixels for a recipe
};

// A surface point with the views that see it, as structure from motion emits them.
struct vw_point {
    double position_world[3];
    float rgb[3];                      // [0,1]
    uint32_t first_track, track_count; // range in vw_scene.tracks
};

struct vw_track {
    uint32_t view;    // index in vw_scene.views
    float x_px, y_px; // where that view sees the point
};

struct vw_box {
    double centre_world[3];
    double half_extent_world; // > 0; the box is a cube
};

struct vw_scene {
    char *path;            // owned; as given
    char *format;          // owned; "transforms", "phototourism", "colmap", "recipe"
    struct vw_view *views; // owned; in the order of the scene file (train, val, test file after one another)
    uint32_t view_count;
    uint32_t split_count[4]; // by enum vw_split
    struct vw_box box;
    char *box_source;        // owned; how the box was chosen, for `info`
    float background[3];     // colour behind transparent pixels, [0,1]
    bool has_alpha;          // some view has transparent pixels
    struct vw_point *points; // owned; empty when unknown
    struct vw_track *tracks; // owned
    uint32_t point_count, track_count;
    uint32_t masked_view_count; // views with a mask, excluded ones left out
    char **notes;               // owned; what was skipped or repaired, one line each, for `info`
    uint32_t note_count;
    uint8_t hash[VW_HASH_BYTES]; // of everything above that bears on training: names, splits, image hashes, masks,
                                 // cameras, poses, near and far, box, background, downscale; not of the path
};

struct vw_gpu;

struct vw_scene_params {
    const char *path;   // folder, transforms*.json or recipe .json
    const char *format; // NULL: probe, in this order; "recipe" | "transforms" | "phototourism" | "colmap"
    const char *pool;   // NULL or "all": every registered photo, as in the paper; "list": those a NeRF-W TSV lists
    const char *train_list, *val_list, *test_list; // NULL, or files of names, one a line
    const char *providers;                         // NULL, or a CSV with the header name,provider
    uint32_t downscale;                            // 0 = 1
    uint32_t corrupt; // so many train photos are corrupted, so that truth is known (vw_view.ground_truth); 0: none. See
                      // below.
    bool headers_only;  // read image headers but no pixels and no file hashes; hash stays zero
    struct vw_gpu *gpu; // used to ray-trace recipes; may be NULL for other formats
};

// Injection corrupts photos as a recipe does, whatever the format (but for recipes, which name their own defects): the
// train photos with the smallest random numbers by their names, one after another by noise (0.2), blur (width / 25), an
// occluder (0.4), exposure (0.45), a pose turned by 8 degrees, noise, blur, an occluder, exposure (1.9), ... Numbers,
// noise and occluders depend on the photo's name alone, neither on --seed nor on the order of the scene file; its kind
// also on which others are trained on. A injected photo is kept in 8 bit; sha256 is then of its pixels. Points and
// their tracks stay as the scene file has them.
enum vw_status vw_scene_open(const struct vw_scene_params *params, struct vw_scene **scene);
void vw_scene_close(struct vw_scene **scene);

// The views of a split: scene indices, ascending, owned by the caller also after a failure. `*views` and `*count` are
// zero before.
enum vw_status vw_scene_list_views(const struct vw_scene *scene, enum vw_split split, uint32_t **views,
                                   uint32_t *count);

// Whether a pixel is trained and validated on: neither masked out nor unusable (beyond the lens; NaN, infinite or
// negative in the file).
bool vw_view_keeps(const struct vw_view *view, uint32_t x_px, uint32_t y_px);
// The same where mask files are ignored: not unusable.
bool vw_view_can_use(const struct vw_view *view, uint32_t x_px, uint32_t y_px);

// Depths along a view's axis (world units, > 0) of the points that it sees, by its tracks: those of view v are
// (*depths)[(*ends)[v - 1]] to
// (*depths)[(*ends)[v] - 1], from 0 for the first view, unsorted. `counts` says which tracks do; NULL: all. Both arrays
// are the caller's.
typedef bool vw_track_filter(const void *context, const struct vw_track *track);
enum vw_status vw_scene_depths(const struct vw_scene *scene, vw_track_filter *counts, const void *context,
                               uint32_t **ends, double **depths);

// The direction in camera axes (OpenGL, unnormalised, z = -1) of the ray through image position (x_px, y_px),
// distortion undone by Newton's method in double. Returns false when the distortion has no inverse there, or a fisheye
// looks 1.55 radians off its axis or more.
bool vw_camera_unproject(const struct vw_camera *camera, double x_px, double y_px, double direction_camera[3]);
// The image position of a direction in camera axes (OpenGL); false when it points backwards (z >= 0).
bool vw_camera_project(const struct vw_camera *camera, const double direction_camera[3], double *x_px, double *y_px);
// How far from the principal point, in focal lengths, the lens model can be undone; infinite when it can everywhere.
// Tangential terms, which are small, are left out.
double vw_camera_reach(const struct vw_camera *camera);
// Whether the lens bends rays at all; a fisheye always does.
bool vw_camera_is_distorted(const struct vw_camera *camera);

VW_PUBLIC_END

#endif

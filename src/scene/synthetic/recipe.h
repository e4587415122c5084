// Recipes: procedural scenes. Their photos are ray-traced, and it is known which of them are corrupted (decision 13).
//
// A recipe is a JSON file. z points up; angles are in degrees, lengths in world units, colours in [0,1] and
// sRGB-encoded. Unknown keys are refused. The keys, with defaults in parentheses:
//
//   viewworth_recipe: 1
//   seed: key of random choices and noise (0)
//   image: width_px, height_px; samples_per_pixel: 1, 4, 9, ... 64 (4)
//   box: centre, half_extent; the field covers it, and all content should be inside
//   background: [r,g,b], "sky" (a gradient) or "transparent" (photos have alpha) (black)
//   sun: direction (towards the sun), intensity; ambient: light from all directions; spread_deg: standard deviation,
//     over photos, of the sun's rotation about z (0) (without the key: no sun, ambient 1)
//   exposure: how all photos differ, test and validation photos included. Standard deviations: gain (of the logarithm
//     of a photo's gain), tint (of the logarithm of each channel's additional gain), bias (of each channel's bias)
//     (0)
//   shapes: kind, centre and
//     sphere: radius
//     box: half_extent [x,y,z], turn_deg: rotation about z (0)
//     cylinder: radius, height; it is upright and closed
//     plane: normal ([0,0,1]), radius of its disc (unlimited)
//     texture of any shape: kind plain, checker, stripes or noise; colour; except for plain also second_colour and
//       cell (size of a cell); for stripes also axis: the direction across them ([0,0,1])
//   cameras: path "orbit", centre, radius, count, field_of_view_deg (horizontal); elevation_deg [first, last] ([30,
//     30]), start_deg (0), turns (1), look_at (centre), distortion {k1, k2, p1, p2}, provider, split
//   points: "none" leaves out surface points and who sees them (all)
//   defects: kind, strength, and one of views: [indices], every: n (each n-th clean train view), share: of the train
//     views, by seed. The strength is for
//     noise: standard deviation
//     blur: standard deviation in px
//     occluder: share of the photo that it covers
//     exposure: gain, with bias added after it
//     wrong_pose: rotation of the recorded pose in degrees
//     striped_box: side of a square in front of everything, as a share of the photo's width (at most its height), with
//       ten stripes of random colours; NeRF-W's own occluders have 0.25
//   transients: share of all photos that have a disc of a random colour in front, which the photo's mask hides; size:
//     share of the photo that the disc covers (0.1)
//
// View i is named "view_iii". Without `split` it is val if i % 8 == 0, test if i % 8 == 4, otherwise train. Only train
// views can be corrupted, each by one defect. Points come from the true geometry; a view with a wrong pose has no
// tracks.
#ifndef VIEWWORTH_SCENE_SYNTHETIC_RECIPE_H
#define VIEWWORTH_SCENE_SYNTHETIC_RECIPE_H

#include <stdbool.h>

#include "base/json.h"
#include "interface.h"
#include "viewworth/scene.h"

enum { VW_RECIPE_LIMIT_BYTES = 1 << 24 }; // largest recipe file

// Fills the views (with splits), box, background, points and tracks of an empty scene from params->path. After a
// failure the scene is incomplete; vw_scene_close frees it. With headers_only there are no pixels, hashes or points,
// and params->gpu may be NULL.
enum vw_status vw_recipe_load(const struct vw_scene_params *params, struct vw_scene *scene);

// ---- Internal: the description of a recipe, and the functions that turn it into a scene ----------------------------

enum {
    VW_RECIPE_SHAPES_MAX = 256,
    VW_RECIPE_VIEWS_MAX = 4096,
    VW_RECIPE_DEFECTS_MAX = 64,
    VW_RECIPE_SIDE_MAX_PX = 4096
};

// The kinds of defects, as vw_view.ground_truth names them (vw_recipe_ground_truths).
enum vw_recipe_defect_kind {
    VW_DEFECT_NONE,
    VW_DEFECT_NOISE,
    VW_DEFECT_BLUR,
    VW_DEFECT_OCCLUDER,
    VW_DEFECT_EXPOSURE,
    VW_DEFECT_WRONG_POSE,
    VW_DEFECT_STRIPED_BOX,
};
extern const char *const vw_recipe_ground_truths[];

struct vw_recipe_defect {
    enum vw_recipe_defect_kind kind;
    double strength; // noise: standard deviation; blur: px; occluder: share; exposure: gain; wrong_pose: degrees;
                     // striped_box: side
    double bias;     // bias of an exposure
};

// The uses of a recipe's random numbers: the last counter word of VW_RANDOM_RECIPE.
enum vw_recipe_draw {
    VW_DRAW_CHOICE,
    VW_DRAW_NOISE,
    VW_DRAW_OCCLUDER,
    VW_DRAW_POSE,
    VW_DRAW_EXPOSURE,
    VW_DRAW_TRANSIENT,
    VW_DRAW_SUN
};

struct vw_recipe {
    const char *path;
    uint32_t downscale;
    uint64_t seed;
    uint32_t width_px, height_px; // after downscale
    uint32_t samples_side;        // squared: samples per pixel
    uint32_t background;          // BACKGROUND_*
    float background_colour[3];
    double sun_direction[3]; // unit vector
    double sun_intensity, ambient, sun_spread_deg;
    double gain_spread, tint_spread, bias_spread; // over all photos
    double transient_share, transient_size;
    int points; // 0: all, 1: none
    struct vw_recipe_shape shapes[VW_RECIPE_SHAPES_MAX];
    uint32_t shape_count;
    struct vw_recipe_defect *defects; // per view; owned
};

// Appends a view per camera to the scene, with its true pose, and assigns the splits (recipe_cameras.c).
void vw_recipe_read_cameras(struct vw_json_reader *reader, const json_t *root, const struct vw_recipe *recipe,
                            struct vw_scene *scene);
// Decides which views are corrupted and how, and sets every view's ground_truth (recipe_cameras.c).
void vw_recipe_read_defects(struct vw_json_reader *reader, const json_t *root, struct vw_recipe *recipe,
                            struct vw_scene *scene);

// A photo while it is traced and corrupted, before it is rounded to 8 bit.
struct vw_recipe_photo {
    uint32_t width_px, height_px;
    struct vw_recipe_pixel *pixels; // depth in world units; 0: the pixel shows nothing or an occluder
};

// Rounds a photo to 8 bit, stores it in its view, and hashes it (recipe.c).
enum vw_status vw_recipe_store_photo(const struct vw_recipe_photo *photo, struct vw_view *view);

// recipe_trace.c
struct vw_recipe_tracer;
enum vw_status vw_recipe_tracer_create(struct vw_gpu *gpu, const struct vw_recipe *recipe, const struct vw_scene *scene,
                                       struct vw_recipe_tracer **tracer);
void vw_recipe_tracer_destroy(struct vw_recipe_tracer **tracer);
enum vw_status vw_recipe_trace(struct vw_recipe_tracer *tracer, uint32_t view, struct vw_recipe_photo *photo);

// Adds a transient disc to a photo, and its mask to the view (corruption.c).
enum vw_status vw_recipe_capture(const struct vw_recipe *recipe, uint32_t index, struct vw_recipe_photo *photo,
                                 struct vw_view *view);

// Applies exposure and defect to a view's pixels, or changes its recorded pose (corruption.c).
enum vw_status vw_corrupt_photo(const struct vw_recipe *recipe, uint32_t view, struct vw_recipe_photo *photo);
void vw_corrupt_pose(const struct vw_recipe *recipe, uint32_t view, double camera_to_world[3][4]);

// Draws two independent standard normal numbers.
void vw_recipe_draw_normals(uint32_t word_a, uint32_t word_b, float normals[2]);

// Makes points and tracks from the depths of all views, [view][pixel], while the scene still has the true poses
// (recipe_trace.c).
enum vw_status vw_recipe_make_points(const struct vw_recipe *recipe, const float *depths, struct vw_scene *scene);

#endif

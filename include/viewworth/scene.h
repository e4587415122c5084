// A scene: posed photos, their cameras and splits, and the box that the field covers. Immutable once opened, and
// hashed.
//
// World coordinates are double and stay on the host. The field uses box coordinates, in which the box is the unit cube:
// box = (world - centre) / (2 half_extent) + 1/2.
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

// The use of a pixel of a photo, as bytes of vw_view.mask.
enum {
    VW_MASK_HIDE = 0,        // hidden by the mask file
    VW_MASK_BEYOND_LENS = 1, // the lens model has no inverse there
    VW_MASK_KEEP = 255
};

// Lens models, as in OpenCV. Pixel (column, row) has its centre at (column + 0.5, row + 0.5) px; y points down.
// With x = X/Z, y = Y/Z in the OpenCV camera frame (x right, y down, z forward) and r2 = x*x + y*y:
//   VW_LENS_POLYNOMIAL:
//     radial = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//     x' = x radial + 2 p1 x y + p2 (r2 + 2 x x);  y' = y radial + p1 (r2 + 2 y y) + 2 p2 x y
//   VW_LENS_FISHEYE:
//     theta = atan(r), theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8), (x', y') = theta' / r
//     (x, y)
//   Both: column = focal_x x' + centre_x, row = focal_y y' + centre_y
enum vw_lens { VW_LENS_POLYNOMIAL, VW_LENS_FISHEYE };

struct vw_camera {
    uint32_t width_px, height_px;    // size of the photo as loaded (after --downscale); intrinsics match it
    double focal_x_px, focal_y_px;   // > 0
    double centre_x_px, centre_y_px; // principal point
    enum vw_lens lens;
    double k1, k2, k3, k4, k5, k6, p1, p2; // 0 without distortion
};

// Columns of camera_to_world.
enum vw_pose_column { VW_POSE_RIGHT, VW_POSE_UP, VW_POSE_BACK, VW_POSE_POSITION };

struct vw_view {
    char *name;         // owned; path relative to the scene folder, as the scene file spells it; unique
    char *provider;     // owned; "" when unknown
    char *ground_truth; // owned; label of the injected corruption ("noise", "blur", ...) or "clean"; NULL: unknown
    enum vw_split split;
    double weight; // the share in means over validation photos; 1 unless val_weights or splits say otherwise
    struct vw_camera camera;
    double camera_to_world[3][4]; // rotation and position (world units); OpenGL camera axes: x right, y up, view along
                                  // -z
    double near_world, far_world; // range of depths along the axis of the points that the view sees; 0, 0: unknown
    struct vw_image image;
    bool has_mask;      // the view has a mask file
    bool mask_is_given; // in vw_scene_params.masks
    uint8_t *mask; // owned; VW_MASK_*, a byte per pixel of image, rows top to bottom; NULL: VW_MASK_KEEP everywhere
    uint8_t sha256[VW_HASH_BYTES]; // hash of the image file; of the 8-bit pixels for a recipe and a corrupted photo
};

// A surface point and the views that see it, as structure from motion produces them.
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

// The exposure of a photo beside the others, estimated from the points that it shares with them: it shows what the
// median photo shows as (1 + gain) * colour + bias, per channel, colours as stored in [0,1].
struct vw_exposure {
    double gain[3], bias[3];    // 0, the identity, for a photo that is not trained on or has fewer than 8 observations
    uint32_t observation_count; // its usable pixels of points that another train photo sees
    // Mean squared differences from what the other photos of its points predict, on points that the estimate has not
    // seen: of photos as they are, and by exposures; and the standard error of what exposures take off. NaN: unknown.
    double error_without, error_with, reduction_stderr;
};

// Returns how bright the photo shows mid-grey beside the median photo: 1 alike, 0.5 half as bright.
double vw_exposure_brightness(const struct vw_exposure *exposure);

struct vw_name_index;
struct vw_photo_source;
struct vw_exposures;

struct vw_scene {
    char *path;            // owned; as in vw_scene_params
    char *format;          // owned; "transforms", "phototourism", "colmap", "recipe"
    struct vw_view *views; // owned; in the order of the scene file (or files: train, val, test)
    uint32_t view_count;
    struct vw_name_index *names; // owned; private: finds views by name
    uint32_t split_count[4];     // by enum vw_split
    struct vw_box box;
    char *box_source;        // owned; how the box was chosen, for `info`
    float background[3];     // colour behind transparent pixels, [0,1]
    bool has_alpha;          // some view has transparent pixels
    struct vw_point *points; // owned; empty when unknown
    struct vw_track *tracks; // owned
    uint32_t point_count, track_count;
    bool points_tell_exposures; // at least half of the train photos share 8 points or more with others
    uint32_t masked_view_count; // views with a mask, excluded ones left out
    char **notes;               // owned; what was skipped or repaired, one line each, for `info`
    uint32_t note_count;
    const char *missing; // borrowed from the notes: what was left out because its image file is missing; NULL: nothing
    struct vw_photo_source *source; // owned; private: the photos' files and the place of their pixels; NULL: a recipe
    struct vw_exposures *exposures; // owned; private: see vw_scene_estimate_exposures()
    // Hash of everything above that training depends on: names, splits, weights, image hashes, masks, cameras, poses,
    // near and far, box, background, points, the views that see them and where, features, downscale; not of the path.
    uint8_t hash[VW_HASH_BYTES];
};

// Counts the observations (tracks) of points outside a box.
uint32_t vw_scene_count_outside(const struct vw_scene *scene, const struct vw_box *box);

struct vw_gpu;

struct vw_scene_params {
    const char *path;   // folder, transforms*.json or recipe .json
    const char *format; // "recipe", "transforms", "phototourism" or "colmap"; NULL: the first of these that fits
    const char *pool;   // "all": every registered photo, as in the paper; "list": those in a NeRF-W TSV; NULL: "all"
    // Files with one name per line; NULL: the scene decides. A test_list of "none": its test photos train.
    const char *train_list, *val_list, *test_list;
    const char *splits;      // splits.json of an earlier run, without the lists above; NULL: the scene decides
    const char *val_weights; // CSV file with the header name,weight; NULL: the weights of `splits`, or 1
    // Folder of masks beside those of the scene: vw_mask_name() of a photo, before its own mask. NULL: none.
    const char *masks;
    const char *providers; // CSV file with the header name,provider; NULL: none
    uint32_t downscale;    // factor by which width and height are divided; 0: 1
    uint32_t corrupt;      // number of train photos to corrupt (see below); 0: none
    bool headers_only;     // read image headers, but no pixels and no file hashes; `hash` stays zero
    struct vw_gpu *gpu;    // ray-traces recipes; may be NULL for other formats
};

// Opens a scene; the caller closes it.
//
// params->corrupt injects corruption, as a recipe does, into a scene of any other format (a recipe names its own
// defects). A random number that depends only on a photo's name orders the train photos. The first ones are corrupted,
// in turn by noise (0.2), blur (width / 25), an occluder (0.4), exposure (0.45), a pose rotated by 8 degrees, noise,
// blur, an occluder, exposure (1.9), and so on. So neither --seed nor the order of the scene file matters, but the kind
// of defect depends on which other photos are trained on. A corrupted photo has 8-bit pixels, and its sha256 is of
// these. Points and their tracks are unchanged. vw_view.ground_truth has the labels.
//
// All files are hashed here, but photos of integers without an alpha channel are decoded when they are first needed:
// see vw_scene_decode(). Pixels that are more than the memory for them (see below) live in a file without a name in the
// cache folder, which is mapped; those of recipes and of corrupted photos are always in memory.
enum vw_status vw_scene_open(const struct vw_scene_params *params, struct vw_scene **scene);
void vw_scene_close(struct vw_scene **scene);

// Decodes those of these views (scene indices) that are not yet, several at a time; excluded views stay without pixels.
// Call it before the pixels of vw_view.image are read: reading others ends the program. Any thread may call it; a
// thread may read what its own calls have named. VW_ERROR_IO if a file cannot be decoded, or is no longer the one that
// was hashed. It changes nothing else of the scene.
enum vw_status vw_scene_decode(const struct vw_scene *scene, const uint32_t *views, uint32_t count);
enum vw_status vw_scene_decode_all(const struct vw_scene *scene);

// Returns the exposures of all views, owned by the scene. The first call estimates them, and decodes the train photos;
// any thread may call it. Masked, transparent and saturated pixels take no part. Without points, and in a scene opened
// with headers_only, all are the identity. All train photos of the scene take part, also those that a training leaves
// out.
enum vw_status vw_scene_estimate_exposures(const struct vw_scene *scene, const struct vw_exposure **exposures);

// Returns the bytes that the pixels of a view that is not excluded take, also before they are decoded.
uint64_t vw_view_image_bytes(const struct vw_scene *scene, uint32_t view);

// Returns the size of the photo's file; of a recipe that of the photo as loaded.
void vw_view_file_size(const struct vw_scene *scene, uint32_t view, uint32_t size_px[2]);
// Returns the orientation that its EXIF data gives, 1 to 8; 0: none. Pixels are used as they are stored.
uint32_t vw_view_orientation(const struct vw_scene *scene, uint32_t view);
// Returns the name of the mask of a photo in a folder of masks, owned by the caller: its own without images/
// in front, and .png, as COLMAP names masks. NULL when memory is short.
char *vw_mask_name(const char *photo);

// Limits the memory that the pixels of scenes opened from now on may take; 0, the default: half of the machine's. It is
// never more than the machine has.
void vw_scene_set_memory(uint64_t size_bytes);

// Lists the views of a split as ascending scene indices. `*views` and `*count` must be zero before; the caller frees
// `*views`, also after a failure.
enum vw_status vw_scene_list_views(const struct vw_scene *scene, enum vw_split split, uint32_t **views,
                                   uint32_t *count);

// Returns whether a pixel is used for training and validation: it is not masked, the lens model has an inverse there,
// and its value in the file is neither NaN, infinite nor negative.
bool vw_view_keeps(const struct vw_view *view, uint32_t x_px, uint32_t y_px);
// Returns the same without regard to mask files.
bool vw_view_can_use(const struct vw_view *view, uint32_t x_px, uint32_t y_px);

// Computes the direction in camera axes (OpenGL, not normalised, z = -1) of the ray through image position (x_px,
// y_px). Newton's method in double inverts the lens distortion. Returns false if the distortion has no inverse there,
// or if the ray of a fisheye is 1.55 radians or more off the axis.
bool vw_camera_unproject(const struct vw_camera *camera, double x_px, double y_px, double direction_camera[3]);
// Computes the image position of a direction in camera axes (OpenGL); returns false when it points backwards (z >= 0).
bool vw_camera_project(const struct vw_camera *camera, const double direction_camera[3], double *x_px, double *y_px);
// Returns the distance from the principal point, in focal lengths, up to which the lens model has an inverse; infinite
// if it has one everywhere. Ignores the tangential terms, which are small.
double vw_camera_reach(const struct vw_camera *camera);
// Returns the tangent of the angle off the axis up to which it has one, likewise.
double vw_camera_fold(const struct vw_camera *camera);
// Returns whether the lens distorts; a fisheye always does.
bool vw_camera_is_distorted(const struct vw_camera *camera);
// Returns whether all numbers of two cameras are equal.
bool vw_camera_same(const struct vw_camera *a, const struct vw_camera *b);

VW_PUBLIC_END

#endif

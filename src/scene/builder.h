// A scene while it is opened; internal to src/scene. The loader of a format appends views with their cameras, poses and
// image paths, and sets the box. Then scene.c decides the splits, reads the photos and hashes the scene.
#ifndef VIEWWORTH_SCENE_BUILDER_H
#define VIEWWORTH_SCENE_BUILDER_H

#include <stddef.h>
#include <stdint.h>

#include "base/csv.h"
#include "image/image.h"
#include "image/pixel.h"
#include "scene/name_index.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// The files of a view.
struct vw_scene_builder_photo {
    char *image_path;    // owned
    char *mask_path;     // owned; NULL: none
    char *mask_folder;   // owned; that the mask must be in; NULL: the scene folder
    char *features_path; // owned; NULL: none
    uint8_t features_sha256[VW_HASH_BYTES];
    struct vw_image_header image_header, mask_header;
};

struct vw_scene_builder {
    const struct vw_scene_params *params;
    char *folder;           // owned; the scene folder: all names are relative to it, and no file may be outside of it
    struct vw_scene *scene; // owned until opening succeeds
    struct vw_scene_builder_photo
        *photos; // owned; of each view; NULL when the loader made images and cameras itself (recipes)
    size_t view_capacity, photo_capacity;
    uint32_t missing_count;  // photos without a file, which have no view
    char *missing_name;      // owned; of the first of them
    uint32_t rescaled_count; // photos of another size than their camera
    bool *added;             // owned; of each view: params->splits does not name it; NULL: without such a file
};

// Appends a view and returns it; name and image path are copied. The header is the photo's, for a view that has a file.
// NULL when memory is short.
struct vw_view *vw_scene_builder_add_view(struct vw_scene_builder *builder, const char *name, const char *image_path,
                                          const struct vw_image_header *header);
// Sets the mask file of the view that was added last; the path is copied.
enum vw_status vw_scene_builder_set_mask(struct vw_scene_builder *builder, const char *mask_path);
// Finds the file of a photo in a folder images/ of the scene folder: in the folder `place` beside it with the photo's
// name (if `same_name`), with the name and `ending`, or with `ending` in place of its extension. `*path` is owned by
// the caller; it stays NULL if there is none.
enum vw_status vw_scene_find_beside(const char *folder, const char *image_path, const char *place, const char *ending,
                                    bool same_name, char **path);
// Counts a photo whose file is missing.
enum vw_status vw_scene_builder_count_missing(struct vw_scene_builder *builder, const char *name);
// Adds notes on missing and rescaled photos.
enum vw_status vw_scene_builder_note_repairs(const struct vw_scene_builder *builder);
enum vw_status vw_scene_note(struct vw_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));
// Makes all views findable by name, once the loader has appended them.
enum vw_status vw_scene_index_names(struct vw_scene *scene);
// Finds the view of that name; NULL when there is none. A leading "./" is ignored.
struct vw_view *vw_scene_find_view(const struct vw_scene *scene, const char *name);
// Finds a name in a user's list, which may omit the folder of the photos, as in a COLMAP model, or all folders if only
// one view has that file name.
struct vw_view *vw_scene_find_named(const struct vw_scene *scene, const char *name);
// Returns VW_ERROR_INPUT: a line of a list has a name that the scene does not have.
enum vw_status vw_scene_refuse_name(const char *path, uint32_t line, const char *name);
// Called with every row of a table of photos: the view that its first field names, and that no row before has named.
typedef enum vw_status vw_scene_row_taker(void *context, const struct vw_csv *csv, struct vw_view *view);
// Reads a CSV file with the header name,COLUMN, as that of providers. VW_ERROR_INPUT names file and line.
enum vw_status vw_scene_table_read(const struct vw_scene *scene, const char *path, const char *column,
                                   vw_scene_row_taker *take, void *context);

// Takes the points of a COLMAP model beside another scene file, if the model's cameras are those of the scene
// (formats/colmap.c).
enum vw_status vw_sfm_evidence_find(struct vw_scene_builder *builder);
// Decides the splits: by lists or splits.json, otherwise by the loader, otherwise by every eighth view (splits_file.c).
enum vw_status vw_splits_assign(struct vw_scene_builder *builder);
// Counts the views of each split. VW_ERROR_INPUT if too few are left to train.
enum vw_status vw_splits_count(const char *path, struct vw_scene *scene);
// Moves added photos that are near-duplicates of a validation or test photo to its split (splits_file.c). Needs pixels.
enum vw_status vw_splits_join_duplicates(struct vw_scene_builder *builder);
// Reads the weights of validation photos; without a file those of splits.json stay, or 1 (splits_file.c).
enum vw_status vw_val_weights_settle(const struct vw_scene_builder *builder);
// Copies a provider's name without the spaces around it (providers.c). VW_ERROR_INPUT, without a place, when it has
// characters that cannot be seen.
enum vw_status vw_provider_name_take(const char *text, char **name);
// Reads the providers, NULL: those of the scene are all (providers.c). VW_ERROR_INPUT also when two look alike.
enum vw_status vw_providers_read(const char *path, struct vw_scene *scene);
// Fits the cameras to --downscale, reads and hashes the photos and their masks, and sets has_alpha and the background
// (photo.c).
enum vw_status vw_photos_read(struct vw_scene_builder *builder);
// Finds and hashes the files of features beside the photos (features.c).
enum vw_status vw_features_find(struct vw_scene_builder *builder);
// Corrupts params->corrupt train photos and sets every view's ground_truth (synthetic/corruption.c).
enum vw_status vw_inject_corruption(const struct vw_scene_params *params, struct vw_scene *scene);
// Sets scene->points_tell_exposures, which splits and points decide, and makes room for the estimate (exposures.c).
enum vw_status vw_scene_prepare_exposures(struct vw_scene *scene);
void vw_scene_forget_exposures(struct vw_scene *scene); // when the scene is closed

// ---- Formats: whether a path has one, and its loader; the table of them is in scene.c ----

bool vw_transforms_probe(const char *path);
enum vw_status vw_transforms_load(struct vw_scene_builder *builder); // transforms*.json
bool vw_phototourism_probe(const char *path);
enum vw_status vw_phototourism_load(struct vw_scene_builder *builder); // NeRF-W's Phototourism scenes
bool vw_colmap_probe(const char *path);
enum vw_status vw_colmap_load(struct vw_scene_builder *builder); // photos in images/, or in dense/images

// ---- Files: nothing outside the scene folder is read, and what is checked is what is read, by one descriptor ----

// Opens a plain file of a scene for reading; the caller closes it. `path` begins with `folder`, the scene folder, and a
// slash. VW_ERROR_INPUT if it is not there, is a folder, pipe or device, or lies outside of the folder, after following
// all links. With the folder NULL, the user named the file, which may be anywhere.
enum vw_status vw_scene_file_open(const char *folder, const char *path, int *descriptor);
// Reads the whole file, as vw_file_read() does.
enum vw_status vw_scene_file_read(const char *folder, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes);
// Returns whether a plain file of that name is in a folder.
bool vw_scene_has_file(const char *folder, const char *name);
// Checks that a file can be opened, so that an error is known before any work is done.
enum vw_status vw_scene_file_check(const char *folder, const char *path);
enum vw_status vw_scene_file_hash(const char *folder, const char *path, uint8_t sha256[VW_HASH_BYTES]);
// Opens a photo of the scene and reads its header.
enum vw_status vw_scene_photo_probe(const struct vw_scene_builder *builder, const char *path,
                                    struct vw_image_header *header);

// ---- Cameras, depths and the box ----

// Bounds of numbers in scene files. Within them, quotients and squares of what they describe are floats.
#define VW_FOCAL_LEAST_PX 1e-3
#define VW_FOCAL_MOST_PX 1e9
#define VW_DISTANCE_LEAST_WORLD 1e-18 // between cameras that are not all in one place
#define VW_POSITION_MOST_WORLD 1e12
// Checks the focal lengths of a camera that is fitted to its photo. VW_ERROR_INPUT says `where`, and which `fields`
// gave them.
enum vw_status vw_camera_check(const char *where, const char *fields, const struct vw_camera *camera);

// Scales the camera to photos of this size: each axis by its ratio of pixel counts, so that the photo's edges stay in
// place.
void vw_camera_resize(uint32_t width_px, uint32_t height_px, struct vw_camera *camera);
// Fits the camera to the photo, for a scene file. VW_ERROR_INPUT if the photo has another shape; `where` begins the
// message. Sets `*rescaled` if the sizes differ, and leaves it unchanged otherwise.
enum vw_status vw_camera_fit(const char *where, uint32_t width_px, uint32_t height_px, struct vw_camera *camera,
                             bool *rescaled);

// Computes the unit quaternion w x y z of a pose's rotation.
void vw_pose_quaternion(const double pose[3][4], double quaternion[4]);
// Returns the determinant of the first three numbers of the rows x, y and z.
double vw_determinant(const double *x, const double *y, const double *z);

// Sets near_world and far_world of every view from the depths (along its axis) of the points that it sees: their 0.1
// and 99.9 percentiles, interpolated, as in NeRF-W. 0, 0 if a view sees too few points.
enum vw_status vw_near_far_measure(struct vw_scene *scene);

// A box as instant-ngp declares it: its coordinates are world * scale + offset, and its box is the cube of side
// aabb_scale around 1/2.
struct vw_ngp_box {
    double aabb_scale; // 0: not given
    double scale;
    double offset[3];
};

// Sets box and box_source: from `declared` (NULL: none) if it contains what the cameras look at, otherwise from the
// scene's points if there are enough, otherwise from its cameras.
enum vw_status vw_bounds_choose(const struct vw_ngp_box *declared, struct vw_scene *scene);
// Returns the point closest to all optical axes if it is in front of most cameras, otherwise the centre of the box.
void vw_bounds_focus(const struct vw_scene *scene, double focus_world[3]);

// ---- Masks ---------------------------------------------------------------------------------------------------------

// The pixels of a photo that are used (photo.c). White keeps, black hides. A mask pixel is white if its brightness
// (times its alpha, if it has one) is at least one half.
//
// A mask has the photo's size or an exact multiple or fraction of it: each photo pixel uses the mask pixel at its
// centre. With --downscale, a pixel is kept if every photo pixel that it covers is kept.

// Reads the header of a mask of the scene folder and checks that it fits a photo of this size.
enum vw_status vw_mask_probe(const char *folder, const char *path, uint32_t photo_width_px, uint32_t photo_height_px,
                             struct vw_image_header *header);
// Makes the mask of a photo of this size with --downscale from the file that was read, whose `path` is for messages: a
// byte per pixel, VW_MASK_HIDE or VW_MASK_KEEP, owned by the caller. VW_ERROR_INPUT if it hides everything.
enum vw_status vw_mask_make(const char *path, const struct vw_image *file, uint32_t photo_width_px,
                            uint32_t photo_height_px, uint32_t downscale, uint8_t **mask);

// Marks pixels without a ray in the lens model (the dark corners of a circular fisheye, and pixels beyond the fold of
// a polynomial) in the view's mask (creates it if there is none) and counts them. The mask has the size of the camera.
enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count);

#endif

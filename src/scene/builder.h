// A scene while it is being opened: what the files of src/scene share. A format's loader appends views with their
// cameras, poses and image paths and sets the box; scene.c then decides splits, reads the photos and hashes.
#ifndef VIEWWORTH_BUILDER_H
#define VIEWWORTH_BUILDER_H

#include "scene/formats/photo_list.h"
#include "viewworth/scene.h"

// The files of a view.
struct vw_scene_builder_photo {
    char *image_path; // owned
    char *mask_path;  // owned; NULL: none
};

struct vw_scene_builder {
    const struct vw_scene_params *params;
    char *folder;           // owned; the scene folder, which all names are relative to and nothing may lie outside of
    struct vw_scene *scene; // owned until opening succeeds
    struct vw_scene_builder_photo
        *photos; // owned; of each view; NULL when the loader made images and cameras itself (recipes)
    size_t view_capacity, photo_capacity;
};

// A format that a scene may have. A loader that gives no view to val or test has no opinion on splits.
struct vw_scene_format {
    const char *name;                // as --format takes it
    bool (*probe)(const char *path); // whether the path looks like this format
    enum vw_status (*load)(struct vw_scene_builder *builder);
    enum vw_status (*write_list)(const struct vw_photo_list *list, bool *opens); // see viewworth/photo_list.h
};

// Appends a view and returns it; name and image path are copied. NULL when memory is short.
struct vw_view *vw_scene_builder_add_view(struct vw_scene_builder *builder, const char *name, const char *image_path);
// Gives the view added last a mask file, whose path is copied.
enum vw_status vw_scene_builder_set_mask(struct vw_scene_builder *builder, const char *mask_path);
// Adds a line to the scene's notes.
enum vw_status vw_scene_note(struct vw_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));
// The view of that name; NULL when there is none. A leading "./" is ignored.
struct vw_view *vw_scene_find_view(const struct vw_scene *scene, const char *name);
// The same for a name in a list of the user's: as a COLMAP model has it, without the folder of the photos, or without
// any folders before it where that is one view's alone.
struct vw_view *vw_scene_find_named(const struct vw_scene *scene, const char *name);
// `name` without leading "./".
const char *vw_view_name_of(const char *name);

// transforms_json.c
bool vw_transforms_probe(const char *path);
enum vw_status vw_transforms_load(struct vw_scene_builder *builder);
// phototourism.c
bool vw_phototourism_probe(const char *path);
enum vw_status vw_phototourism_load(struct vw_scene_builder *builder);
// sfm_evidence.c: takes the points of a COLMAP model that lies beside another scene file, when its cameras are those of
// the scene.
enum vw_status vw_sfm_evidence_find(struct vw_scene_builder *builder);
// split.c: lists, then what the loader said, then every eighth view.
enum vw_status vw_splits_assign(const struct vw_scene_params *params, struct vw_scene *scene);
// provider.c
enum vw_status vw_providers_read(const char *path, struct vw_scene *scene);
// photo.c: fits the cameras to --downscale, reads and hashes the photos and their masks, and sets has_alpha and the
// background.
enum vw_status vw_photos_read(struct vw_scene_builder *builder);
// corrupt.c: corrupts params->corrupt train photos and writes every view's truth.
enum vw_status vw_inject_corruption(const struct vw_scene_params *params, struct vw_scene *scene);
// scene_hash.c
void vw_scene_hash(const struct vw_scene *scene, uint32_t downscale, uint8_t hash[VW_HASH_BYTES]);

#endif

// A scene while it is opened; internal to src/scene. The loader of a format appends views with their cameras, poses and
// image paths, and sets the box. Then scene.c decides the splits, reads the photos and hashes the scene.
#ifndef VIEWWORTH_SCENE_BUILDER_H
#define VIEWWORTH_SCENE_BUILDER_H

#include "image/pixel.h"
#include "scene/name_index.h"
#include "viewworth/scene.h"

struct vw_photo_list;

// The files of a view.
struct vw_scene_builder_photo {
    char *image_path; // owned
    char *mask_path;  // owned; NULL: none
    struct vw_image_header image_header, mask_header;
};

struct vw_scene_builder {
    const struct vw_scene_params *params;
    char *folder;           // owned; the scene folder: all names are relative to it, and no file may be outside of it
    struct vw_scene *scene; // owned until opening succeeds
    struct vw_scene_builder_photo
        *photos; // owned; of each view; NULL when the loader made images and cameras itself (recipes)
    size_t view_capacity, photo_capacity;
};

// A scene format. If its loader assigns no view to val or test, split.c decides the splits.
struct vw_scene_format {
    const char *name;                // as --format takes it
    bool (*probe)(const char *path); // whether the path has this format
    enum vw_status (*load)(struct vw_scene_builder *builder);
    enum vw_status (*write_list)(const struct vw_photo_list *list, bool *opens); // see scene/formats/photo_list.h
};

// Appends a view and returns it; name and image path are copied. The header is the photo's, for a view that has a file.
// NULL when memory is short.
struct vw_view *vw_scene_builder_add_view(struct vw_scene_builder *builder, const char *name, const char *image_path,
                                          const struct vw_image_header *header);
// Sets the mask file of the view that was added last; the path is copied.
enum vw_status vw_scene_builder_set_mask(struct vw_scene_builder *builder, const char *mask_path);
// Adds a line to the scene's notes.
enum vw_status vw_scene_note(struct vw_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));
// Makes all views findable by name, once the loader has appended them.
enum vw_status vw_scene_index_names(struct vw_scene *scene);
// Finds the view of that name; NULL when there is none. A leading "./" is ignored.
struct vw_view *vw_scene_find_view(const struct vw_scene *scene, const char *name);
// Finds a name in a user's list, which may omit the folder of the photos, as in a COLMAP model, or all folders if only
// one view has that file name.
struct vw_view *vw_scene_find_named(const struct vw_scene *scene, const char *name);

// Loads transforms*.json (transforms_json.c).
bool vw_transforms_probe(const char *path);
enum vw_status vw_transforms_load(struct vw_scene_builder *builder);
// Loads NeRF-W's Phototourism scenes (phototourism.c).
bool vw_phototourism_probe(const char *path);
enum vw_status vw_phototourism_load(struct vw_scene_builder *builder);
// Takes the points of a COLMAP model beside another scene file, if the model's cameras are those of the scene
// (sfm_evidence.c).
enum vw_status vw_sfm_evidence_find(struct vw_scene_builder *builder);
// Decides the splits: by lists, otherwise by the loader, otherwise by every eighth view (split.c).
enum vw_status vw_splits_assign(const struct vw_scene_params *params, struct vw_scene *scene);
// Reads the providers (provider.c).
enum vw_status vw_providers_read(const char *path, struct vw_scene *scene);
// Fits the cameras to --downscale, reads and hashes the photos and their masks, and sets has_alpha and the background
// (photo.c).
enum vw_status vw_photos_read(struct vw_scene_builder *builder);
// Corrupts params->corrupt train photos and sets every view's ground_truth (synthetic/injected_corruption.c).
enum vw_status vw_inject_corruption(const struct vw_scene_params *params, struct vw_scene *scene);
// Hashes everything that training depends on (scene_hash.c).
void vw_scene_hash(const struct vw_scene *scene, uint32_t downscale, uint8_t hash[VW_HASH_BYTES]);

#endif

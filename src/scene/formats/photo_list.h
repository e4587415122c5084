// Writes the list of photos to train on, in the format of the scene, from the scene's own files but without its images.
// It does not check whether photos or poses have changed since the run, only whether the scene still names all photos.
#ifndef VIEWWORTH_SCENE_FORMATS_PHOTO_LIST_H
#define VIEWWORTH_SCENE_FORMATS_PHOTO_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_listed_photo {
    const char *name; // vw_view.name
    enum vw_split split;
    bool chosen;        // for a train photo: whether it stays one
    const char *sha256; // hash of the file that was valued, in hex; NULL: unknown. Only copies look at it
};

struct vw_photo_list {
    const char *scene_path;               // as in vw_scene_params; NULL: no scene, which gives a plain list
    const char *scene_format;             // as in vw_scene_params, too
    const struct vw_listed_photo *photos; // all views of the scene, in its order
    uint32_t photo_count;
    const char *to;  // file or folder to write; must not exist, except for a folder without files of these names
    bool check_only; // refuse what would be refused, but write nothing
};

// Writes `to` completely or not at all. `*format` is static: "phototourism", "transforms", "colmap" or "text".
// `*opens`: vw_scene_open() accepts the result as a scene; otherwise it is a list for vw_scene_params.train_list.
// Validation and test photos keep their splits.
// - phototourism: the scene's NeRF-W TSV, with rows and columns in its order, without the rows of train photos that are
//   not chosen. Chosen photos that the TSV does not list (--pool all) are added. Those without an id, which some
//   trainers ignore, get COLMAP's id.
// - transforms: if `to` ends with .json, one file with the frames of all splits and the keys train_filenames,
//   val_filenames and test_filenames, as in nerfstudio. Otherwise `to` is a folder (its name without a dot, or with a
//   slash at the end) with transforms_train.json, transforms_val.json and transforms_test.json. Frames and other keys
//   stay as they are, except for relative paths (keys that end with _path), which become relative to the place of `to`.
//   It opens as a scene if that is the scene's folder or a parent of it, because scenes read nothing outside their
//   folder.
// - colmap: the chosen photos for COLMAP's image_list_path: one name per line, as in the model.
// - text, for recipes and without a scene: the names of the chosen photos, one per line.
// VW_ERROR_USAGE if `to` exists or would change how the scene's folder is read; VW_ERROR_INPUT if the scene does not
// name a photo, and for names that the format cannot represent.
enum vw_status vw_photo_list_write(const struct vw_photo_list *list, const char **format, bool *opens);

// ---- Shared by the writers; internal ----

// Returns whether the photo belongs in a list with all splits.
bool vw_photo_list_keeps(const struct vw_listed_photo *photo);
// Returns VW_ERROR_INPUT with the message that a photo of the list is no longer in the scene.
enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo);
// Returns VW_ERROR_USAGE if `path` exists.
enum vw_status vw_photo_list_check_new(const char *path);
// Returns VW_ERROR_USAGE if the scene's folder would be read as another scene after the list is written to `path`.
enum vw_status vw_photo_list_check_place(const struct vw_photo_list *list);
// Returns the scene's folder, owned by the caller; NULL when memory is short.
char *vw_photo_list_scene_folder(const struct vw_photo_list *list);
// Finds the relative path from a folder to the scene's: "" (the same), "../", "../a/b/". Owned by the caller.
// VW_ERROR_USAGE if `from` does not exist, or if the path is not UTF-8.
enum vw_status vw_photo_list_way(const struct vw_photo_list *list, const char *from, char **way);

// Writes one format, as vw_photo_list_write() describes; `*opens` is false before.
enum vw_status vw_names_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_colmap_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_phototourism_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_transforms_write_list(const struct vw_photo_list *list, bool *opens);

#endif

// The list of the photos to train on, for other trainers: in the format that a scene came in, from the scene's own
// files without its images. Whether photos or poses have changed since the scene was opened is therefore not looked at,
// only whether all photos are still named.
#ifndef VIEWWORTH_PHOTO_LIST_H
#define VIEWWORTH_PHOTO_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_listed_photo {
    const char *name; // as vw_view.name has it
    enum vw_split split;
    bool chosen; // of a photo to train on: whether it stays one
};

struct vw_photo_list {
    const char *scene_path;               // as in vw_scene_params; NULL: no scene, which gives a plain list
    const char *scene_format;             // likewise
    const struct vw_listed_photo *photos; // all views of the scene, in its order
    uint32_t photo_count;
    const char *to; // what to write; must not exist, but for a folder without files of these names
};

// Writes `to`, whole or not at all. `*format` is static: "phototourism", "transforms", "colmap" or "text". `*opens`: it
// is a scene that vw_scene_open() takes, and not only a list for vw_scene_params.train_list. Validation and test photos
// keep their splits.
// - phototourism: the NeRF-W TSV of the scene, rows and columns in its order, without the rows of train photos that are
// not chosen; chosen
//   ones that the TSV does not list (--pool all) are added, and those without an id, which some trainers pass over, get
//   COLMAP's.
// - transforms: a `to` that ends with .json is one file with the frames of all splits, told apart by the keys
// train_filenames,
//   val_filenames and test_filenames, as nerfstudio reads them; any other is a folder (its name without a dot, or with
//   a slash behind) of transforms_train.json, transforms_val.json and transforms_test.json. Frames and all other keys
//   stay as they are, but for relative paths (keys that end with _path), which lead from where `to` is. It opens as a
//   scene when that is the scene's folder or one above, since scenes read nothing outside their folder.
// - colmap: the chosen photos as COLMAP's image_list_path takes them: a name a line, as the model spells it.
// - text, for recipes and where there is no scene: the chosen photos' names, one a line.
// VW_ERROR_USAGE for a `to` that exists or would change what the scene's folder is read as; VW_ERROR_INPUT where the
// scene lacks a photo, and for names that do not fit the format.
enum vw_status vw_photo_list_write(const struct vw_photo_list *list, const char **format, bool *opens);

#endif

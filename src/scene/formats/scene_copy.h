// A copy of a scene for other trainers: images/, masks/, features/, sparse/0 (COLMAP) and transforms.json (nerfstudio).
#ifndef VIEWWORTH_SCENE_FORMATS_SCENE_COPY_H
#define VIEWWORTH_SCENE_FORMATS_SCENE_COPY_H

#include "base/interrupt.h"
#include "scene/formats/photo_list.h"
#include "viewworth/scene.h"

// Returns VW_ERROR_USAGE unless the scene has photo files and `folder` is free for a copy: it does not exist, or is an
// empty folder.
enum vw_status vw_scene_copy_check(const char *folder, const struct vw_scene *scene);
// Makes the folder list->to, whole or not at all: the photos that the list keeps, byte for byte, with their masks,
// maps of features, cameras, the points that two of them see, and where they see these. `scene` was opened with
// headers_only and without downscale, from files. A photo is in images/ under its name in the scene without the folders
// that all photos share. A mask is in masks/ under that name and its own extension, a map in features/. VW_ERROR_INPUT:
// a photo is no longer in the scene, is not the one that was valued, or has the name of another one. The interrupt is
// asked before every photo.
enum vw_status vw_scene_copy(const struct vw_photo_list *list, const struct vw_scene *scene,
                             const struct vw_interrupt *interrupt);

// ---- Internal: the files of a copy. Names of views are relative to images/ ----

// Writes cameras.bin, images.bin and points3D.bin.
enum vw_status vw_colmap_write(const struct vw_scene *scene, const char *folder);
// Writes transforms.json. masks[i]: the mask of view i, relative to the folder; NULL: none.
enum vw_status vw_transforms_write(const struct vw_scene *scene, char *const *masks, const char *folder);

#endif

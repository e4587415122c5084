// What the formats share in writing lists of photos.
#ifndef VIEWWORTH_SCENE_PHOTO_LIST_H
#define VIEWWORTH_SCENE_PHOTO_LIST_H

#include "scene/formats/photo_list.h"

// The photo of that name (a leading "./" is ignored); NULL when there is none.
const struct vw_listed_photo *vw_photo_list_find(const struct vw_photo_list *list, const char *name);
// Whether the photo belongs into a list that holds all splits.
bool vw_photo_list_keeps(const struct vw_listed_photo *photo);
// VW_ERROR_INPUT: a photo of the list is not in the scene any more.
enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo);
// VW_ERROR_USAGE when something is at `path`.
enum vw_status vw_photo_list_check_new(const char *path);
// VW_ERROR_USAGE when the list, by its name and place, would make another scene of the scene's folder.
enum vw_status vw_photo_list_check_place(const struct vw_photo_list *list);
// The scene's folder, owned by the caller; NULL when memory is short.
char *vw_photo_list_scene_folder(const struct vw_photo_list *list);
// The way from a folder to the scene's: "" (the same), "../", "../a/b/". Owned by the caller. VW_ERROR_USAGE when
// `from` does not exist, or when the way is no UTF-8.
enum vw_status vw_photo_list_way(const struct vw_photo_list *list, const char *from, char **way);

// The writers of the formats, as vw_photo_list_write() describes them; `*opens` is false before.
enum vw_status vw_names_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_colmap_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_phototourism_write_list(const struct vw_photo_list *list, bool *opens);
enum vw_status vw_transforms_write_list(const struct vw_photo_list *list, bool *opens);

#endif

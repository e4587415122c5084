// Shared by the writers of photo lists; internal.
#ifndef VIEWWORTH_SCENE_FORMATS_PHOTO_LIST_WRITERS_H
#define VIEWWORTH_SCENE_FORMATS_PHOTO_LIST_WRITERS_H

#include "scene/formats/photo_list.h"

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

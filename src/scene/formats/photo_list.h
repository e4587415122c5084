// The list of photos to train on, in a file: their names, or the scene's NeRF-W TSV. Writing does not check whether
// photos or poses have changed since the run.
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
    const char *scene_path;               // as in vw_scene_params; NULL: no scene
    const struct vw_listed_photo *photos; // all views of the scene, in its order
    uint32_t photo_count;
    const char *to;  // file to write; must not exist
    bool check_only; // refuse what would be refused, but write nothing
};

// Writes `to` completely or not at all, as its extension says; vw_scene_params.train_list takes the result.
// - .txt: the names of the chosen photos, one per line.
// - .tsv, of a PhotoTourism scene: its NeRF-W TSV, with rows and columns in its order, without the rows of train photos
//   that are not chosen. Validation and test photos keep their splits. Chosen photos that the TSV does not list (--pool
//   all) are added. Those without an id, which some trainers ignore, get COLMAP's id.
// VW_ERROR_USAGE for another extension, and if `to` exists or would be a second TSV of the scene; VW_ERROR_INPUT if the
// scene does not name a photo, and for names that the format cannot represent.
enum vw_status vw_photo_list_write(const struct vw_photo_list *list);
// Returns "phototourism" for a TSV, otherwise "text".
const char *vw_photo_list_format(const char *to);

// Sets chosen[v] for the train views v that the file names; `chosen` has an entry per view and is all false before.
// `*passed_over` counts entries that are skipped because they are not train photos. The kinds of files:
// - scores, if `least` is not NULL: a CSV with the header name,score; chooses photos with a score of at least `*least`
//   and skips others.
// - a NeRF-W TSV, recognised by its header: its train rows with an id, because programs that look photos up by id train
//   on these. Rows whose photo does not exist are skipped, as when such a TSV is opened as a scene.
// - a transforms file, if the name ends in .json: the photos of its frames; photos that are not train photos here are
//   skipped. Paths may start elsewhere: leading folders are ignored until the rest names a photo.
// - otherwise names, one per line; each must be a train photo.
// Names are as in the scene, or without leading folders if only one photo has that file name. VW_ERROR_INPUT names file
// and line (or frame) of a photo that is not in the scene or is scored twice; also if the file names no train photo at
// all.
enum vw_status vw_train_list_read(const struct vw_scene *scene, const char *path, const double *least, bool *chosen,
                                  uint32_t *passed_over);

// ---- Internal -------------------------------------------------------------------------------------------------------

// Returns whether the photo belongs in a list with all splits.
bool vw_photo_list_keeps(const struct vw_listed_photo *photo);
// Returns VW_ERROR_INPUT with the message that a photo of the list is no longer in the scene.
enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo);

#endif

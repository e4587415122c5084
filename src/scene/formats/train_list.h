// Reads which photos of a scene to train on, from a file.
#ifndef VIEWWORTH_SCENE_FORMATS_TRAIN_LIST_H
#define VIEWWORTH_SCENE_FORMATS_TRAIN_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Sets chosen[v] for the train views v that the file names; `chosen` has an entry per view and is all false before.
// `*passed_over` counts entries that are skipped because they are not train photos. The kinds of files:
// - scores, if `least` is not NULL: a CSV with the header name,score; chooses photos with a score of at least `*least`
// and
//   skips others.
// - a NeRF-W TSV, recognised by its header: its train rows with an id, because programs that look photos up by id train
// on
//   these. Rows whose photo does not exist are skipped, as when such a TSV is opened as a scene.
// - a transforms file, if the name ends in .json: the photos of its frames; photos that are not train photos here are
//   skipped. Paths may start elsewhere: leading folders are ignored until the rest names a photo.
// - otherwise names, one per line; each must be a train photo.
// Names are as in the scene, or without leading folders if only one photo has that file name. VW_ERROR_INPUT names file
// and line (or frame) of a photo that is not in the scene or is scored twice; also if the file names no train photo at
// all.
enum vw_status vw_train_list_read(const struct vw_scene *scene, const char *path, const double *least, bool *chosen,
                                  uint32_t *passed_over);

#endif

// A choice among a scene's photos to train on, as a file names it.
#ifndef VIEWWORTH_SCENE_TRAIN_LIST_H
#define VIEWWORTH_SCENE_TRAIN_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Marks the views in the split train that the file names, by scene index: `chosen` has an entry per view, and is false
// before.
// `*passed_over` counts what is left out because it is no photo to train on. What a file is, it shows itself:
// - scores, when `least` is not NULL: a CSV with the header name,score; photos scored at least `*least` are chosen.
// Others are passed over.
// - a NeRF-W TSV, by its header: its train rows with an id, which is the list that programs which look photos up by id
// train on. As where
//   such a TSV makes a scene, rows whose photo is not there are passed over.
// - a transforms file, by a name that ends in .json: the photos of its frames; those that do not train here are passed
// over. Their paths may
//   lead from elsewhere: folders in front are left out until the rest names a photo.
// - else plain names, one a line, each of which must be a photo to train on.
// Names are spelled as the scene's, or without the folders in front where that is one photo's alone. VW_ERROR_INPUT
// names file and line (or frame) of a photo that the scene does not have, of one scored twice, and a file that names no
// photo to train on at all.
enum vw_status vw_train_list_read(const struct vw_scene *scene, const char *path, const double *least, bool *chosen,
                                  uint32_t *passed_over);

#endif

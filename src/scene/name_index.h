// Finds names among many without looking at each: opening a scene and writing its lists take n log n. The names are
// sorted from their ends, so that those with a common end (the same path in another folder) are neighbours.
#ifndef VIEWWORTH_SCENE_NAME_INDEX_H
#define VIEWWORTH_SCENE_NAME_INDEX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

struct vw_name_index {
    struct vw_indexed_name *sorted; // owned
    size_t count;
};

// Makes the index of an array of `place_count` items, each with a const char * at `name_offset`: NULL for none,
// borrowed for as long as the index lives. A leading "./" of a name is ignored, here and when looked for. The caller
// clears the index, also after a failure.
enum vw_status vw_name_index_make(const void *items, size_t item_bytes, size_t name_offset, size_t place_count,
                                  struct vw_name_index *index);
void vw_name_index_clear(struct vw_name_index *index); // accepts a zeroed one

// Finds the first place that has this name. False: none.
bool vw_name_index_find(const struct vw_name_index *index, const char *name, size_t *place);
// Finds the only place whose name ends with a slash and this name. False: there is none, or there are more.
bool vw_name_index_find_ending(const struct vw_name_index *index, const char *name, size_t *place);
// Skips leading "./" of `name`.
const char *vw_view_name_of(const char *name);

#endif

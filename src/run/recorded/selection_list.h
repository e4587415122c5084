// Writes a selection of a run's photos as a list in the format of the scene.
#ifndef VIEWWORTH_RUN_RECORDED_SELECTION_LIST_H
#define VIEWWORTH_RUN_RECORDED_SELECTION_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "run/recorded/scored_run.h"
#include "viewworth/selection.h"

struct vw_selection_list {
    const char *format;   // static; what was written
    bool opens;           // the list is a scene
    uint32_t train_count; // photos that the run was trained on
};

// Writes to the path `to`, as vw_photo_list_write() does. The selection is of the run's images.
enum vw_status vw_selection_list_write(const struct vw_scored_run *run, const struct vw_selection *selection,
                                       const char *to, struct vw_selection_list *list);

#endif

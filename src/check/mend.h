// A copy of a scene in which photos stand where the check found them.
#ifndef VIEWWORTH_CHECK_MEND_H
#define VIEWWORTH_CHECK_MEND_H

#include "base/interrupt.h"
#include "check/check.h"

// All borrowed for the call.
struct vw_mend_params {
    const struct vw_scene_params *opened; // as the scene that was checked was opened
    const struct vw_scene *scene;         // that scene
    const struct vw_check *check;
    const char *to; // folder, as for vw_scene_copy()
    const struct vw_interrupt *interrupt;
};

// Copies all photos that are not excluded (scene/formats/scene_copy.h): those with the defect VW_DEFECT_POSE get the
// pose that was found, and nothing else is changed. Counts them. VW_ERROR_INPUT also if files have changed since.
enum vw_status vw_check_mend(const struct vw_mend_params *params, uint32_t *mended);

#endif

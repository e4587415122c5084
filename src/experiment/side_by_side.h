// Renders of the same photo by several trainings, beside the photo.
#ifndef VIEWWORTH_EXPERIMENT_SIDE_BY_SIDE_H
#define VIEWWORTH_EXPERIMENT_SIDE_BY_SIDE_H

#include <stdint.h>

#include "viewworth/status.h"

// Writes to `to` the photo of the first picture, then the render of each. Pictures are photo and render side by side,
// as whole_views.h leaves them, all of the same view. VW_ERROR_INPUT when one is of another size, or cannot be read.
enum vw_status vw_side_by_side_write(const char *to, char *const *pictures, uint32_t count);

#endif

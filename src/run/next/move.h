// The way from a photo to a place, as a photographer goes it.
#ifndef VIEWWORTH_RUN_NEXT_MOVE_H
#define VIEWWORTH_RUN_NEXT_MOVE_H

#include "run/next/known_photos.h"

// Returns the way to a pose from the known photo of the nearest position, owned by the caller: its name without the
// folder, steps along its own axes in usual distances between neighbours, and turns, such as
// "view_011: 1.9 right, 0.4 up, 0.1 back; turn 40 deg left, 20 deg down". NULL: memory is short.
char *vw_next_describe_move(const struct vw_known_photos *known, const struct vw_view *pose);

#endif

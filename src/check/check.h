// Defects of photos by their pixels, cameras and points, without training.
//
// Points are the scene's and, where photos track few, places that photos show alike (check/make_points.c). Photos near
// a photo, by position and direction, say which points it should show and how: a point counts if two of them show it
// alike, by normalised correlation of small patches that are warped to the photo's pose. Neither the photo's own tracks
// nor its own pixels take part. So a photo is compared with what its pose sees, whatever the scene's file says of it.
#ifndef VIEWWORTH_CHECK_CHECK_H
#define VIEWWORTH_CHECK_CHECK_H

#include "check/evidence.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Checks all photos that are not excluded, and decodes them. VW_ERROR_MEMORY, VW_ERROR_IO.
enum vw_status vw_check_scene(const struct vw_scene *scene, struct vw_check *check);
void vw_check_free(struct vw_check *check); // accepts a zeroed one

#endif

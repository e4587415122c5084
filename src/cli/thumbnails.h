// Small pictures of a run's photos, for its report.
#ifndef VIEWWORTH_CLI_THUMBNAILS_H
#define VIEWWORTH_CLI_THUMBNAILS_H

#include <stdint.h>

#include "cli/recorded_run.h"
#include "viewworth/report.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// One per view of the scene, in its order, none for excluded ones; owned by the caller (vw_thumbnails_free).
enum vw_status vw_thumbnails_make(const struct vw_scene *scene, struct vw_report_picture **pictures);
// The same of a recorded run, whose scene is opened again for it, on `device` where it takes one. An error says why there are none: nothing
// else is lost by it.
enum vw_status vw_thumbnails_make_again(const struct vw_recorded_run *run, const char *device, struct vw_report_picture **pictures);
void vw_thumbnails_free(struct vw_report_picture *pictures, uint32_t count);

#endif

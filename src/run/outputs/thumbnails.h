// Small pictures of a scene's photos, for reports.
#ifndef VIEWWORTH_RUN_OUTPUTS_THUMBNAILS_H
#define VIEWWORTH_RUN_OUTPUTS_THUMBNAILS_H

#include <stdint.h>

#include "report/page.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// One per view of a scene, in its order, without bytes for excluded ones. Owned by who made it; all zero: none.
struct vw_thumbnails {
    char **names;
    struct vw_report_picture *pictures;
    uint32_t count;
};

// A scene as a folder recorded it. All is borrowed.
struct vw_recorded_scene {
    const char *out;                        // the folder
    const char *path, *options_json, *hash; // as vw_reopen_scene() takes them, and its hash in hex
};

// Estimates the seconds that the thumbnails of all photos take, by timing one.
double vw_thumbnails_estimate_s(const struct vw_scene *scene);
enum vw_status vw_thumbnails_make(const struct vw_scene *scene, struct vw_thumbnails *thumbnails);
// Makes the thumbnails of a recorded scene, which is opened for it; recipes need `device`. A failure says why there are
// none and loses nothing else.
enum vw_status vw_thumbnails_make_again(const struct vw_recorded_scene *recorded, const char *device,
                                        struct vw_thumbnails *thumbnails);
void vw_thumbnails_free(struct vw_thumbnails *thumbnails);

#endif

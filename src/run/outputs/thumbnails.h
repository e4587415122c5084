// Small pictures of a scene's photos, for reports.
#ifndef VIEWWORTH_THUMBNAILS_H
#define VIEWWORTH_THUMBNAILS_H

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

// A scene as a folder recorded it. Borrowed.
struct vw_recorded_scene {
    const char *out;                        // the folder
    const char *path, *options_json, *hash; // as vw_reopen_scene() takes them, and its hash in hex
};

// Seconds that those of all photos would take, by timing one.
double vw_thumbnails_estimate_s(const struct vw_scene *scene);
enum vw_status vw_thumbnails_make(const struct vw_scene *scene, struct vw_thumbnails *thumbnails);
// The same of a scene that is opened again for it, on `device` where it takes one. An error says why there are none:
// nothing else is lost by it.
enum vw_status vw_thumbnails_make_again(const struct vw_recorded_scene *recorded, const char *device,
                                        struct vw_thumbnails *thumbnails);
void vw_thumbnails_free(struct vw_thumbnails *thumbnails);

#endif

// A small scene in memory, without files: cameras on an orbit around the box, photos of a smooth function of the
// direction.
#ifndef VIEWWORTH_TESTS_SUPPORT_SYNTHETIC_SCENE_H
#define VIEWWORTH_TESTS_SUPPORT_SYNTHETIC_SCENE_H

#include "viewworth/scene.h"

struct synthetic_scene_params {
    uint32_t train_views, val_views;
    uint32_t width_px, height_px;
    double k1;           // radial distortion
    bool alpha;          // the lower half of every photo is half transparent, on white
    double world_offset; // metres added to every world coordinate
    double world_scale;  // 0 = 1
};

// Makes a scene, owned by the test (cmocka_test.h).
struct vw_scene *synthetic_scene(const struct synthetic_scene_params *params);
// Opens a scene on disk, read with test_gpu() and owned likewise.
struct vw_scene *test_scene_open(struct vw_scene_params params);

#endif

#include "support/synthetic_scene.h"

#include "support/cmocka_test.h"

#include "base/hash.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "support/gpu_fixture.h"
#include "support/tiny_scene.h"

static uint8_t to_byte(double value) { return (uint8_t)lrint(255.0 * fmin(fmax(value, 0.0), 1.0)); }

static void paint(struct vw_image *image, const double rotation[3][4], const struct vw_camera *camera, bool alpha) {
    uint8_t *pixel = image->pixels;
    for (uint32_t y = 0; y < image->height_px; y++) {
        for (uint32_t x = 0; x < image->width_px; x++, pixel += 4) {
            double direction[3] = {(x + 0.5 - camera->centre_x_px) / camera->focal_x_px,
                                   -(y + 0.5 - camera->centre_y_px) / camera->focal_y_px, -1.0};
            for (int row = 0; row < 3; row++) {
                double world = 0.0;
                for (int column = 0; column < 3; column++) world += rotation[row][column] * direction[column];
                pixel[row] = to_byte(0.5 + 0.45 * sin(3.0 * world + row));
            }
            pixel[3] = alpha && y >= image->height_px / 2 ? 128 : 255;
        }
    }
}

static void set_view(struct vw_view *view, uint32_t index, uint32_t count,
                     const struct synthetic_scene_params *params) {
    double angle = 6.283185307179586 * index / count, height = 0.4 * sin(2.0 * angle),
           scale = params->world_scale != 0.0 ? params->world_scale : 1.0;
    // Looking at the origin from distance 3: z (back) points to the camera, x to the right, y up.
    double back[3] = {cos(angle), sin(angle), height}, right[3] = {-sin(angle), cos(angle), 0.0}, up[3];
    double length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
    for (int i = 0; i < 3; i++) back[i] /= length;
    for (int i = 0; i < 3; i++) up[i] = back[(i + 1) % 3] * right[(i + 2) % 3] - back[(i + 2) % 3] * right[(i + 1) % 3];
    for (int i = 0; i < 3; i++) {
        view->camera_to_world[i][0] = right[i];
        view->camera_to_world[i][1] = up[i];
        view->camera_to_world[i][2] = back[i];
        view->camera_to_world[i][3] = params->world_offset + scale * 3.0 * back[i];
    }
    view->name = vw_format_text("view_%03u", index);
    view->provider = vw_copy_text("");
    view->split = index < params->train_views ? VW_SPLIT_TRAIN : VW_SPLIT_VAL;
    view->weight = 1;
    view->camera = (struct vw_camera){.width_px = params->width_px,
                                      .height_px = params->height_px,
                                      .focal_x_px = 1.2 * params->width_px,
                                      .focal_y_px = 1.2 * params->width_px,
                                      .centre_x_px = 0.5 * params->width_px,
                                      .centre_y_px = 0.5 * params->height_px,
                                      .k1 = params->k1};
    view->image = (struct vw_image){.width_px = params->width_px,
                                    .height_px = params->height_px,
                                    .format = VW_PIXEL_UINT8,
                                    .has_alpha = params->alpha};
    view->image.pixels = vw_allocate((size_t)params->width_px * params->height_px, 4);
    paint(&view->image, view->camera_to_world, &view->camera, params->alpha);
    vw_sha256(view->image.pixels, 4 * (size_t)params->width_px * params->height_px, view->sha256);
}

struct vw_scene *synthetic_scene(const struct synthetic_scene_params *params) {
    struct vw_scene *scene = vw_allocate(1, sizeof *scene);
    double scale = params->world_scale != 0.0 ? params->world_scale : 1.0;
    scene->path = vw_copy_text("synthetic");
    scene->format = vw_copy_text("synthetic");
    scene->view_count = params->train_views + params->val_views;
    scene->split_count[VW_SPLIT_TRAIN] = params->train_views;
    scene->split_count[VW_SPLIT_VAL] = params->val_views;
    scene->views = vw_allocate(scene->view_count, sizeof *scene->views);
    for (uint32_t i = 0; i < scene->view_count; i++) set_view(&scene->views[i], i, scene->view_count, params);
    for (int i = 0; i < 3; i++) scene->box.centre_world[i] = params->world_offset;
    scene->box.half_extent_world = scale;
    scene->box_source = vw_copy_text("synthetic");
    for (int i = 0; i < 3; i++) scene->background[i] = params->alpha ? 1.0f : 0.0f;
    scene->has_alpha = params->alpha;
    vw_sha256(params, sizeof *params, scene->hash);
    ASSERT_OK(vw_scene_prepare_exposures(scene));
    return test_own_scene(scene);
}

struct vw_scene *test_scene_open(struct vw_scene_params params) {
    struct vw_scene *scene = NULL;
    if (!params.gpu) params.gpu = test_gpu();
    ASSERT_OK(vw_scene_open(&params, &scene));
    return test_own_scene(scene);
}

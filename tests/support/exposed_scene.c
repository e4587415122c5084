#include "support/exposed_scene.h"

#include "support/cmocka_test.h"

#include "base/memory.h"
#include "scene/builder.h"
#include "support/draws.h"
#include "support/synthetic_scene.h"

enum { PLACES = (EXPOSED_WIDTH_PX - 1) * (EXPOSED_HEIGHT_PX - 1) }; // without the last column and row
static const uint64_t SEED = 71;

double exposed_gain(uint32_t view, int channel) {
    static const double gains[EXPOSED_TRAINS] = {0.35, -0.3, 0, 0.1, -0.15};
    return gains[view < EXPOSED_TRAINS ? (view + 2 * (uint32_t)channel) % EXPOSED_TRAINS : 0];
}

double exposed_bias(uint32_t view, int channel) {
    static const double biases[EXPOSED_TRAINS] = {0.015, 0.01, -0.02, 0, -0.005};
    return biases[view < EXPOSED_TRAINS ? (3 * view + (uint32_t)channel) % EXPOSED_TRAINS : 0];
}

double exposed_colour(uint32_t point, int channel) { return 0.45 + 0.25 * test_draw(SEED, point, (uint32_t)channel); }

float *exposed_pixel(const struct vw_scene *scene, uint32_t view, uint32_t x_px, uint32_t y_px) {
    return (float *)scene->views[view].image.pixels + 4 * (y_px * EXPOSED_WIDTH_PX + x_px);
}

float *exposed_track_pixel(const struct vw_scene *scene, uint32_t track) {
    const struct vw_track *it = &scene->tracks[track];
    return exposed_pixel(scene, it->view, (uint32_t)it->x_px, (uint32_t)it->y_px);
}

static void clear(struct vw_image *image) {
    float *pixels = vw_allocate(4 * EXPOSED_PIXELS, sizeof *pixels);
    for (uint32_t i = 0; i < 4 * EXPOSED_PIXELS; i++) pixels[i] = i % 4 == 3 ? 1.0f : 0.5f;
    free(image->pixels);
    image->format = VW_PIXEL_FLOAT32;
    image->pixels = pixels;
}

static void show(struct vw_scene *scene, uint32_t point, uint32_t view, const struct exposed_scene_params *params) {
    uint32_t place = (7 * point + 31 * view) % PLACES, track = scene->track_count++,
             x_px = place % (EXPOSED_WIDTH_PX - 1), y_px = place / (EXPOSED_WIDTH_PX - 1);
    scene->tracks[track] = (struct vw_track){view, (float)x_px + 0.5f, (float)y_px + 0.5f};
    scene->points[point].track_count++;
    for (int c = 0; c < 3; c++) {
        double noise = test_normal(SEED, EXPOSED_VIEWS * point + view, 3 + (uint32_t)c),
               shown = (1 + params->gains * exposed_gain(view, c)) * exposed_colour(point, c) +
                       params->biases * exposed_bias(view, c);
        exposed_track_pixel(scene, track)[c] = (float)(shown + params->noise * noise);
    }
}

struct vw_scene *exposed_scene(struct exposed_scene_params params) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = EXPOSED_TRAINS, .val_views = 2, .width_px = EXPOSED_WIDTH_PX, .height_px = EXPOSED_HEIGHT_PX});
    scene->views[EXPOSED_VIEWS - 1].split = VW_SPLIT_TEST;
    scene->split_count[VW_SPLIT_VAL]--;
    scene->split_count[VW_SPLIT_TEST]++;
    scene->points = vw_allocate(EXPOSED_POINTS, sizeof *scene->points);
    scene->tracks = vw_allocate(EXPOSED_POINTS * EXPOSED_VIEWS, sizeof *scene->tracks);
    scene->point_count = EXPOSED_POINTS;
    for (uint32_t view = 0; view < EXPOSED_VIEWS; view++) clear(&scene->views[view].image);
    for (uint32_t p = 0; p < EXPOSED_POINTS; p++) {
        scene->points[p].first_track = scene->track_count;
        for (uint32_t view = 0; view < EXPOSED_VIEWS; view++) {
            uint32_t after = (view + EXPOSED_TRAINS - p % EXPOSED_TRAINS) % EXPOSED_TRAINS;
            if (!params.seen_by || view >= EXPOSED_TRAINS || after < params.seen_by) show(scene, p, view, &params);
        }
    }
    ASSERT_OK(vw_scene_prepare_exposures(scene));
    return scene;
}

void scene_forget_points(struct vw_scene *scene) {
    scene->point_count = scene->track_count = 0;
    ASSERT_OK(vw_scene_prepare_exposures(scene));
}

// A scene in memory whose photos show points of known colours, each with a gain and a bias of its own.
#ifndef VIEWWORTH_TESTS_SUPPORT_EXPOSED_SCENE_H
#define VIEWWORTH_TESTS_SUPPORT_EXPOSED_SCENE_H

#include "viewworth/scene.h"

// Views train, but for the last two: one validates, one tests.
enum { EXPOSED_TRAINS = 5, EXPOSED_VIEWS = EXPOSED_TRAINS + 2, EXPOSED_POINTS = 600 };
enum { EXPOSED_WIDTH_PX = 40, EXPOSED_HEIGHT_PX = 30, EXPOSED_PIXELS = EXPOSED_WIDTH_PX * EXPOSED_HEIGHT_PX };

struct exposed_scene_params {
    double gains, biases, noise; // factors of exposed_gain() and exposed_bias(); standard deviation of each pixel
    uint32_t seen_by;            // train views that see each point, its own and those that follow it; 0: all
};
// Makes a scene, owned by the test (cmocka_test.h). Every view that sees a point has a pixel for it alone, elsewhere
// than other views do; the last two see all points.
struct vw_scene *exposed_scene(struct exposed_scene_params params);

// Returns the value of a view. The median over train views is 0, in every channel; gains are up to 0.35, biases up to
// 0.02. Views that do not train have those of the first.
double exposed_gain(uint32_t view, int channel);
double exposed_bias(uint32_t view, int channel);
double exposed_colour(uint32_t point, int channel); // 0.2 to 0.7

// Returns the four floats of a pixel.
float *exposed_pixel(const struct vw_scene *scene, uint32_t view, uint32_t x_px, uint32_t y_px);
// Returns those of the pixel that a track is at.
float *exposed_track_pixel(const struct vw_scene *scene, uint32_t track);

// Takes the points of any scene away, and what they tell of exposures.
void scene_forget_points(struct vw_scene *scene);

#endif

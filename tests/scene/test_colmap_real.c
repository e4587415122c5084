// The real scenes, read as COLMAP and as transforms.json: the same rays, and points that reproject with the errors
// their README.txt state.
#include "support/cmocka_test.h"

#include "scene/formats/colmap.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static const double SAME_RAY_PX = 1e-4; // the bound

static struct vw_scene *open_as(const char *path, const char *format) {
    return tiny_scene_open(SCENE_PARAMS(.path = path, .format = format, .headers_only = true));
}

static const struct vw_view *find_view(const struct vw_scene *scene, const char *name) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (!strcmp(scene->views[v].name, name)) return &scene->views[v];
    fail_msg("no view %s", name);
    return NULL;
}

// Finds where view `b` sees what view `a` sees at a pixel, at a depth of `depth_world`; infinitely far away when that
// is 0.
static double ray_difference_px(const struct vw_view *a, const struct vw_view *b, double x_px, double y_px,
                                double depth_world) {
    double direction[3], offset[3], seen[3] = {0}, other_x_px, other_y_px;
    assert_true(vw_camera_unproject(&a->camera, x_px, y_px, direction));
    for (int i = 0; i < 3; i++) {
        offset[i] = depth_world > 0 ? (a->camera_to_world[i][3] - b->camera_to_world[i][3]) / depth_world : 0;
        for (int j = 0; j < 3; j++) offset[i] += a->camera_to_world[i][j] * direction[j];
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) seen[i] += b->camera_to_world[j][i] * offset[j];
    assert_true(vw_camera_project(&b->camera, seen, &other_x_px, &other_y_px));
    return hypot(other_x_px - x_px, other_y_px - y_px);
}

static bool same_place(const struct vw_view *a, const struct vw_view *b) {
    double square = 0;
    for (int i = 0; i < 3; i++) square += pow(a->camera_to_world[i][3] - b->camera_to_world[i][3], 2);
    return sqrt(square) < 2e-7;
}

// Checks that all views have the same directions in both formats. Points at the nearest depth are compared where both
// formats put the camera at the same place: the matrices of fox are rotations only to 1e-6, and its COLMAP model, made
// from them, has cameras up to 3e-6 world units away.
static void check_same_rays(const char *name, uint32_t same_places) {
    const char *path = real_scene_path(name);
    if (!path) skip();
    struct vw_scene *colmap = open_as(path, "colmap"), *transforms = open_as(path, "transforms");
    assert_int_equal(colmap->view_count, transforms->view_count);
    double worst_px = 0;
    uint32_t same = 0;
    for (uint32_t v = 0; v < transforms->view_count; v++) {
        const struct vw_view *a = &transforms->views[v], *b = find_view(colmap, a->name);
        same += same_place(a, b);
        for (int corner = 0; corner < 9; corner++) {
            double x_px = corner % 3 * 0.5 * a->camera.width_px, y_px = corner / 3 * 0.5 * a->camera.height_px;
            worst_px = fmax(worst_px, ray_difference_px(a, b, x_px, y_px, 0));
            if (same_place(a, b)) worst_px = fmax(worst_px, ray_difference_px(a, b, x_px, y_px, b->near_world));
        }
    }
    printf("%s: rays of the two formats differ by at most %.2g px; %u of %u cameras at the same place\n", name,
           worst_px, same, transforms->view_count);
    assert_true(worst_px < SAME_RAY_PX);
    assert_true(same >= same_places);
}

TEST(rays_of_fox_agree) { (void)state, check_same_rays("fox", 20); }
TEST(rays_of_sacre_coeur_agree) { (void)state, check_same_rays("sacre_coeur", 11); }
TEST(rays_of_statue_of_liberty_agree) { (void)state, check_same_rays("statue_of_liberty", 135); }

// Returns the mean distance between where a view sees a point and where its camera puts it, over all tracks.
static double mean_error_px(const struct vw_scene *scene) {
    double sum = 0;
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            const struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
            const struct vw_view *view = &scene->views[track->view];
            double seen[3] = {0}, x_px, y_px;
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    seen[i] += view->camera_to_world[j][i] *
                               (scene->points[p].position_world[j] - view->camera_to_world[j][3]);
            assert_true(vw_camera_project(&view->camera, seen, &x_px, &y_px));
            sum += hypot(x_px - track->x_px, y_px - track->y_px);
        }
    return sum / scene->track_count;
}

// Checks the mean reprojection error against the stated one. fox: 0.746 px at twice this size, for 5841 points; the
// file has the 4000 with the longest tracks, whose error may differ by some percent. sacre_coeur: computed on the same
// files, so it agrees to the last digit stated. statue_of_liberty: stated with two digits. A camera convention that is
// off by half a pixel anywhere would show in all three.
static void check_errors(const char *name, uint32_t points, double stated_px, double tolerance_px) {
    const char *path = real_scene_path(name);
    if (!path) skip();
    struct vw_scene *scene = open_as(path, "colmap");
    double error_px = mean_error_px(scene);
    printf("%s: %u points, %u observations, mean reprojection error %.4f px (stated: %.3f)\n", name, scene->point_count,
           scene->track_count, error_px, stated_px);
    assert_int_equal(scene->point_count, points);
    assert_near(error_px, stated_px, tolerance_px);
}

TEST(reprojection_errors_of_fox_are_small) { (void)state, check_errors("fox", 4000, 0.373, 0.02); }
TEST(reprojection_errors_of_sacre_coeur_are_small) { (void)state, check_errors("sacre_coeur", 1645, 0.173, 0.0005); }
TEST(reprojection_errors_of_statue_of_liberty_are_small) {
    (void)state, check_errors("statue_of_liberty", 9371, 0.37, 0.005);
}

// Camera paths of a recipe: each becomes views with true poses, names and splits.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "scene/builder.h"
#include "scene/synthetic/recipe.h"

static const double COORDINATE_MAX = 1e9;
enum { STRIDE = 8, TEST_PHASE = 4 }; // view i is val when i % 8 == 0 and test when i % 8 == 4

struct path_reader {
    const struct vw_recipe *recipe;
    struct vw_scene *scene;
    size_t view_capacity;
};

struct orbit {
    double centre[3], look_at[3];
    double radius, start_deg, turns;
    double elevation_deg[2]; // for the first and the last view
    int64_t count;
    struct vw_camera camera;
    const char *provider;
    int split; // -1: by the view's index
};

// Computes camera axes (OpenGL) from a position and a target, without roll against the world's z axis. False when it
// looks straight up or down.
static bool look_at(const double position[3], const double target[3], double pose[3][4]) {
    double back[3], horizontal, length;
    for (int i = 0; i < 3; i++) back[i] = position[i] - target[i];
    horizontal = hypot(back[0], back[1]);
    length = hypot(horizontal, back[2]);
    if (horizontal < 1e-6 * length || length == 0) return false;
    for (int i = 0; i < 3; i++) back[i] /= length;
    horizontal /= length;
    const double right[3] = {-back[1] / horizontal, back[0] / horizontal, 0};
    const double up[3] = {back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
                          back[0] * right[1] - back[1] * right[0]};
    for (int i = 0; i < 3; i++) memcpy(pose[i], (double[4]){right[i], up[i], back[i], position[i]}, sizeof pose[i]);
    return true;
}

static bool orbit_pose(const struct orbit *orbit, int64_t index, double pose[3][4]) {
    double along = orbit->count > 1 ? (double)index / (double)(orbit->count - 1) : 0;
    double azimuth = (orbit->start_deg + 360 * orbit->turns * (double)index / (double)orbit->count) * M_PI / 180;
    double elevation =
        (orbit->elevation_deg[0] + along * (orbit->elevation_deg[1] - orbit->elevation_deg[0])) * M_PI / 180;
    const double direction[3] = {cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth), sin(elevation)};
    double position[3];
    for (int i = 0; i < 3; i++) position[i] = orbit->centre[i] + orbit->radius * direction[i];
    return look_at(position, orbit->look_at, pose);
}

static void read_distortion(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_camera *camera = context;
    vw_json_check_keys(reader, object, "k1 k2 p1 p2");
    vw_json_number(reader, object, "k1", -2, 2, &camera->k1);
    vw_json_number(reader, object, "k2", -2, 2, &camera->k2);
    vw_json_number(reader, object, "p1", -1, 1, &camera->p1);
    vw_json_number(reader, object, "p2", -1, 1, &camera->p2);
    for (int corner = 0; corner < 4 && !reader->status; corner++) {
        double direction[3];
        if (!vw_camera_unproject(camera, corner & 1 ? camera->width_px : 0, corner & 2 ? camera->height_px : 0,
                                 direction))
            vw_json_refuse(reader, "", "the photo's corners lie beyond the fold of this distortion; make it weaker");
    }
}

static void read_camera(struct vw_json_reader *reader, const json_t *object, const struct vw_recipe *recipe,
                        struct vw_camera *camera) {
    double field_of_view_deg = NAN;
    vw_json_number(reader, object, "field_of_view_deg", 1, 170, &field_of_view_deg);
    double focal_px = recipe->width_px / 2.0 / tan(field_of_view_deg * M_PI / 360);
    *camera = (struct vw_camera){.width_px = recipe->width_px,
                                 .height_px = recipe->height_px,
                                 .focal_x_px = focal_px,
                                 .focal_y_px = focal_px,
                                 .centre_x_px = recipe->width_px / 2.0,
                                 .centre_y_px = recipe->height_px / 2.0};
    vw_json_member(reader, object, "distortion", false, read_distortion, camera);
}

static void read_orbit(struct vw_json_reader *reader, const json_t *object, const struct vw_recipe *recipe,
                       struct orbit *orbit) {
    int path = -1;
    vw_json_check_keys(
        reader, object,
        "path centre radius count field_of_view_deg elevation_deg start_deg turns look_at distortion provider split");
    vw_json_word(reader, object, "path", "orbit", &path);
    vw_json_numbers(reader, object, "centre", -COORDINATE_MAX, COORDINATE_MAX, orbit->centre, 3);
    memcpy(orbit->look_at, orbit->centre, sizeof orbit->look_at);
    vw_json_numbers(reader, object, "look_at", -COORDINATE_MAX, COORDINATE_MAX, orbit->look_at, 3);
    vw_json_number(reader, object, "radius", 1e-6, COORDINATE_MAX, &orbit->radius);
    vw_json_integer(reader, object, "count", 1, VW_RECIPE_VIEWS_MAX, &orbit->count);
    vw_json_numbers(reader, object, "elevation_deg", -89, 89, orbit->elevation_deg, 2);
    vw_json_number(reader, object, "start_deg", -360, 360, &orbit->start_deg);
    vw_json_number(reader, object, "turns", -100, 100, &orbit->turns);
    vw_json_text(reader, object, "provider", &orbit->provider);
    if (json_object_get(object, "split"))
        vw_json_word(reader, object, "split", "train val test excluded", &orbit->split);
    read_camera(reader, object, recipe, &orbit->camera);
}

static enum vw_split split_by_index(uint32_t index) {
    if (index % STRIDE == 0) return VW_SPLIT_VAL;
    return index % STRIDE == TEST_PHASE ? VW_SPLIT_TEST : VW_SPLIT_TRAIN;
}

static enum vw_status add_view(const struct orbit *orbit, const double pose[3][4], struct path_reader *state) {
    struct vw_scene *scene = state->scene;
    if (vw_grow((void **)&scene->views, &state->view_capacity, scene->view_count + 1, sizeof *scene->views))
        return VW_ERROR_MEMORY;
    uint32_t index = scene->view_count++;
    struct vw_view *view = &scene->views[index];
    view->camera = orbit->camera;
    memcpy(view->camera_to_world, pose, sizeof view->camera_to_world);
    view->image.width_px = orbit->camera.width_px;
    view->image.height_px = orbit->camera.height_px;
    view->split = orbit->split < 0 ? split_by_index(index) : (enum vw_split)orbit->split;
    view->name = vw_format_text("view_%03u", index);
    enum vw_status status = vw_provider_name_take(orbit->provider, &view->provider);
    if (status == VW_ERROR_INPUT) status = vw_fail_context(status, "%s: cameras", state->scene->path);
    return view->name || status ? status : VW_ERROR_MEMORY;
}

static void read_path(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct path_reader *state = context;
    struct orbit orbit = {
        .centre = {NAN, NAN, NAN}, .radius = NAN, .turns = 1, .elevation_deg = {30, 30}, .provider = "", .split = -1};
    read_orbit(reader, object, state->recipe, &orbit);
    if (state->scene->view_count + orbit.count > VW_RECIPE_VIEWS_MAX)
        vw_json_refuse(reader, "count", "makes more than %d views; use fewer", VW_RECIPE_VIEWS_MAX);
    for (int64_t i = 0; i < orbit.count && !reader->status; i++) {
        double pose[3][4];
        if (orbit_pose(&orbit, i, pose)) reader->status = add_view(&orbit, pose, state);
        else vw_json_refuse(reader, "look_at", "camera %lld looks straight up or down; move it", (long long)i);
    }
}

void vw_recipe_read_cameras(struct vw_json_reader *reader, const json_t *root, const struct vw_recipe *recipe,
                            struct vw_scene *scene) {
    struct path_reader state = {.recipe = recipe, .scene = scene};
    vw_json_each(reader, root, "cameras", VW_RECIPE_VIEWS_MAX, read_path, &state);
    bool validates = false;
    for (uint32_t v = 0; v < scene->view_count; v++) validates |= scene->views[v].split == VW_SPLIT_VAL;
    if (!validates)
        vw_json_refuse(reader, "cameras", "there is no validation view; add cameras, or a path with the split val");
}

// ---- Defects -------------------------------------------------------------------------------------------------------

// Decides which views are corrupted and how: the ground truth by which scores are evaluated.
const char *const vw_recipe_ground_truths[] = {"clean",    "noise",      "blur",       "occluder",
                                               "exposure", "wrong_pose", "striped_box"};

static const struct {
    double least, most;
} strengths[] = {
    // by enum vw_recipe_defect_kind
    {0, 0}, {1e-3, 1}, {1e-2, 64}, {1e-3, 0.95}, {1e-2, 100}, {1e-3, 180}, {1e-2, 1},
};

struct defect_reader {
    struct vw_recipe *recipe;
    const struct vw_scene *scene;
    uint32_t index; // index of the defect being read
};

static bool is_clean_train(const struct defect_reader *state, uint32_t view) {
    return state->scene->views[view].split == VW_SPLIT_TRAIN && !state->recipe->defects[view].kind;
}

static void corrupt_listed(struct vw_json_reader *reader, const json_t *views, const struct vw_recipe_defect *defect,
                           struct defect_reader *state) {
    if (!json_is_array(views)) vw_json_refuse(reader, "views", "expected an array of view indices");
    for (size_t i = 0; i < json_array_size(views) && !reader->status; i++) {
        const json_t *item = json_array_get(views, i);
        json_int_t view = json_is_integer(item) ? json_integer_value(item) : -1;
        if (view < 0 || view >= state->scene->view_count) {
            vw_json_refuse(reader, "views", "item %zu is not a view; give indices from 0 to %u", i,
                           state->scene->view_count - 1);
        } else if (!is_clean_train(state, (uint32_t)view)) {
            const char *what = state->recipe->defects[view].kind ? "corrupted already"
                                                                 : vw_split_name(state->scene->views[view].split);
            vw_json_refuse(reader, "views", "view %lld is %s; only clean train views can be corrupted", (long long)view,
                           what);
        } else {
            state->recipe->defects[view] = *defect;
        }
    }
}

static void corrupt_every(struct vw_json_reader *reader, int64_t every, const struct vw_recipe_defect *defect,
                          struct defect_reader *state) {
    int64_t clean = 0;
    for (uint32_t v = 0; v < state->scene->view_count && !reader->status; v++)
        if (is_clean_train(state, v) && ++clean % every == 0) state->recipe->defects[v] = *defect;
}

// Draws the clean train view with the smallest random number; -1: none.
static int64_t draw_view(const struct defect_reader *state) {
    int64_t drawn = -1;
    uint32_t smallest = UINT32_MAX;
    for (uint32_t v = 0; v < state->scene->view_count; v++) {
        uint32_t words[4];
        vw_random_words(state->recipe->seed, VW_RANDOM_RECIPE, state->index, v, VW_DRAW_CHOICE, words);
        if (!is_clean_train(state, v) || (drawn >= 0 && words[0] >= smallest)) continue;
        drawn = v;
        smallest = words[0];
    }
    return drawn;
}

static void corrupt_share(struct vw_json_reader *reader, double share, const struct vw_recipe_defect *defect,
                          struct defect_reader *state) {
    uint32_t train = 0;
    for (uint32_t v = 0; v < state->scene->view_count; v++) train += state->scene->views[v].split == VW_SPLIT_TRAIN;
    for (long left = lround(share * train); left > 0 && !reader->status; left--) {
        int64_t view = draw_view(state);
        if (view < 0) vw_json_refuse(reader, "share", "no clean train view is left to corrupt; lower the shares");
        else state->recipe->defects[view] = *defect;
    }
}

static void read_targets(struct vw_json_reader *reader, const json_t *object, const struct vw_recipe_defect *defect,
                         struct defect_reader *state) {
    const json_t *views = json_object_get(object, "views");
    bool by_every = json_object_get(object, "every"), by_share = json_object_get(object, "share");
    int64_t every = 1;
    double share = 0;
    if ((views != NULL) + by_every + by_share != 1)
        vw_json_refuse(reader, "", "give exactly one of views, every and share");
    vw_json_integer(reader, object, "every", 1, VW_RECIPE_VIEWS_MAX, &every);
    vw_json_number(reader, object, "share", 0, 1, &share);
    if (reader->status) return;
    if (views) corrupt_listed(reader, views, defect, state);
    else if (by_every) corrupt_every(reader, every, defect, state);
    else corrupt_share(reader, share, defect, state);
}

static void read_defect(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct defect_reader *state = context;
    struct vw_recipe_defect defect = {.strength = NAN};
    int kind = -1;
    vw_json_check_keys(reader, object, "kind strength bias views every share");
    vw_json_word(reader, object, "kind", "noise blur occluder exposure wrong_pose striped_box", &kind);
    if (reader->status) return;
    defect.kind = (enum vw_recipe_defect_kind)(kind + 1);
    if (defect.kind != VW_DEFECT_EXPOSURE) vw_json_check_keys(reader, object, "kind strength views every share");
    vw_json_number(reader, object, "strength", strengths[defect.kind].least, strengths[defect.kind].most,
                   &defect.strength);
    vw_json_number(reader, object, "bias", -1, 1, &defect.bias);
    if (defect.kind == VW_DEFECT_BLUR) defect.strength /= state->recipe->downscale;
    read_targets(reader, object, &defect, state);
    state->index++;
}

void vw_recipe_read_defects(struct vw_json_reader *reader, const json_t *root, struct vw_recipe *recipe,
                            struct vw_scene *scene) {
    if (reader->status) return;
    recipe->defects = vw_allocate(scene->view_count, sizeof *recipe->defects);
    if (!recipe->defects) {
        reader->status = VW_ERROR_MEMORY;
        return;
    }
    struct defect_reader state = {.recipe = recipe, .scene = scene};
    if (json_object_get(root, "defects"))
        vw_json_each(reader, root, "defects", VW_RECIPE_DEFECTS_MAX, read_defect, &state);
    for (uint32_t v = 0; v < scene->view_count && !reader->status; v++) {
        scene->views[v].ground_truth = vw_copy_text(vw_recipe_ground_truths[recipe->defects[v].kind]);
        if (!scene->views[v].ground_truth) reader->status = VW_ERROR_MEMORY;
    }
}

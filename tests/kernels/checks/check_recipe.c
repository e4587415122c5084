// trace_recipe against the reference, on random scenes of every shape and texture.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

static const double COLOUR_TOLERANCE =
    1e-3; // noise changes by some 10 per box edge and cell, places are good to 1e-6 of what is in view
static const double DEPTH_TOLERANCE = 1e-4; // box edges: where a ray grazes a sphere, the root of a float's rounding
// At rims, and at the borders of shadows and texture cells, a pixel may be called either way: then the reference agrees
// a little beside it.
static const double BESIDE_PX = 0.01;
enum { SIDE_PX = 48, PIXELS = SIDE_PX * SIDE_PX, SHAPES = 8, BESIDE_MOST = PIXELS / 20 };

static float unit(struct test_random *random) { return 0.5f + 0.5f * test_random_next(random); }

// Draws a shape with sizes of the kind, or with colours of it where a size can not be.
static struct vw_recipe_shape draw_shape(enum input_kind kind, uint32_t index, struct test_random *random) {
    float size = 0.1f + 0.1f * unit(random), angle = 3.0f * test_random_next(random);
    if (kind == INPUT_LARGE) size = 3.0f + unit(random);
    if (kind == INPUT_TINY) size = 0.02f * unit(random);
    struct vw_recipe_shape shape = {
        .centre_radius = {unit(random), unit(random), unit(random), size},
        .extent = {size, 0.5f * size, 0.7f * size, 0.0f},
        .turn = {cosf(angle), sinf(angle), 0.0f, 0.0f},
        .colour_a = {unit(random), unit(random), unit(random), 0.05f + 0.1f * unit(random)},
        .colour_b = {unit(random), unit(random), unit(random), 0.0f},
        .stripe_axis = {0.6f, 0.0f, 0.8f, 0.0f},
        .kind = index % 4,
        .texture = index / 2 % 4,
    };
    if (shape.kind == SHAPE_PLANE) shape.extent = (vw_float4){0.48f, -0.6f, 0.64f, 0.0f};
    if (kind != INPUT_ZERO && kind != INPUT_NEGATIVE_ZERO && kind != INPUT_DENORMAL) return shape;
    shape.colour_a.x = fabsf(input_draw(kind, random));
    shape.colour_b.y = 0.0f * input_draw(kind, random);
    return shape;
}

struct tracing {
    struct vw_buffer *cameras, *shapes, *pixels;
    struct vw_pass *pass;
    struct vw_recipe_shape shape_data[SHAPES];
    struct reference_recipe recipe;
};

static struct vw_push_recipe make_push(enum input_kind kind, uint32_t case_number) {
    struct vw_push_recipe push = {
        .first_pixel = 0,
        .pixel_count = PIXELS,
        .width_px = SIDE_PX,
        .samples_side = 1,
        .shape_count = kind == INPUT_ZERO ? 0 : SHAPES,
        .background = case_number % 3,
        .seed = case_number,
        .ambient = 0.4f,
        .sun = {0.48f, 0.36f, 0.8f, 0.7f},
        .background_colour = {0.1f, 0.2f, 0.3f, 1.0f},
    };
    if (kind == INPUT_SATURATING) push.sun.w = 0x1p30f;
    return push;
}

// Makes a camera whose reference is the camera itself: recipes stay near their boxes.
static struct vw_gpu_camera make_camera(const struct vw_view *view, const struct vw_box *box) {
    float axes[3][3], position[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) axes[j][i] = (float)view->camera_to_world[i][j];
        position[i] =
            (float)((view->camera_to_world[i][3] - box->centre_world[i]) / (2.0 * box->half_extent_world) + 0.5);
    }
    const struct vw_camera *camera = &view->camera;
    return (struct vw_gpu_camera){.right = {axes[0][0], axes[0][1], axes[0][2], (float)camera->focal_x_px},
                                  .up = {axes[1][0], axes[1][1], axes[1][2], (float)camera->focal_y_px},
                                  .back = {axes[2][0], axes[2][1], axes[2][2], (float)camera->centre_x_px},
                                  .reference = {position[0], position[1], position[2], 0.0f},
                                  .distortion = {(float)camera->k1, 0.0f, 0.0f, 0.0f},
                                  .more = {.x = (float)camera->centre_y_px}};
}

static void open_tracing(struct step_bench *bench, enum input_kind kind, const struct vw_view *view,
                         struct tracing *t) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct vw_gpu_camera camera = make_camera(view, &bench->scene->box);
    struct test_random random = {.seed = bench->config.seed};
    for (uint32_t i = 0; i < SHAPES; i++) t->shape_data[i] = draw_shape(kind, i, &random);
    t->recipe = (struct reference_recipe){t->shape_data, make_push(kind, (uint32_t)bench->config.seed)};
    t->cameras = test_buffer(bench->gpu, "recipe cameras", sizeof camera);
    t->shapes = test_buffer(bench->gpu, "recipe shapes", sizeof t->shape_data);
    t->pixels = test_buffer(bench->gpu, "recipe pixels", PIXELS * sizeof(struct vw_recipe_pixel));
    test_write(t->cameras, &camera);
    test_write(t->shapes, t->shape_data);
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_CAMERAS, .buffer = t->cameras},
                                          {.slot = VW_SLOT_RECIPE_SHAPES, .buffer = t->shapes},
                                          {.slot = VW_SLOT_RECIPE_PIXELS, .buffer = t->pixels}};
    t->pass = test_pass(bench->gpu, (struct vw_pass_params){.shader = &vw_shader_trace_recipe,
                                                            .specialization = (const uint32_t *)s,
                                                            .specialization_count = VW_SPECIALIZATION_COUNT,
                                                            .bindings = bindings,
                                                            .binding_count = VW_ARRAY_COUNT(bindings)});
}

// Returns how far a pixel is from the reference's at a place in the photo, in tolerances.
static double difference(const struct step_bench *bench, const struct tracing *t, const struct vw_view *view,
                         double x_px, double y_px, const struct vw_recipe_pixel *pixel) {
    const double device[4] = {pixel->rgba.x, pixel->rgba.y, pixel->rgba.z, pixel->rgba.w};
    double origin[3], direction[3], rgba[4], most = 0.0;
    assert_true(reference_camera_line(view, &bench->scene->box, x_px, y_px, origin, direction));
    double depth = reference_recipe_trace(&t->recipe, origin, direction, rgba);
    for (int i = 0; i < 4; i++) most = fmax(most, fabs(device[i] - rgba[i]) / COLOUR_TOLERANCE);
    return fmax(most, fabs(pixel->depth - depth) / (DEPTH_TOLERANCE * fmax(depth, 1.0)));
}

static bool agrees_beside(const struct step_bench *bench, const struct tracing *t, const struct vw_view *view,
                          double x_px, double y_px, const struct vw_recipe_pixel *pixel) {
    for (int i = 0; i < 9; i++)
        if (difference(bench, t, view, x_px + BESIDE_PX * (i % 3 - 1), y_px + BESIDE_PX * (i / 3 - 1), pixel) <= 1.0)
            return true;
    return false;
}

static void check_pixels(const struct step_bench *bench, const struct tracing *t, const struct vw_view *view,
                         const struct vw_recipe_pixel *pixels) {
    uint32_t beside = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        double x_px = i % SIDE_PX + 0.5, y_px = i / SIDE_PX + 0.5,
               off = difference(bench, t, view, x_px, y_px, &pixels[i]);
        if (off <= 1.0) continue;
        if (!agrees_beside(bench, t, view, x_px, y_px, &pixels[i]))
            fail_msg("%s: pixel (%g, %g) is (%g %g %g %g), depth %g: off by %g tolerances", bench->where, x_px, y_px,
                     pixels[i].rgba.x, pixels[i].rgba.y, pixels[i].rgba.z, pixels[i].rgba.w, pixels[i].depth, off);
        beside++;
    }
    if (beside > BESIDE_MOST) fail_msg("%s: %u of %d pixels stand at borders", bench->where, beside, PIXELS);
}

void check_trace_recipe(struct step_bench *bench, enum input_kind kind) {
    struct vw_view view = bench->scene->views[0];
    struct tracing tracing = {0};
    rays_look(&view, &bench->scene->box, (const double[3]){1.9, 1.6, 1.4}, (const double[3]){0.5, 0.5, 0.5});
    view.camera.focal_x_px = 1.2 * SIDE_PX;
    view.camera.focal_y_px = 1.3 * SIDE_PX;
    view.camera.centre_x_px = view.camera.centre_y_px = SIDE_PX / 2.0;
    open_tracing(bench, kind, &view, &tracing);
    step_bench_dispatch(bench, tracing.pass, &tracing.recipe.push, sizeof tracing.recipe.push, PIXELS);
    struct vw_recipe_pixel *pixels = test_read(tracing.pixels);
    check_pixels(bench, &tracing, &view, pixels);
}

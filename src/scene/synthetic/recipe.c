#include "scene/synthetic/recipe.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "image/pixel.h"

// ---- Image, box and light ------------------------------------------------------------------------------------------

// The world of a recipe: image size, box, light and shapes. Shapes become what the shader reads, in box coordinates, at
// once.
static const double COORDINATE_MAX = 1e9; // world units: double keeps a tenth of a micrometre there
static const double LENGTH_MIN = 1e-6;
static const double UNLIMITED_RADIUS_EDGES = 1e15;

static bool normalize(double v[3]) {
    double length = hypot(hypot(v[0], v[1]), v[2]);
    if (!(length > 0)) return false;
    for (int i = 0; i < 3; i++) v[i] /= length;
    return true;
}

static void read_direction(struct vw_json_reader *reader, const json_t *object, const char *key, double direction[3]) {
    vw_json_numbers(reader, object, key, -COORDINATE_MAX, COORDINATE_MAX, direction, 3);
    if (!reader->status && !normalize(direction)) vw_json_refuse(reader, key, "has no length; give a direction");
}

static void read_length(struct vw_json_reader *reader, const json_t *object, const char *key, double *length) {
    vw_json_number(reader, object, key, LENGTH_MIN, COORDINATE_MAX, length);
}

static void read_image(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_recipe *recipe = context;
    int64_t width_px = 0, height_px = 0, samples = 4;
    vw_json_check_keys(reader, object, "width_px height_px samples_per_pixel");
    vw_json_integer(reader, object, "width_px", 1, VW_RECIPE_SIDE_MAX_PX, &width_px);
    vw_json_integer(reader, object, "height_px", 1, VW_RECIPE_SIDE_MAX_PX, &height_px);
    vw_json_integer(reader, object, "samples_per_pixel", 1, 64, &samples);
    int64_t side = lround(sqrt((double)samples));
    if (side * side != samples)
        vw_json_refuse(reader, "samples_per_pixel", "must be a square; use 1, 4, 9, 16, 25, 36, 49 or 64");
    recipe->width_px = vw_downscaled_px((uint32_t)width_px, recipe->downscale);
    recipe->height_px = vw_downscaled_px((uint32_t)height_px, recipe->downscale);
    recipe->samples_side = (uint32_t)side;
}

static void read_box(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_box *box = context;
    double centre[3] = {NAN, NAN, NAN}, half_extent = NAN;
    vw_json_check_keys(reader, object, "centre half_extent");
    vw_json_numbers(reader, object, "centre", -COORDINATE_MAX, COORDINATE_MAX, centre, 3);
    read_length(reader, object, "half_extent", &half_extent);
    memcpy(box->centre_world, centre, sizeof centre);
    box->half_extent_world = half_extent;
}

static void read_sun(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_recipe *recipe = context;
    double direction[3] = {NAN, NAN, NAN}, intensity = NAN, ambient = 0;
    vw_json_check_keys(reader, object, "direction intensity ambient spread_deg");
    read_direction(reader, object, "direction", direction);
    vw_json_number(reader, object, "intensity", 0, 100, &intensity);
    vw_json_number(reader, object, "ambient", 0, 100, &ambient);
    memcpy(recipe->sun_direction, direction, sizeof direction);
    vw_json_number(reader, object, "spread_deg", 0, 180, &recipe->sun_spread_deg);
    recipe->sun_intensity = intensity;
    recipe->ambient = ambient;
}

static void read_transients(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_recipe *recipe = context;
    vw_json_check_keys(reader, object, "share size");
    recipe->transient_share = NAN;
    recipe->transient_size = 0.1;
    vw_json_number(reader, object, "share", 0, 1, &recipe->transient_share);
    vw_json_number(reader, object, "size", 1e-3, 0.7, &recipe->transient_size);
}

static void read_background(struct vw_json_reader *reader, const json_t *root, struct vw_recipe *recipe) {
    double colour[3] = {0};
    int word = 0;
    if (json_is_string(json_object_get(root, "background"))) {
        vw_json_word(reader, root, "background", "sky transparent", &word);
        recipe->background = word ? BACKGROUND_TRANSPARENT : BACKGROUND_SKY;
        return;
    }
    vw_json_numbers(reader, root, "background", 0, 1, colour, 3);
    recipe->background = BACKGROUND_COLOUR;
    for (int c = 0; c < 3; c++) recipe->background_colour[c] = (float)colour[c];
}

// ---- Shapes --------------------------------------------------------------------------------------------------------

struct shape_reader {
    struct vw_recipe *recipe;
    const struct vw_box *box;
    double edge_world;
    struct vw_recipe_shape *shape;
};

static vw_float4 to_float4(const double v[3], double w) {
    return (vw_float4){(float)v[0], (float)v[1], (float)v[2], (float)w};
}

static void read_colour(struct vw_json_reader *reader, const json_t *object, const char *key, double colour[3]) {
    vw_json_numbers(reader, object, key, 0, 1, colour, 3);
}

static void read_texture(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct shape_reader *state = context;
    double colour[3] = {NAN, NAN, NAN}, second_colour[3] = {NAN, NAN, NAN}, cell = NAN, axis[3] = {0, 0, 1};
    int kind = -1;
    vw_json_word(reader, object, "kind", "plain checker stripes noise", &kind);
    read_colour(reader, object, "colour", colour);
    if (kind == TEXTURE_PLAIN) {
        vw_json_check_keys(reader, object, "kind colour");
        memcpy(second_colour, colour, sizeof colour);
        cell = state->edge_world;
    } else {
        bool striped = kind == TEXTURE_STRIPES;
        vw_json_check_keys(reader, object,
                           striped ? "kind colour second_colour cell axis" : "kind colour second_colour cell");
        read_colour(reader, object, "second_colour", second_colour);
        read_length(reader, object, "cell", &cell);
        read_direction(reader, object, "axis", axis);
    }
    state->shape->texture = (uint32_t)kind;
    state->shape->colour_a = to_float4(colour, cell / state->edge_world);
    state->shape->colour_b = to_float4(second_colour, 0);
    state->shape->stripe_axis = to_float4(axis, 0);
}

// Reads the lengths of a shape and turns them into box edges.
static void read_size(struct vw_json_reader *reader, const json_t *object, int kind, struct shape_reader *state) {
    double extent[3] = {NAN, NAN, NAN}, radius = NAN, height = NAN, turn_deg = 0, edge = state->edge_world;
    if (kind == SHAPE_SPHERE) {
        vw_json_check_keys(reader, object, "kind centre texture radius");
        read_length(reader, object, "radius", &radius);
    } else if (kind == SHAPE_BOX) {
        vw_json_check_keys(reader, object, "kind centre texture half_extent turn_deg");
        vw_json_numbers(reader, object, "half_extent", LENGTH_MIN, COORDINATE_MAX, extent, 3);
        vw_json_number(reader, object, "turn_deg", -360, 360, &turn_deg);
        for (int i = 0; i < 3; i++) extent[i] /= edge;
    } else if (kind == SHAPE_CYLINDER) {
        vw_json_check_keys(reader, object, "kind centre texture radius height");
        read_length(reader, object, "radius", &radius);
        read_length(reader, object, "height", &height);
        extent[2] = height / 2 / edge;
    } else {
        vw_json_check_keys(reader, object, "kind centre texture normal radius");
        memcpy(extent, (double[]){0, 0, 1}, sizeof extent);
        read_direction(reader, object, "normal", extent);
        if (json_object_get(object, "radius")) read_length(reader, object, "radius", &radius);
        else radius = UNLIMITED_RADIUS_EDGES * edge;
    }
    state->shape->centre_radius.w = (float)(radius / edge);
    state->shape->extent = to_float4(extent, 0);
    state->shape->turn = (vw_float4){(float)cos(turn_deg * M_PI / 180), (float)sin(turn_deg * M_PI / 180), 0, 0};
}

static void read_exposure(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct vw_recipe *recipe = context;
    vw_json_check_keys(reader, object, "gain tint bias");
    vw_json_number(reader, object, "gain", 0, 2, &recipe->gain_spread);
    vw_json_number(reader, object, "tint", 0, 2, &recipe->tint_spread);
    vw_json_number(reader, object, "bias", 0, 1, &recipe->bias_spread);
}

static void read_shape(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct shape_reader *state = context;
    struct vw_recipe_shape *shape = state->shape = &state->recipe->shapes[state->recipe->shape_count];
    double centre[3] = {NAN, NAN, NAN};
    int kind = -1;
    vw_json_word(reader, object, "kind", "sphere box plane cylinder", &kind);
    vw_json_numbers(reader, object, "centre", -COORDINATE_MAX, COORDINATE_MAX, centre, 3);
    for (int i = 0; i < 3; i++) centre[i] = (centre[i] - state->box->centre_world[i]) / state->edge_world + 0.5;
    shape->centre_radius = to_float4(centre, 0);
    read_size(reader, object, kind, state);
    vw_json_member(reader, object, "texture", true, read_texture, state);
    shape->kind = (uint32_t)kind;
    state->recipe->shape_count++;
}

static void read_world(struct vw_json_reader *reader, const json_t *root, struct vw_recipe *recipe,
                       struct vw_box *box) {
    int64_t version = 0, seed = 0;
    vw_json_check_keys(
        reader, root,
        "viewworth_recipe seed image box background sun exposure shapes cameras transients points defects");
    vw_json_integer(reader, root, "viewworth_recipe", 1, 1, &version);
    vw_json_integer(reader, root, "seed", 0, INT64_MAX, &seed);
    recipe->seed = (uint64_t)seed;
    recipe->sun_direction[2] = 1;
    recipe->ambient = 1;
    vw_json_member(reader, root, "image", true, read_image, recipe);
    vw_json_member(reader, root, "box", true, read_box, box);
    read_background(reader, root, recipe);
    vw_json_member(reader, root, "sun", false, read_sun, recipe);
    vw_json_member(reader, root, "exposure", false, read_exposure, recipe);
    vw_json_member(reader, root, "transients", false, read_transients, recipe);
    vw_json_word(reader, root, "points", "all none", &recipe->points);
    struct shape_reader shapes = {.recipe = recipe, .box = box, .edge_world = 2 * box->half_extent_world};
    vw_json_each(reader, root, "shapes", VW_RECIPE_SHAPES_MAX, read_shape, &shapes);
}

// ---- The scene -----------------------------------------------------------------------------------------------------

static const uint64_t PIXELS_MAX = UINT64_C(1) << 28; // for all views together: 1 GiB of photos

static enum vw_status read_recipe(struct vw_recipe *recipe, struct vw_scene *scene) {
    json_t *root = NULL;
    struct vw_json_reader reader = {.path = recipe->path,
                                    .status = vw_json_read_file(recipe->path, VW_RECIPE_LIMIT_BYTES, &root)};
    read_world(&reader, root, recipe, &scene->box);
    vw_recipe_read_cameras(&reader, root, recipe, scene);
    vw_recipe_read_defects(&reader, root, recipe, scene);
    json_decref(root);
    if ((uint64_t)recipe->width_px * recipe->height_px * scene->view_count > PIXELS_MAX)
        vw_json_refuse(&reader, "image",
                       "all photos together have more than %" PRIu64
                       " pixels; use fewer or smaller ones, or --downscale",
                       PIXELS_MAX);
    return reader.status;
}

static enum vw_status make_photo(struct vw_recipe_tracer *tracer, const struct vw_recipe *recipe, uint32_t view,
                                 struct vw_scene *scene, struct vw_recipe_photo *photo, float *depths) {
    enum vw_status status = vw_recipe_trace(tracer, view, photo);
    if (!status) status = vw_recipe_capture(recipe, view, photo, &scene->views[view]);
    if (!status) status = vw_corrupt_photo(recipe, view, photo);
    if (!status) status = vw_recipe_store_photo(photo, &scene->views[view]);
    for (size_t i = 0; !status && i < (size_t)photo->width_px * photo->height_px; i++)
        depths[i] = photo->pixels[i].depth;
    return status;
}

// Photos, then points: both are made with the true poses.
static enum vw_status make_photos(struct vw_gpu *gpu, const struct vw_recipe *recipe, struct vw_scene *scene) {
    size_t pixel_count = (size_t)recipe->width_px * recipe->height_px;
    struct vw_recipe_tracer *tracer = NULL;
    struct vw_recipe_photo photo = {.width_px = recipe->width_px,
                                    .height_px = recipe->height_px,
                                    .pixels = vw_allocate(pixel_count, sizeof *photo.pixels)};
    float *depths = vw_allocate(scene->view_count * pixel_count, sizeof *depths);
    enum vw_status status =
        photo.pixels && depths ? vw_recipe_tracer_create(gpu, recipe, scene, &tracer) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        status = make_photo(tracer, recipe, v, scene, &photo, depths + v * pixel_count);
    if (!status && recipe->points == 0) status = vw_recipe_make_points(recipe, depths, scene);
    vw_recipe_tracer_destroy(&tracer);
    free(photo.pixels);
    free(depths);
    return status;
}

enum vw_status vw_recipe_load(const struct vw_scene_params *params, struct vw_scene *scene) {
    if (!params->gpu && !params->headers_only)
        return vw_fail(VW_ERROR_USAGE, "%s: a recipe needs a Vulkan device, but none is open; use --device",
                       params->path);
    struct vw_recipe *recipe = vw_allocate(1, sizeof *recipe);
    if (!recipe) return VW_ERROR_MEMORY;
    recipe->path = params->path;
    recipe->downscale = params->downscale ? params->downscale : 1;
    enum vw_status status = read_recipe(recipe, scene);
    if (!status && !params->headers_only) status = make_photos(params->gpu, recipe, scene);
    for (uint32_t v = 0; v < scene->view_count; v++)
        scene->masked_view_count += scene->views[v].has_mask && scene->views[v].split != VW_SPLIT_EXCLUDED;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        vw_corrupt_pose(recipe, v, scene->views[v].camera_to_world);
    scene->has_alpha = recipe->background == BACKGROUND_TRANSPARENT;
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white, as for photos with alpha
    scene->box_source = vw_copy_text("recipe");
    if (!status && !scene->box_source) status = VW_ERROR_MEMORY;
    free(recipe->defects);
    free(recipe);
    return status;
}

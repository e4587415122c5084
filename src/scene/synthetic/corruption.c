// Defects of photos and of recorded poses. Deterministic: every random number is keyed by seed, view and pixel.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/random.h"
#include "image/image.h"
#include "scene/builder.h"
#include "scene/synthetic/recipe.h"

static float clamp_unit(float value) { return fminf(fmaxf(value, 0), 1); }

static size_t pixel_count(const struct vw_recipe_photo *photo) { return (size_t)photo->width_px * photo->height_px; }

// Draws by the method of Box and Muller.
void vw_recipe_draw_normals(uint32_t word_a, uint32_t word_b, float normals[2]) {
    float radius = sqrtf(-2 * logf(1 - vw_random_unit(word_a)));
    float angle = 6.28318531f * vw_random_unit(word_b);
    normals[0] = radius * cosf(angle);
    normals[1] = radius * sinf(angle);
}

static void add_noise(const struct vw_recipe *recipe, uint32_t view, float deviation, struct vw_recipe_photo *photo) {
    for (size_t i = 0; i < pixel_count(photo); i++) {
        uint32_t words[4];
        float normals[4];
        vw_random_words(recipe->seed, VW_RANDOM_RECIPE, i, view, VW_DRAW_NOISE, words);
        vw_recipe_draw_normals(words[0], words[1], normals);
        vw_recipe_draw_normals(words[2], words[3], normals + 2);
        vw_float4 *p = &photo->pixels[i].rgba;
        p->x = clamp_unit(p->x + deviation * normals[0]);
        p->y = clamp_unit(p->y + deviation * normals[1]);
        p->z = clamp_unit(p->z + deviation * normals[2]);
    }
}

static void expose(const float gain[3], const float bias[3], struct vw_recipe_photo *photo) {
    for (size_t i = 0; i < pixel_count(photo); i++) {
        vw_float4 *p = &photo->pixels[i].rgba;
        p->x = clamp_unit(gain[0] * p->x + bias[0]);
        p->y = clamp_unit(gain[1] * p->y + bias[1]);
        p->z = clamp_unit(gain[2] * p->z + bias[2]);
    }
}

// Applies the photo's own exposure: part of image formation, not a defect.
static void expose_photo(const struct vw_recipe *recipe, uint32_t view, struct vw_recipe_photo *photo) {
    float normals[8], gain[3], bias[3];
    for (uint32_t i = 0; i < 2; i++) {
        uint32_t words[4];
        vw_random_words(recipe->seed, VW_RANDOM_RECIPE, i, view, VW_DRAW_EXPOSURE, words);
        vw_recipe_draw_normals(words[0], words[1], normals + 4 * i);
        vw_recipe_draw_normals(words[2], words[3], normals + 4 * i + 2);
    }
    for (int c = 0; c < 3; c++) {
        gain[c] = (float)exp(recipe->gain_spread * normals[0] + recipe->tint_spread * normals[1 + c]);
        bias[c] = (float)recipe->bias_spread * normals[4 + c];
    }
    if (recipe->gain_spread > 0 || recipe->tint_spread > 0 || recipe->bias_spread > 0) expose(gain, bias, photo);
}

// ---- Blur: a Gaussian along rows, then along columns, of colours weighted by alpha ----

static void weigh_by_alpha(vw_float4 *p) { *p = (vw_float4){p->x * p->w, p->y * p->w, p->z * p->w, p->w}; }

static void unweigh_by_alpha(vw_float4 *p) {
    if (p->w > 0)
        *p = (vw_float4){clamp_unit(p->x / p->w), clamp_unit(p->y / p->w), clamp_unit(p->z / p->w), clamp_unit(p->w)};
}

enum { REACH_MAX_PX = 3 * 64 }; // three standard deviations of the strongest blur allowed

struct gaussian {
    int reach_px;
    float weights[REACH_MAX_PX + 1]; // by distance; sum to 1 over both sides
};

static void make_gaussian(double deviation_px, struct gaussian *gaussian) {
    double weights[REACH_MAX_PX + 1], total = 0;
    gaussian->reach_px = (int)ceil(3 * deviation_px);
    for (int i = 0; i <= gaussian->reach_px; i++) {
        weights[i] = exp(-0.5 * i * i / (deviation_px * deviation_px));
        total += i ? 2 * weights[i] : weights[i];
    }
    for (int i = 0; i <= gaussian->reach_px; i++) gaussian->weights[i] = (float)(weights[i] / total);
}

// Blurs `count` pixels that lie `stride` apart, in place; beyond the ends the last pixel repeats. `line` is room for a
// copy.
static void blur_line(const struct gaussian *gaussian, struct vw_recipe_pixel *pixels, size_t stride, int count,
                      vw_float4 *line) {
    for (int i = 0; i < count; i++) line[i] = pixels[(size_t)i * stride].rgba;
    for (int i = 0; i < count; i++) {
        vw_float4 sum = {0};
        for (int offset = -gaussian->reach_px; offset <= gaussian->reach_px; offset++) {
            int from = i + offset < 0 ? 0 : i + offset >= count ? count - 1 : i + offset;
            float weight = gaussian->weights[abs(offset)];
            sum.x += weight * line[from].x;
            sum.y += weight * line[from].y;
            sum.z += weight * line[from].z;
            sum.w += weight * line[from].w;
        }
        pixels[(size_t)i * stride].rgba = sum;
    }
}

static enum vw_status blur(double deviation_px, struct vw_recipe_photo *photo) {
    uint32_t width_px = photo->width_px, height_px = photo->height_px;
    vw_float4 *line = vw_allocate(width_px > height_px ? width_px : height_px, sizeof *line);
    if (!line) return VW_ERROR_MEMORY;
    struct gaussian gaussian;
    make_gaussian(deviation_px, &gaussian);
    for (size_t i = 0; i < pixel_count(photo); i++) weigh_by_alpha(&photo->pixels[i].rgba);
    for (uint32_t y = 0; y < height_px; y++)
        blur_line(&gaussian, photo->pixels + (size_t)y * width_px, 1, (int)width_px, line);
    for (uint32_t x = 0; x < width_px; x++) blur_line(&gaussian, photo->pixels + x, width_px, (int)height_px, line);
    for (size_t i = 0; i < pixel_count(photo); i++) unweigh_by_alpha(&photo->pixels[i].rgba);
    free(line);
    return VW_OK;
}

// ---- Occluder ----

// Puts a striped rectangle of random shape, place and colours in front of everything.
static void occlude(const struct vw_recipe *recipe, uint32_t view, double share, struct vw_recipe_photo *photo) {
    uint32_t place[4], colours[2][4];
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, view, VW_DRAW_OCCLUDER, place);
    for (uint32_t i = 0; i < 2; i++)
        vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 1 + i, view, VW_DRAW_OCCLUDER, colours[i]);
    double across =
        share + (1 - share) * vw_random_unit(place[0]); // share of the width; the height's is share / across
    uint32_t width_px = (uint32_t)fmax(1, round(across * photo->width_px));
    uint32_t height_px = (uint32_t)fmax(1, round(share / across * photo->height_px));
    uint32_t left = vw_random_below(place[1], photo->width_px - width_px + 1);
    uint32_t top = vw_random_below(place[2], photo->height_px - height_px + 1);
    uint32_t stripe_px = 1 + photo->width_px / 12;
    for (uint32_t y = top; y < top + height_px; y++)
        for (uint32_t x = left; x < left + width_px; x++) {
            const uint32_t *words = colours[(x + y) / stripe_px & 1];
            photo->pixels[(size_t)y * photo->width_px + x] = (struct vw_recipe_pixel){
                .rgba = {vw_random_unit(words[0]), vw_random_unit(words[1]), vw_random_unit(words[2]), 1}, .depth = 0};
        }
}

// Covers a square of random place with upright stripes, as NeRF-W (Martin-Brualla et al., CVPR 2021) does in the photos
// of its test.
static void cover(const struct vw_recipe *recipe, uint32_t view, double side, struct vw_recipe_photo *photo) {
    enum { STRIPES = 10 };
    uint32_t place[4], words[4], least_px = photo->width_px < photo->height_px ? photo->width_px : photo->height_px;
    uint32_t side_px = (uint32_t)fmin(least_px, fmax(1, round(side * photo->width_px)));
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, view, VW_DRAW_OCCLUDER, place);
    uint32_t left = vw_random_below(place[1], photo->width_px - side_px + 1);
    uint32_t top = vw_random_below(place[2], photo->height_px - side_px + 1);
    for (uint32_t x = 0; x < side_px; x++) {
        vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 1 + STRIPES * x / side_px, view, VW_DRAW_OCCLUDER, words);
        const vw_float4 colour = {vw_random_unit(words[0]), vw_random_unit(words[1]), vw_random_unit(words[2]), 1};
        for (uint32_t y = 0; y < side_px; y++)
            photo->pixels[(size_t)(top + y) * photo->width_px + left + x] =
                (struct vw_recipe_pixel){.rgba = colour, .depth = 0};
    }
}

enum vw_status vw_corrupt_photo(const struct vw_recipe *recipe, uint32_t view, struct vw_recipe_photo *photo) {
    const struct vw_recipe_defect *defect = &recipe->defects[view];
    const float gain = (float)defect->strength, bias = (float)defect->bias;
    expose_photo(recipe, view, photo);
    switch (defect->kind) {
    case VW_DEFECT_NOISE: add_noise(recipe, view, (float)defect->strength, photo); break;
    case VW_DEFECT_BLUR: return blur(defect->strength, photo);
    case VW_DEFECT_OCCLUDER: occlude(recipe, view, defect->strength, photo); break;
    case VW_DEFECT_STRIPED_BOX: cover(recipe, view, defect->strength, photo); break;
    case VW_DEFECT_EXPOSURE: expose((float[]){gain, gain, gain}, (float[]){bias, bias, bias}, photo); break;
    case VW_DEFECT_NONE:
    case VW_DEFECT_WRONG_POSE: break;
    }
    return VW_OK;
}

// Rotates the camera in place, about a random axis perpendicular to its line of sight, so that the content shifts by
// the whole angle.
void vw_corrupt_pose(const struct vw_recipe *recipe, uint32_t view, double camera_to_world[3][4]) {
    if (recipe->defects[view].kind != VW_DEFECT_WRONG_POSE) return;
    uint32_t words[4];
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, view, VW_DRAW_POSE, words);
    double around = 2 * M_PI * vw_random_unit(words[0]), angle = recipe->defects[view].strength * M_PI / 180;
    double x = cos(around), y = sin(around), c = cos(angle), s = sin(angle);
    const double turn[3][3] = {
        // about the axis (x, y, 0), in camera axes
        {c + x * x * (1 - c), x * y * (1 - c), y * s},
        {x * y * (1 - c), c + y * y * (1 - c), -x * s},
        {-y * s, x * s, c},
    };
    for (int i = 0; i < 3; i++) {
        double row[3] = {0};
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) row[j] += camera_to_world[i][k] * turn[k][j];
        memcpy(camera_to_world[i], row, sizeof row);
    }
}

// ---- Transient objects in front of a photo ----

// Places a disc as far from the borders as possible.
static enum vw_status pass_by(const struct vw_recipe *recipe, const uint32_t words[4], uint32_t index,
                              struct vw_recipe_photo *photo, struct vw_view *view) {
    uint32_t width_px = photo->width_px, height_px = photo->height_px, colour[4];
    double radius_px = sqrt(recipe->transient_size * width_px * height_px / M_PI);
    double x_px = radius_px + vw_random_unit(words[1]) * fmax(width_px - 2 * radius_px, 0);
    double y_px = radius_px + vw_random_unit(words[2]) * fmax(height_px - 2 * radius_px, 0);
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 1, index, VW_DRAW_TRANSIENT, colour);
    view->mask = vw_allocate((size_t)width_px * height_px, 1);
    if (!view->mask) return VW_ERROR_MEMORY;
    view->has_mask = true;
    memset(view->mask, VW_MASK_KEEP, (size_t)width_px * height_px);
    for (size_t i = 0; i < (size_t)width_px * height_px; i++) {
        if (hypot((double)(i % width_px) + 0.5 - x_px, (double)(i / width_px) + 0.5 - y_px) > radius_px) continue;
        photo->pixels[i] = (struct vw_recipe_pixel){
            .rgba = {vw_random_unit(colour[0]), vw_random_unit(colour[1]), vw_random_unit(colour[2]), 1}, .depth = 0};
        view->mask[i] = VW_MASK_HIDE;
    }
    return VW_OK;
}

enum vw_status vw_recipe_store_photo(const struct vw_recipe_photo *photo, struct vw_view *view) {
    size_t pixel_count = (size_t)photo->width_px * photo->height_px;
    uint8_t *bytes = vw_allocate(pixel_count, 4);
    if (!bytes) return VW_ERROR_MEMORY;
    view->image = (struct vw_image){
        .width_px = photo->width_px, .height_px = photo->height_px, .format = VW_PIXEL_UINT8, .pixels = bytes};
    for (size_t i = 0; i < pixel_count; i++) {
        const vw_float4 *p = &photo->pixels[i].rgba;
        const float channels[4] = {p->x, p->y, p->z, p->w};
        for (int c = 0; c < 4; c++) bytes[4 * i + c] = (uint8_t)(channels[c] * 255 + 0.5f);
        view->image.has_alpha |= bytes[4 * i + 3] < 255;
    }
    vw_sha256(bytes, 4 * pixel_count, view->sha256);
    return VW_OK;
}

enum vw_status vw_recipe_capture(const struct vw_recipe *recipe, uint32_t index, struct vw_recipe_photo *photo,
                                 struct vw_view *view) {
    uint32_t words[4];
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, index, VW_DRAW_TRANSIENT, words);
    return vw_random_unit(words[0]) < recipe->transient_share ? pass_by(recipe, words, index, photo, view) : VW_OK;
}

// ---- Corruption of a scene of photos -------------------------------------------------------------------------------

// Injects the defects of recipes into photos of any scene. All random numbers are keyed by a photo's name, so that the
// order of the scene file does not matter. The photos, sorted by these numbers, get the kinds of defects in turn:
// without one of them, the next photo gets its kind.
static const double BLUR_WIDTHS = 1.0 / 25;
static const struct vw_recipe_defect kinds[] = {
    {VW_DEFECT_NOISE, 0.2, 0},     {VW_DEFECT_BLUR, 0, 0},       {VW_DEFECT_OCCLUDER, 0.4, 0},
    {VW_DEFECT_EXPOSURE, 0.45, 0}, {VW_DEFECT_WRONG_POSE, 8, 0}, {VW_DEFECT_NOISE, 0.2, 0},
    {VW_DEFECT_BLUR, 0, 0},        {VW_DEFECT_OCCLUDER, 0.4, 0}, {VW_DEFECT_EXPOSURE, 1.9, 0},
    {VW_DEFECT_WRONG_POSE, 8, 0},
};

static uint64_t number_of(const struct vw_view *view) {
    uint8_t hash[VW_HASH_BYTES];
    uint64_t number;
    vw_sha256(view->name, strlen(view->name), hash);
    memcpy(&number, hash, sizeof number); // the same on all machines that SPIR-V and our buffers know: little-endian
    return number;
}

// A view that may be corrupted.
struct candidate {
    uint64_t number;
    struct vw_view *view;
};

static int compare_candidates(const void *a, const void *b) {
    uint64_t left = ((const struct candidate *)a)->number, right = ((const struct candidate *)b)->number;
    return (left > right) - (left < right);
}

// Lists the train views, smallest number first; returns their number.
static uint32_t list_candidates(const struct vw_scene *scene, struct candidate *candidates) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_TRAIN)
            candidates[count++] = (struct candidate){number_of(&scene->views[v]), &scene->views[v]};
    if (count) qsort(candidates, count, sizeof *candidates, compare_candidates);
    return count;
}

static enum vw_status corrupt_pixels(const struct vw_recipe *recipe, struct vw_view *view) {
    size_t count = (size_t)view->image.width_px * view->image.height_px;
    struct vw_recipe_photo photo = {.width_px = view->image.width_px,
                                    .height_px = view->image.height_px,
                                    .pixels = vw_allocate(count, sizeof *photo.pixels)};
    if (!photo.pixels) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        float rgba[4];
        vw_image_pixel(&view->image, (uint32_t)(i % photo.width_px), (uint32_t)(i / photo.width_px), rgba);
        photo.pixels[i].rgba = (vw_float4){rgba[0], rgba[1], rgba[2], rgba[3]};
    }
    struct vw_image before = view->image;
    enum vw_status status = vw_corrupt_photo(recipe, 0, &photo);
    if (!status) status = vw_recipe_store_photo(&photo, view);
    if (!status) {
        if (!before.lent) free(before.pixels);
        view->image.unusable = before.unusable;
        view->image.masked_count = before.masked_count;
    }
    free(photo.pixels);
    return status;
}

// Corrupts a view as the only one of a recipe.
static enum vw_status corrupt_view(const struct candidate *candidate, struct vw_recipe_defect defect,
                                   struct vw_recipe *recipe) {
    struct vw_view *view = candidate->view;
    if (defect.kind == VW_DEFECT_BLUR) defect.strength = BLUR_WIDTHS * view->camera.width_px;
    recipe->seed = candidate->number;
    recipe->defects = &defect;
    vw_corrupt_pose(recipe, 0, view->camera_to_world);
    bool turned = defect.kind == VW_DEFECT_WRONG_POSE;
    enum vw_status status =
        turned || !view->image.pixels ? VW_OK : corrupt_pixels(recipe, view); // with headers_only there are no pixels
    recipe->defects = NULL;
    view->ground_truth = vw_copy_text(vw_recipe_ground_truths[defect.kind]);
    return status || view->ground_truth ? status : VW_ERROR_MEMORY;
}

static enum vw_status decode(const struct vw_scene *scene, const struct candidate *candidates, uint32_t count) {
    uint32_t *views = vw_allocate(count, sizeof *views);
    if (!views) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) views[i] = (uint32_t)(candidates[i].view - scene->views);
    enum vw_status status = vw_scene_decode(scene, views, count);
    free(views);
    return status;
}

static enum vw_status corrupt(const struct vw_scene_params *params, struct vw_scene *scene,
                              struct candidate *candidates, struct vw_recipe *recipe) {
    uint32_t count = list_candidates(scene, candidates);
    if (params->corrupt > count)
        return vw_fail(VW_ERROR_USAGE, "--corrupt %u: there are only %u train photos; use a smaller number",
                       params->corrupt, count);
    enum vw_status status = decode(scene, candidates, params->corrupt);
    for (uint32_t i = 0; !status && i < params->corrupt; i++)
        status = corrupt_view(&candidates[i], kinds[i % VW_ARRAY_COUNT(kinds)], recipe);
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        if (!view->ground_truth && !(view->ground_truth = vw_copy_text(vw_recipe_ground_truths[VW_DEFECT_NONE])))
            status = VW_ERROR_MEMORY;
    }
    return status;
}

enum vw_status vw_inject_corruption(const struct vw_scene_params *params, struct vw_scene *scene) {
    if (!strcmp(scene->format, "recipe"))
        return vw_fail(VW_ERROR_USAGE, "--corrupt: %s is a recipe, which has its own defects; add them there",
                       params->path);
    struct vw_recipe *recipe = vw_allocate(1, sizeof *recipe);
    struct candidate *candidates = vw_allocate(scene->view_count, sizeof *candidates);
    enum vw_status status = recipe && candidates ? corrupt(params, scene, candidates, recipe) : VW_ERROR_MEMORY;
    free(candidates);
    free(recipe);
    return status;
}

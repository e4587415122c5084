#include "lab/copied_photos.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "scene/duplicates.h"

const struct vw_copying vw_copyings[] = {
    {.name = "the same pixels"},
    {.name = "crop 2 %", .crop = 0.02},
    {.name = "crop 5 %", .crop = 0.05},
    {.name = "crop 10 %", .crop = 0.1},
    {.name = "crop 20 %", .crop = 0.2},
    {.name = "crop 10 % at a corner", .crop = 0.1, .corner = true},
    {.name = "shift 1 px", .shift_px = 1},
    {.name = "shift 3 px", .shift_px = 3},
    {.name = "shift 10 px", .shift_px = 10},
    {.name = "exposure x 0.7", .gain = 0.7},
    {.name = "exposure x 1.4", .gain = 1.4},
    {.name = "gamma 0.7", .gamma = 0.7},
    {.name = "gamma 1.4", .gamma = 1.4},
    {.name = "mirrored", .mirrored = true},
    {.name = "JPEG, quality 30", .jpeg = "jpeg:30"},
    {.name = "half the size", .halved = true},
    {.name = "black border 5 %", .border = 0.1},
    {.name = "mask over 20 %", .masked = 0.2},
    {.name = "mask over 40 %", .masked = 0.4},
    {.name = "mask over 60 %", .masked = 0.6},
    {.name = "transparent over 40 %", .clear = 0.4},
    {.name = "mirrored, crop 5 %, x 0.7, JPEG", .mirrored = true, .crop = 0.05, .gain = 0.7, .jpeg = "jpeg:30"},
    {.name = "mask over 20 %, crop 5 %, x 1.4", .masked = 0.2, .crop = 0.05, .gain = 1.4},
    {.name = "another pose (90 degrees)", .turned_deg = 90},
    {.name = "another pose, crop 5 %, JPEG", .turned_deg = 90, .crop = 0.05, .jpeg = "jpeg:30"},
    {.name = "another pose, mirrored", .turned_deg = 90, .mirrored = true},
    {.name = "another pose, mask over 40 %", .turned_deg = 90, .masked = 0.4},
};
const uint32_t vw_copying_count = VW_ARRAY_COUNT(vw_copyings);

// ---- A copy ---------------------------------------------------------------------------------------------------------

// Writes the values of one pixel; outside of the photo, beside a shifted one or in a border, see vw_copying.
static void copy_pixel(const struct vw_view *original, const struct vw_copying *copying, int64_t x_px, int64_t y_px,
                       uint8_t *pixel) {
    int64_t width_px = original->image.width_px, height_px = original->image.height_px;
    if (copying->shift_px && x_px >= width_px) x_px = width_px - 1;
    bool inside = x_px >= 0 && y_px >= 0 && x_px < width_px && y_px < height_px;
    float rgba[4] = {0, 0, 0, 1};
    if (copying->mirrored) x_px = width_px - 1 - x_px;
    if (inside) vw_image_pixel(&original->image, (uint32_t)x_px, (uint32_t)y_px, rgba);
    for (int c = 0; c < 4; c++) {
        double value = rgba[c];
        if (c < 3 && copying->gamma) value = pow(value, copying->gamma);
        if (c < 3 && copying->gain) value *= copying->gain;
        pixel[c] = (uint8_t)lrint(255 * fmin(value, 1));
    }
}

static void copy_pixels(const struct vw_view *original, const struct vw_copying *copying, struct vw_view *copy) {
    const struct vw_image *image = &copy->image;
    double ends = copying->corner ? 0 : (copying->crop - copying->border) / 2;
    int64_t left_px = lrint(ends * original->image.width_px) + copying->shift_px;
    int64_t top_px = lrint(ends * original->image.height_px);
    uint32_t step = copying->halved ? 2 : 1;
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++) {
        uint32_t x_px = i % image->width_px, y_px = i / image->width_px, sums[4] = {0};
        for (uint32_t k = 0; k < step * step; k++) {
            uint8_t pixel[4];
            copy_pixel(original, copying, left_px + x_px * step + k % step, top_px + y_px * step + k / step, pixel);
            for (int c = 0; c < 4; c++) sums[c] += pixel[c];
        }
        for (int c = 0; c < 4; c++) ((uint8_t *)image->pixels)[4 * i + c] = (uint8_t)(sums[c] / (step * step));
        if (x_px < copying->clear * image->width_px) ((uint8_t *)image->pixels)[4 * i + 3] = 0;
        copy->mask[i] = x_px < copying->masked * image->width_px ? VW_MASK_HIDE : VW_MASK_KEEP;
    }
}

// Writes and reads the file of a photo; its transparency is lost.
static enum vw_status compress(struct vw_image *image, const char *compression) {
    struct vw_image_encoding encoding = {.width_px = image->width_px,
                                         .height_px = image->height_px,
                                         .channels = 3,
                                         .eight_bit = true,
                                         .compression = compression};
    size_t count = (size_t)image->width_px * image->height_px, size_bytes = 0;
    float *rgb = vw_allocate(3 * count, sizeof *rgb);
    void *file = NULL;
    int descriptor = memfd_create("copy", MFD_CLOEXEC);
    char *path = vw_format_text("/proc/self/fd/%d", descriptor);
    enum vw_status status = rgb && path ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < 3 * count; i++) {
        const uint8_t *pixel = (const uint8_t *)image->pixels + i / 3 * 4;
        rgb[i] = (float)pixel[i % 3] * (float)pixel[3] / (255 * 255);
    }
    if (!status && (descriptor < 0 || !vw_photo_format_of_name("copy.jpg", &encoding.format)))
        status = vw_fail(VW_ERROR_IO, "cannot make a JPEG file");
    if (!status) status = vw_image_encode(&encoding, rgb, &file, &size_bytes);
    if (!status && write(descriptor, file, size_bytes) != (ssize_t)size_bytes)
        status = vw_fail(VW_ERROR_IO, "cannot write a JPEG file");
    struct vw_image read = {0};
    if (!status) status = vw_image_load(path, 1, &read);
    if (!status) {
        vw_image_clear(image);
        *image = read;
    }
    if (descriptor >= 0) close(descriptor);
    free(rgb);
    free(file);
    free(path);
    return status;
}

static void turn(struct vw_view *view, double degrees) {
    double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
    for (int i = 0; i < 3; i++) {
        double right = view->camera_to_world[i][0], back = view->camera_to_world[i][2];
        view->camera_to_world[i][0] = c * right - s * back;
        view->camera_to_world[i][2] = s * right + c * back;
    }
}

enum vw_status vw_copy_photo(const struct vw_view *original, const struct vw_copying *copying, struct vw_view *copy) {
    double scale = (1 - copying->crop + copying->border) / (copying->halved ? 2 : 1);
    *copy = *original;
    copy->image = (struct vw_image){.width_px = (uint32_t)lrint(scale * original->image.width_px),
                                    .height_px = (uint32_t)lrint(scale * original->image.height_px),
                                    .format = VW_PIXEL_UINT8,
                                    .has_alpha = original->image.has_alpha || copying->clear > 0};
    size_t count = (size_t)copy->image.width_px * copy->image.height_px;
    copy->image.pixels = vw_allocate(count, 4);
    copy->mask = vw_allocate(count, 1);
    memset(copy->sha256, 0xff, sizeof copy->sha256);
    memcpy(copy->sha256, &copying, sizeof copying);
    memcpy(copy->sha256 + sizeof copying, &original, sizeof original); // other bytes than any file's
    enum vw_status status = copy->image.pixels && copy->mask ? VW_OK : VW_ERROR_MEMORY;
    if (!status) copy_pixels(original, copying, copy);
    if (!status && copying->jpeg) status = compress(&copy->image, copying->jpeg);
    turn(copy, copying->turned_deg);
    return status;
}

void vw_copied_photo_clear(struct vw_view *copy) {
    vw_image_clear(&copy->image);
    free(copy->mask);
    copy->mask = NULL;
}

// ---- What is found --------------------------------------------------------------------------------------------------

enum { COPIES_MOST = 24 };

static const struct vw_view *original_of(const struct vw_scene *scene, const struct vw_copies_found *found,
                                         uint32_t copy) {
    return &scene->views[(uint64_t)copy * found->photos / found->copies];
}

// Counts pairs in the groups: copies follow the photos.
static void count_pairs(const struct vw_scene *scene, const struct vw_duplicate *duplicates, uint32_t count,
                        struct vw_copies_found *found) {
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = i + 1; j < count && duplicates[j].group == duplicates[i].group; j++) {
            uint32_t first = duplicates[i].view, second = duplicates[j].view;
            if (second < found->photos) found->wrong++;
            else if (original_of(scene, found, second - found->photos) == &scene->views[first]) found->found++;
        }
}

static double now_s(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static enum vw_status search(const struct vw_scene *scene, struct vw_copies_found *found) {
    struct vw_duplicate *duplicates = NULL;
    uint32_t count = 0;
    double begin_s = now_s();
    enum vw_status status = vw_scene_find_duplicates(scene, &duplicates, &count);
    found->seconds = now_s() - begin_s;
    if (!status) count_pairs(scene, duplicates, count, found);
    free(duplicates);
    return status;
}

enum vw_status vw_find_copies(const struct vw_scene *scene, const struct vw_copying *copying,
                              struct vw_copies_found *found) {
    struct vw_scene copied = *scene;
    copied.source = NULL; // everything is decoded
    copied.view_count = 0;
    copied.views = vw_allocate((size_t)scene->view_count + COPIES_MOST, sizeof *copied.views);
    if (!copied.views) return VW_ERROR_MEMORY;
    enum vw_status status = vw_scene_decode_all(scene);
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split != VW_SPLIT_EXCLUDED) copied.views[copied.view_count++] = scene->views[v];
    uint32_t photos = copied.view_count, copies = !copying ? 0 : photos < COPIES_MOST ? photos : COPIES_MOST;
    *found = (struct vw_copies_found){.photos = photos, .copies = copies, .pairs = photos * (photos - 1) / 2};
    for (uint32_t i = 0; !status && i < copies; i++)
        status = vw_copy_photo(original_of(&copied, found, i), copying, &copied.views[copied.view_count++]);
    if (!status) status = search(&copied, found);
    for (uint32_t v = photos; v < copied.view_count; v++) vw_copied_photo_clear(&copied.views[v]);
    free(copied.views);
    return status;
}

#include "train/device_photos.h"

#include <stdlib.h>

#include "base/memory.h"
#include "image/pixel.h"

enum { SIDE_MOST_PX = 65535, WORD = sizeof(uint32_t) }; // so that shaders multiply sides and cells in 32 bits
enum { USE_WITH_MASKS = 1, USE_WITHOUT_MASKS = 2 };     // bits

static uint64_t pixels_of(const struct vw_view *view) {
    return (uint64_t)view->camera.width_px * view->camera.height_px;
}

static bool leaves_out(const struct vw_view *view) { return view->mask || view->image.unusable; }

// Places the photos one after another.
static enum vw_status place(struct vw_device_photos *photos, uint64_t *words) {
    for (uint32_t v = 0; v < photos->scene->view_count; v++) {
        const struct vw_view *view = &photos->scene->views[v];
        photos->first_words[v] = *words;
        if (view->split == VW_SPLIT_EXCLUDED) continue;
        if (view->camera.width_px > SIDE_MOST_PX || view->camera.height_px > SIDE_MOST_PX)
            return vw_fail(VW_ERROR_DEVICE, "%s: too large to be drawn from on the device", view->name);
        *words += vw_view_image_bytes(photos->scene, v) / WORD;
        if (leaves_out(view)) *words += (pixels_of(view) + WORD - 1) / WORD;
    }
    return VW_OK;
}

static enum vw_status create(struct vw_gpu *gpu, struct vw_device_photos *photos) {
    uint64_t words = 0, memory = vw_gpu_get_info(gpu)->memory_bytes, taken = vw_gpu_buffer_bytes(gpu),
             quarter = memory > taken ? (memory - taken) / 4 : 0,
             binding = vw_gpu_get_limits(gpu)->storage_binding_bytes, most = quarter < binding ? quarter : binding;
    photos->first_words = vw_allocate(photos->scene->view_count, sizeof *photos->first_words);
    photos->kept = vw_allocate(photos->scene->view_count, sizeof *photos->kept);
    if (!photos->first_words || !photos->kept) return VW_ERROR_MEMORY;
    enum vw_status status = place(photos, &words);
    if (!status && WORD * words > most)
        status =
            vw_fail(VW_ERROR_DEVICE, "the photos' %.0f MiB are more than the device keeps", 0x1p-20 * WORD * words);
    const struct vw_buffer_params params = {.name = "photos", .size_bytes = WORD * words, .memory = VW_BUFFER_DEVICE};
    return !status ? vw_buffer_create(gpu, &params, &photos->buffer) : status;
}

enum vw_status vw_device_photos_create(struct vw_gpu *gpu, const struct vw_scene *scene,
                                       struct vw_device_photos **photos) {
    struct vw_device_photos *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->scene = scene;
    enum vw_status status = create(gpu, made);
    if (status) vw_device_photos_destroy(&made);
    else *photos = made;
    return status;
}

void vw_device_photos_destroy(struct vw_device_photos **photos) {
    struct vw_device_photos *dying = *photos;
    if (!dying) return;
    vw_buffer_destroy(&dying->buffer);
    free(dying->first_words);
    free(dying->kept);
    free(dying);
    *photos = NULL;
}

static enum vw_status write_uses(const struct vw_device_photos *photos, const struct vw_view *view, uint64_t byte) {
    uint64_t count = pixels_of(view);
    uint8_t *uses = vw_allocate(count, sizeof *uses);
    if (!uses) return VW_ERROR_MEMORY;
    for (uint32_t y = 0; y < view->camera.height_px; y++)
        for (uint32_t x = 0; x < view->camera.width_px; x++)
            uses[(size_t)y * view->camera.width_px + x] = (vw_view_keeps(view, x, y) ? USE_WITH_MASKS : 0) |
                                                          (vw_view_can_use(view, x, y) ? USE_WITHOUT_MASKS : 0);
    enum vw_status status = vw_buffer_write(photos->buffer, byte, uses, count);
    free(uses);
    return status;
}

enum vw_status vw_device_photos_keep(struct vw_device_photos *photos, const uint32_t *views, uint32_t count) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        const struct vw_view *view = &photos->scene->views[views[i]];
        uint64_t byte = WORD * photos->first_words[views[i]], bytes = vw_view_image_bytes(photos->scene, views[i]);
        if (photos->kept[views[i]]) continue;
        status = vw_buffer_write(photos->buffer, byte, view->image.pixels, bytes);
        if (!status && leaves_out(view)) status = write_uses(photos, view, byte + bytes);
        photos->kept[views[i]] = !status;
    }
    return status;
}

struct vw_push_draw vw_device_photos_push(const struct vw_device_photos *photos, uint32_t view,
                                          const struct vw_pixel_draw *draw, uint32_t first_pixel, uint32_t count) {
    const struct vw_view *of = &photos->scene->views[view];
    uint32_t first_word = (uint32_t)photos->first_words[view],
             pixel_words = (uint32_t)vw_pixel_channel_bytes(of->image.format);
    return (struct vw_push_draw){
        .key = {(uint32_t)draw->seed, (uint32_t)(draw->seed >> 32), (uint32_t)draw->step, (uint32_t)(draw->step >> 32)},
        .first_pixel = first_pixel,
        .count = count,
        .listed = count,
        .view = view,
        .width_px = of->camera.width_px,
        .height_px = of->camera.height_px,
        .first_word = first_word,
        .pixel_words = pixel_words, // 4 channels
        .first_mask_word = leaves_out(of) ? first_word + pixel_words * (uint32_t)pixels_of(of) : 0,
        .mask_bit = draw->masks ? USE_WITH_MASKS : USE_WITHOUT_MASKS,
        .side = draw->picture_side,
        .draw = draw->draw,
    };
}

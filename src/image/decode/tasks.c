#include "image/decode/tasks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/decode/oiio_shim.h"
#include "image/photo_formats.h"
#include "image/pixel.h"

// ---- Downscaling ---------------------------------------------------------------------------------------------------

static float clamp_unit(float value) { return value > 0 ? (value < 1 ? value : 1) : 0; }

// Multiplies colour by alpha, so that hidden colours of transparent or masked pixels do not affect their neighbours.
static float *premultiplied(const struct vw_image *image) {
    size_t pixel_count = (size_t)image->width_px * image->height_px;
    float *rgba = vw_allocate(pixel_count * 4, sizeof *rgba);
    if (!rgba) return NULL;
    for (size_t i = 0; i < pixel_count * 4; i += 4) {
        rgba[i + 3] = vw_pixel_get(image->format, image->pixels, i + 3);
        for (size_t c = 0; c < 3; c++) rgba[i + c] = vw_pixel_get(image->format, image->pixels, i + c) * rgba[i + 3];
    }
    return rgba;
}

// Converts back to straight alpha. In an image without transparency, alpha is below 1 only because of unusable pixels,
// so usable pixels become opaque.
static void straighten(const float premultiplied[4], bool has_alpha, bool unusable, float rgba[4]) {
    const float alpha_min = 0.5f / 65535.0f; // rounds to 0 in 16 bits
    float alpha = premultiplied[3];          // the filter can leave [0,1] a little, as can the colour
    bool visible = alpha >= alpha_min && !unusable;
    for (int c = 0; c < 3; c++) rgba[c] = visible ? clamp_unit(premultiplied[c] / alpha) : 0;
    rgba[3] = !visible ? 0 : has_alpha ? clamp_unit(alpha) : 1;
}

// Marks the small pixels that are at least half unusable; NULL if memory is short.
static uint8_t *downscale_unusable(const struct vw_image *image, uint32_t width_px, uint32_t height_px) {
    uint32_t *bad = vw_allocate((size_t)width_px * height_px, 2 * sizeof *bad),
             *all = bad + (size_t)width_px * height_px;
    uint8_t *unusable = vw_allocate((size_t)width_px * height_px, 1);
    for (uint32_t y = 0; bad && unusable && y < image->height_px; y++) {
        for (uint32_t x = 0; x < image->width_px; x++) {
            size_t small =
                (uint64_t)y * height_px / image->height_px * width_px + (uint64_t)x * width_px / image->width_px;
            bad[small] += image->unusable[(size_t)y * image->width_px + x];
            all[small]++;
        }
    }
    for (size_t i = 0; bad && unusable && i < (size_t)width_px * height_px; i++) unusable[i] = 2 * bad[i] >= all[i];
    if (!bad) {
        free(unusable);
        unusable = NULL;
    }
    free(bad);
    return unusable;
}

// Replaces the pixels by floor(size / factor), at least 1, along each axis; UINT16 for integer images. `factor` > 1.
// After a failure the image is unchanged.
static enum vw_status downscale_image(struct vw_image *image, uint32_t factor) {
    uint32_t width_px = vw_downscaled_px(image->width_px, factor);
    uint32_t height_px = vw_downscaled_px(image->height_px, factor);
    enum vw_pixel_format format = image->format == VW_PIXEL_FLOAT32 ? VW_PIXEL_FLOAT32 : VW_PIXEL_UINT16;
    size_t value_count = (size_t)width_px * height_px * 4;
    void *pixels = vw_allocate(value_count, vw_pixel_channel_bytes(format));
    uint8_t *unusable = image->unusable ? downscale_unusable(image, width_px, height_px) : NULL;
    float *large = pixels && (unusable || !image->unusable) ? premultiplied(image) : NULL;
    if (!large) {
        free(pixels);
        free(unusable);
        return VW_ERROR_MEMORY;
    }
    struct vw_oiio_result small = vw_oiio_resize(large, image->width_px, image->height_px, width_px, height_px);
    free(large);
    if (small.status) {
        free(pixels);
        free(unusable);
        return vw_fail(small.status, "%s", small.message);
    }
    for (size_t i = 0; i < value_count; i += 4) {
        float rgba[4];
        straighten((const float *)small.data + i, image->has_alpha, unusable && unusable[i / 4], rgba);
        for (size_t c = 0; c < 4; c++) vw_pixel_set(format, pixels, i + c, rgba[c]);
    }
    free(small.data);
    free(image->pixels);
    free(image->unusable);
    image->pixels = pixels;
    image->unusable = unusable;
    image->format = format;
    image->width_px = width_px;
    image->height_px = height_px;
    return VW_OK;
}

static const double MASKED_SHARE_LIMIT = 0.05;

// ---- From the channels of a file to RGBA ----

static void unpremultiply(float rgba[4]) {
    for (int c = 0; c < 3; c++) rgba[c] = rgba[3] > 0 ? fminf(rgba[c] / rgba[3], 3e38f) : 0;
}

static bool is_usable(const float rgba[4]) {
    for (int c = 0; c < 4; c++)
        if (!isfinite(rgba[c]) || rgba[c] < 0) return false;
    return true;
}

// Encodes linear light as sRGB, clamps it to 1 and counts the clamped values.
static void encode_and_clamp(float rgba[4], uint64_t *clamped_count) {
    for (int c = 0; c < 4; c++) {
        if (rgba[c] > 1) {
            rgba[c] = 1;
            (*clamped_count)++;
        } else if (c < 3) {
            rgba[c] = vw_srgb_encode(rgba[c]);
        }
    }
}

// Fills one pixel of the image from the channels of the file.
static void take_pixel(const struct vw_oiio_result *file, size_t pixel, struct vw_image *image) {
    float rgba[4];
    enum vw_pixel_format format = file->header.format;
    for (int c = 0; c < 4; c++) {
        int channel = file->rgba_channel[c];
        size_t value = pixel * file->header.channels + (size_t)channel;
        rgba[c] = channel < 0 ? 1.0f : vw_pixel_get(format, file->data, value);
    }
    if (is_usable(rgba)) {
        if (rgba[3] < 1) image->has_alpha = true;
        if (file->premultiplied) unpremultiply(rgba);
        if (format == VW_PIXEL_FLOAT32) encode_and_clamp(rgba, &image->clamped_count);
    } else {
        memset(rgba, 0, sizeof rgba);
        image->masked_count++;
        image->unusable[pixel] = 1;
    }
    for (int c = 0; c < 4; c++) vw_pixel_set(image->format, image->pixels, pixel * 4 + (size_t)c, fminf(rgba[c], 1));
}

// Fills the image from integers, which no conversion would change.
static void copy_integers(const struct vw_oiio_result *file, size_t pixel_count, struct vw_image *image) {
    static const uint8_t most[2] = {UINT8_MAX, UINT8_MAX}; // where the file has no such channel
    size_t bytes = vw_pixel_channel_bytes(image->format), channels = file->header.channels;
    uint8_t *to = image->pixels;
    for (size_t i = 0; i < 4 * pixel_count; i++, to += bytes) {
        int channel = file->rgba_channel[i % 4];
        const uint8_t *from = channel < 0 ? most : (const uint8_t *)file->data + (i / 4 * channels + channel) * bytes;
        to[0] = from[0];
        if (bytes == 2) to[1] = from[1];
        image->has_alpha |= i % 4 == 3 && (to[0] & to[bytes - 1]) != UINT8_MAX;
    }
}

static enum vw_status convert(const struct vw_oiio_result *file, struct vw_image *image) {
    const struct vw_image_header *header = &file->header;
    size_t pixel_count = (size_t)header->width_px * header->height_px;
    image->width_px = header->width_px;
    image->height_px = header->height_px;
    image->format = header->format;
    image->pixels = vw_allocate(pixel_count * 4, vw_pixel_channel_bytes(header->format));
    image->unusable = vw_allocate(pixel_count, 1);
    if (!image->pixels || !image->unusable) return VW_ERROR_MEMORY;
    if (header->format != VW_PIXEL_FLOAT32 && !file->premultiplied) copy_integers(file, pixel_count, image);
    else
        for (size_t i = 0; i < pixel_count; i++) take_pixel(file, i, image);
    if (!image->masked_count) {
        free(image->unusable);
        image->unusable = NULL;
    }
    double masked_share = (double)image->masked_count / (double)pixel_count;
    if (masked_share <= MASKED_SHARE_LIMIT) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%.1f %% of the pixels are NaN, infinite or negative (at most %.0f %%); repair or remove the image",
                   100 * masked_share, 100 * MASKED_SHARE_LIMIT);
}

// ---- Tasks ----

void vw_task_fail(enum vw_status status, const char *message, struct vw_decoder_answer *answer) {
    *answer = (struct vw_decoder_answer){.status = (uint32_t)status};
    snprintf(answer->message, sizeof answer->message, "%s", message);
}

void vw_task_read_header(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                         struct vw_decoder_answer *answer) {
    struct vw_oiio_result found = vw_oiio_probe(vw_photo_formats[request->photo_format].plugin, file, file_bytes);
    if (found.status) vw_task_fail(found.status, found.message, answer);
    else *answer = (struct vw_decoder_answer){.header = found.header};
}

static enum vw_status read_photo(const struct vw_oiio_result *file, uint32_t downscale, struct vw_image *image) {
    enum vw_status status = convert(file, image);
    return status || downscale <= 1 ? status : downscale_image(image, downscale);
}

void vw_task_read_photo(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                        struct vw_decoder_answer *answer, struct vw_image *image) {
    struct vw_image made = {0};
    struct vw_oiio_result read =
        vw_oiio_read(vw_photo_formats[request->photo_format].plugin, file, file_bytes, &request->header);
    if (read.status) {
        vw_task_fail(read.status, read.message, answer);
        return;
    }
    enum vw_status status = read_photo(&read, request->downscale, &made);
    free(read.data);
    if (status) {
        vw_image_clear(&made);
        vw_task_fail(status, vw_error_message(), answer);
        return;
    }
    *answer = (struct vw_decoder_answer){.header = {made.width_px, made.height_px, 4, made.format},
                                         .has_alpha = made.has_alpha,
                                         .clamped_count = made.clamped_count,
                                         .masked_count = made.masked_count};
    answer->payload_bytes =
        (uint64_t)made.width_px * made.height_px * (4 * vw_pixel_channel_bytes(made.format) + (made.masked_count > 0));
    *image = made;
}

void vw_task_write_photo(const struct vw_decoder_request *request, const float *pixels,
                         struct vw_decoder_answer *answer, void **file) {
    struct vw_oiio_result made = vw_oiio_encode(vw_photo_formats[request->photo_format].plugin, &request->header,
                                                request->eight_bit, request->compression, pixels);
    if (made.status) {
        vw_task_fail(made.status, made.message, answer);
        return;
    }
    *answer = (struct vw_decoder_answer){.payload_bytes = made.size_bytes};
    *file = made.data;
}

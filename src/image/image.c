#include "image/image.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "image/downscale.h"
#include "image/oiio_shim.h"
#include "image/pixel.h"
#include "image/transfer.h"
#include "base/file.h"
#include "base/memory.h"

static const uint64_t PIXEL_LIMIT = UINT64_C(1) << 28;
static const uint32_t CHANNEL_LIMIT = 64; // renderers write depth, normals and more to EXR files
static const double MASKED_SHARE_LIMIT = 0.05;

static enum vw_status read_header(const char *path, struct vw_oiio_result *header) {
    if (!vw_file_exists(path)) return vw_fail(VW_ERROR_INPUT, "%s: no such image file; check the path", path);
    *header = vw_oiio_probe(path);
    if (header->status)
        return vw_fail(header->status, "%s: cannot open the image: %s; replace or remove it", path, header->message);
    if ((uint64_t)header->width_px * header->height_px > PIXEL_LIMIT)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: %u x %u pixels are more than the limit of %" PRIu64 "; make the image smaller", path,
                       header->width_px, header->height_px, PIXEL_LIMIT);
    if (header->channels > CHANNEL_LIMIT)
        return vw_fail(VW_ERROR_INPUT, "%s: %u channels are more than the limit of %u; keep colour and alpha", path,
                       header->channels, CHANNEL_LIMIT);
    return VW_OK;
}

enum vw_status vw_image_probe(const char *path, uint32_t *width_px, uint32_t *height_px) {
    struct vw_oiio_result header;
    enum vw_status status = read_header(path, &header);
    if (status) return status;
    *width_px = header.width_px;
    *height_px = header.height_px;
    return VW_OK;
}

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
    for (int c = 0; c < 4; c++) {
        int channel = file->rgba_channel[c];
        rgba[c] = channel < 0 ? 1.0f : vw_pixel_get(file->format, file->data, pixel * file->channels + (size_t)channel);
    }
    if (is_usable(rgba)) {
        if (rgba[3] < 1) image->has_alpha = true;
        if (file->premultiplied) unpremultiply(rgba);
        if (file->format == VW_PIXEL_FLOAT32) encode_and_clamp(rgba, &image->clamped_count);
    } else {
        memset(rgba, 0, sizeof rgba);
        image->masked_count++;
        image->unusable[pixel] = 1;
    }
    for (int c = 0; c < 4; c++) vw_pixel_set(image->format, image->pixels, pixel * 4 + (size_t)c, fminf(rgba[c], 1));
}

static void drop_unusable(struct vw_image *image) {
    free(image->unusable);
    image->unusable = NULL;
}

static enum vw_status convert(const char *path, const struct vw_oiio_result *file, struct vw_image *image) {
    size_t pixel_count = (size_t)file->width_px * file->height_px;
    image->width_px = file->width_px;
    image->height_px = file->height_px;
    image->format = file->format;
    image->pixels = vw_allocate(pixel_count * 4, vw_pixel_channel_bytes(file->format));
    image->unusable = vw_allocate(pixel_count, 1);
    if (!image->pixels || !image->unusable) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < pixel_count; i++) take_pixel(file, i, image);
    if (!image->masked_count) drop_unusable(image);
    double masked_share = (double)image->masked_count / (double)pixel_count;
    if (masked_share <= MASKED_SHARE_LIMIT) return VW_OK;
    return vw_fail(
        VW_ERROR_INPUT,
        "%s: %.1f %% of the pixels are NaN, infinite or negative (at most %.0f %%); repair or remove the image", path,
        100 * masked_share, 100 * MASKED_SHARE_LIMIT);
}

enum vw_status vw_image_load(const char *path, uint32_t downscale, struct vw_image *image) {
    struct vw_image loaded = {0};
    struct vw_oiio_result file;
    enum vw_status status = read_header(path, &file);
    if (status) return status;
    file = vw_oiio_read(path);
    if (file.status)
        return vw_fail(file.status, "%s: cannot decode the image: %s; replace or remove it", path, file.message);
    status = convert(path, &file, &loaded);
    free(file.data);
    if (!status && downscale > 1) {
        status = vw_image_downscale(&loaded, downscale);
        if (status) vw_fail_context(status, "%s", path);
    }
    if (status) vw_image_clear(&loaded);
    else *image = loaded;
    return status;
}

// Converts to linear light with premultiplied colour, as OpenEXR needs it.
static float *to_linear(size_t pixel_count, uint32_t channels, const float *pixels) {
    float *linear = vw_allocate(pixel_count * channels, sizeof *linear);
    if (!linear) return NULL;
    for (size_t i = 0; i < pixel_count * channels; i += channels) {
        float alpha = channels == 4 ? pixels[i + 3] : 1.0f;
        for (uint32_t c = 0; c < 3; c++) linear[i + c] = vw_srgb_decode(pixels[i + c]) * alpha;
        if (channels == 4) linear[i + 3] = alpha;
    }
    return linear;
}

enum vw_status vw_image_save(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                             const float *pixels) {
    const char *dot = strrchr(path, '.');
    bool linear = dot && !strcasecmp(dot, ".exr");
    float *converted = NULL;
    if (linear) {
        converted = to_linear((size_t)width_px * height_px, channels, pixels);
        if (!converted) return VW_ERROR_MEMORY;
    }
    struct vw_oiio_result file =
        vw_oiio_encode(path, width_px, height_px, channels, !linear, NULL, linear ? converted : pixels);
    enum vw_status status = file.status ? vw_fail(file.status, "%s: cannot write the image: %s", path, file.message)
                                        : vw_file_write(path, file.data, file.size_bytes);
    free(file.data);
    free(converted);
    return status;
}

void vw_image_clear(struct vw_image *image) {
    if (!image) return;
    free(image->pixels);
    free(image->unusable);
    *image = (struct vw_image){0};
}

void vw_image_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, float rgba[4]) {
    size_t first = ((size_t)y_px * image->width_px + x_px) * 4;
    for (size_t c = 0; c < 4; c++) rgba[c] = vw_pixel_get(image->format, image->pixels, first + c);
}

double vw_image_luminance(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float background[3]) {
    static const double weights[3] = {0.2126, 0.7152, 0.0722};
    float rgba[4];
    double sum = 0;
    vw_image_pixel(image, x_px, y_px, rgba);
    for (int c = 0; c < 3; c++) sum += weights[c] * (rgba[3] * rgba[c] + (1 - rgba[3]) * background[c]);
    return sum;
}

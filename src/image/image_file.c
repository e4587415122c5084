// Reads and writes image files through the decoder.
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <sodium.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "image/decoder.h"
#include "image/decoder_protocol.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "image/pixel.h"

static const uint64_t PIXEL_LIMIT = UINT64_C(1) << 28, FILE_LIMIT_BYTES = UINT64_C(1) << 32;
static const uint64_t VALUE_LIMIT = UINT64_C(1) << 30; // in all channels: four of the largest image
static const uint32_t CHANNEL_LIMIT = 64;              // renderers write depth, normals and more to EXR files
enum { COPY_BYTES = 1 << 24 };
static const uint64_t DECODER_BYTES = UINT64_C(256) << 20; // for decoders, whatever the size of the image

// ---- Opening --------------------------------------------------------------------------------------------------------

struct photo_file {
    const char *path; // borrowed
    int descriptor;
    uint64_t size_bytes;
    uint32_t format;
};

// Replaces an open file by a copy in memory that no one can change: what is hashed is then what is decoded, whatever
// happens to the file, and however short the ticks of its clock are. Returns the cause of a failure, or 0.
static int take_copy(struct photo_file *file) {
    int copy = memfd_create("photo", MFD_CLOEXEC | MFD_ALLOW_SEALING), cause = copy < 0 ? errno : 0;
    off_t end = 0;
    for (ssize_t got = 1; !cause && got && (uint64_t)end <= FILE_LIMIT_BYTES;) {
        got = sendfile(copy, file->descriptor, &end, COPY_BYTES);
        if (got < 0 && errno != EINTR) cause = errno;
    }
    if (!cause && fcntl(copy, F_ADD_SEALS, F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE)) cause = errno;
    if (cause) {
        if (copy >= 0) close(copy);
        return cause;
    }
    close(file->descriptor);
    file->descriptor = copy;
    file->size_bytes = (uint64_t)end;
    return 0;
}

static enum vw_status check_file(struct photo_file *file) {
    char bytes[VW_PHOTO_SIGNATURE_BYTES];
    ssize_t count = pread(file->descriptor, bytes, sizeof bytes, 0);
    if (count < 0) return vw_fail(VW_ERROR_IO, "%s: cannot read the image; check the disk", file->path);
    if (file->size_bytes > FILE_LIMIT_BYTES)
        return vw_fail(VW_ERROR_INPUT, "%s: larger than the limit of %" PRIu64 " bytes; make the image smaller",
                       file->path, FILE_LIMIT_BYTES);
    if (vw_photo_format_of_bytes(bytes, (size_t)count, &file->format)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: cannot open the image: its first bytes are of no format that is read, which are " //
                   VW_PHOTO_FORMAT_NAMES "; convert or remove it",
                   file->path);
}

// Opens a file, unless it is open, and checks it; `copied`: its pixels are to be read.
static enum vw_status open_file(const char *path, int descriptor, bool copied, struct photo_file *file) {
    struct stat info = {0};
    if (descriptor < 0 && !vw_file_exists(path))
        return vw_fail(VW_ERROR_INPUT, "%s: no such image file; check the path", path);
    *file = (struct photo_file){.path = path, .descriptor = descriptor};
    enum vw_status status = descriptor < 0 ? vw_file_open(path, &file->descriptor) : VW_OK;
    if (status) return status;
    int cause = fstat(file->descriptor, &info) ? errno : 0;
    file->size_bytes = (uint64_t)info.st_size;
    if (!cause && copied && file->size_bytes <= FILE_LIMIT_BYTES) cause = take_copy(file);
    status = cause ? vw_fail(VW_ERROR_IO, "%s: cannot read the image: %s; check the disk and the memory", path,
                             strerror(cause))
                   : check_file(file);
    if (status) close(file->descriptor);
    return status;
}

// ---- Headers --------------------------------------------------------------------------------------------------------

static enum vw_status check_header(const char *path, const struct vw_image_header *header) {
    if (!header->width_px || !header->height_px || !header->channels || header->format > VW_PIXEL_FLOAT32 ||
        header->orientation > 8)
        return vw_fail(VW_ERROR_IO, "%s: the image decoder returned invalid data; remove the file", path);
    if ((uint64_t)header->width_px * header->height_px > PIXEL_LIMIT)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: %u x %u pixels are more than the limit of %" PRIu64 "; make the image smaller", path,
                       header->width_px, header->height_px, PIXEL_LIMIT);
    if ((uint64_t)header->width_px * header->height_px * header->channels > VALUE_LIMIT)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: %u x %u pixels of %u channels are more than the limit of %" PRIu64
                       " values; keep colour and alpha",
                       path, header->width_px, header->height_px, header->channels, VALUE_LIMIT);
    if (header->channels > CHANNEL_LIMIT)
        return vw_fail(VW_ERROR_INPUT, "%s: %u channels are more than the limit of %u; keep colour and alpha", path,
                       header->channels, CHANNEL_LIMIT);
    return VW_OK;
}

static enum vw_status read_header(const struct photo_file *file, struct vw_image_header *header) {
    const struct vw_decoder_request request = {.task = VW_DECODER_READ_HEADER, .photo_format = file->format};
    struct vw_decoder_job *job = NULL;
    struct vw_decoder_answer answer = {0};
    enum vw_status status = vw_decoder_begin(&request, file->descriptor, NULL, 0, 0, &job);
    if (!status) status = vw_decoder_finish(job, &answer);
    if (status) {
        struct vw_saved_error why = vw_error_save();
        vw_fail(status, "%s: cannot open the image: %s; replace or remove it", file->path, why.message);
    } else {
        *header = answer.header;
        status = check_header(file->path, header);
    }
    vw_decoder_end(&job);
    return status;
}

enum vw_status vw_image_probe(const char *path, int descriptor, struct vw_image_header *header) {
    struct photo_file file;
    struct vw_image_header found;
    enum vw_status status = open_file(path, descriptor, false, &file);
    if (status) return status;
    status = read_header(&file, &found);
    if (!status) *header = found;
    close(file.descriptor);
    return status;
}

// ---- Pixels ---------------------------------------------------------------------------------------------------------

struct vw_image_load {
    struct photo_file file;
    struct vw_image_header header; // header of the pixels that are to come
    struct vw_decoder_job *job;
};

struct vw_image_header vw_image_loaded_header(const struct vw_image_header *header, uint32_t downscale) {
    bool filtered = downscale > 1 && header->format != VW_PIXEL_FLOAT32;
    return (struct vw_image_header){.width_px = vw_downscaled_px(header->width_px, downscale),
                                    .height_px = vw_downscaled_px(header->height_px, downscale),
                                    .channels = 4,
                                    .format = filtered ? VW_PIXEL_UINT16 : header->format};
}

uint64_t vw_image_loaded_bytes(const struct vw_image_header *header, uint32_t downscale) {
    struct vw_image_header loaded = vw_image_loaded_header(header, downscale);
    return (uint64_t)loaded.width_px * loaded.height_px * loaded.channels * vw_pixel_channel_bytes(loaded.format);
}

// Bounds the memory: a decoder keeps up to four copies of the channels as 32 bits, and we three of the colours.
static uint64_t needed_bytes(const struct vw_image_header *header) {
    return DECODER_BYTES + (uint64_t)header->width_px * header->height_px * (16 * (uint64_t)header->channels + 48);
}

static enum vw_status begin_load(const struct vw_image_header *header, uint32_t downscale, struct vw_image_load *load) {
    const struct vw_decoder_request request = {
        .task = VW_DECODER_READ_PHOTO, .photo_format = load->file.format, .downscale = downscale, .header = *header};
    load->header = vw_image_loaded_header(header, downscale);
    enum vw_status status = vw_decoder_begin(&request, load->file.descriptor, NULL, 0,
                                             needed_bytes(header) + load->file.size_bytes, &load->job);
    return status ? vw_fail_context(status, "%s", load->file.path) : VW_OK;
}

enum vw_status vw_image_load_begin(const char *path, int descriptor, const struct vw_image_header *header,
                                   uint32_t downscale, struct vw_image_load **load) {
    struct photo_file file;
    enum vw_status status = open_file(path, descriptor, true, &file);
    if (status) return status;
    struct vw_image_load *begun = vw_allocate(1, sizeof *begun);
    if (!begun) {
        close(file.descriptor);
        return VW_ERROR_MEMORY;
    }
    begun->file = file;
    status = begin_load(header, downscale, begun);
    if (status) vw_image_load_cancel(&begun);
    else *load = begun;
    return status;
}

void vw_image_load_cancel(struct vw_image_load **load) {
    struct vw_image_load *ending = load ? *load : NULL;
    if (!ending) return;
    vw_decoder_end(&ending->job);
    close(ending->file.descriptor);
    free(ending);
    *load = NULL;
}

// Checks floats and treats counts as display only: nothing that the worker says about the pixels is trusted.
static enum vw_status check_pixels(struct vw_image *image, size_t pixel_count) {
    for (size_t i = 0; image->unusable && i < pixel_count; i++) image->unusable[i] = image->unusable[i] != 0;
    const float *values = image->format == VW_PIXEL_FLOAT32 ? image->pixels : NULL;
    for (size_t i = 0; values && i < 4 * pixel_count; i++)
        if (!(values[i] >= 0 && values[i] <= 1)) return vw_fail(VW_ERROR_IO, "the image decoder returned invalid data");
    return VW_OK;
}

static enum vw_status receive_pixels(const struct vw_image_load *load, const struct vw_decoder_answer *answer,
                                     void *pixels, struct vw_image *image) {
    const struct vw_image_header *header = &load->header;
    size_t pixel_count = (size_t)header->width_px * header->height_px;
    size_t pixels_bytes = pixel_count * 4 * vw_pixel_channel_bytes(header->format);
    *image = (struct vw_image){.width_px = header->width_px,
                               .height_px = header->height_px,
                               .format = header->format,
                               .has_alpha = answer->has_alpha != 0,
                               .clamped_count = answer->clamped_count,
                               .masked_count = answer->masked_count};
    if (memcmp(&answer->header, header, sizeof *header) != 0 ||
        answer->payload_bytes != pixels_bytes + (image->masked_count ? pixel_count : 0))
        return vw_fail(VW_ERROR_IO, "the decoder gives pixels of another size than its header");
    image->pixels = pixels ? pixels : vw_allocate(pixels_bytes, 1);
    image->lent = pixels != NULL;
    image->unusable = image->masked_count ? vw_allocate(pixel_count, 1) : NULL;
    if (!image->pixels || (image->masked_count && !image->unusable)) return VW_ERROR_MEMORY;
    enum vw_status status = vw_decoder_receive(load->job, image->pixels, pixels_bytes);
    if (!status && image->unusable) status = vw_decoder_receive(load->job, image->unusable, pixel_count);
    return status ? status : check_pixels(image, pixel_count);
}

static enum vw_status finish_load(const struct vw_image_load *load, void *pixels, uint8_t *sha256,
                                  struct vw_image *image) {
    const char *path = load->file.path;
    struct vw_decoder_answer answer = {0};
    enum vw_status status = sha256 ? vw_sha256_descriptor(load->file.descriptor, path, sha256) : VW_OK;
    if (status) return status;
    status = vw_decoder_finish(load->job, &answer);
    bool refused = status == VW_ERROR_INPUT;
    if (!status) status = receive_pixels(load, &answer, pixels, image);
    if (!status) return VW_OK;
    struct vw_saved_error why = vw_error_save();
    return refused ? vw_fail(status, "%s: %s", path, why.message)
                   : vw_fail(status, "%s: cannot decode the image: %s; replace or remove it", path, why.message);
}

enum vw_status vw_image_load_finish(struct vw_image_load **load, void *pixels, uint8_t *sha256,
                                    struct vw_image *image) {
    struct vw_image loaded = {0};
    enum vw_status status = finish_load(*load, pixels, sha256, &loaded);
    if (status) vw_image_clear(&loaded);
    else *image = loaded;
    vw_image_load_cancel(load);
    return status;
}

enum vw_status vw_image_load(const char *path, uint32_t downscale, struct vw_image *image) {
    struct vw_image_header header;
    struct vw_image_load *load = NULL;
    vw_decoder_hold();
    enum vw_status status = vw_image_probe(path, VW_IMAGE_OF_PATH, &header);
    if (!status) status = vw_image_load_begin(path, VW_IMAGE_OF_PATH, &header, downscale, &load);
    if (!status) status = vw_image_load_finish(&load, NULL, NULL, image);
    vw_decoder_release();
    return status;
}

// ---- Writing --------------------------------------------------------------------------------------------------------

enum vw_status vw_image_encode(const struct vw_image_encoding *encoding, const float *pixels, void **data,
                               size_t *size_bytes) {
    struct vw_decoder_request request = {
        .task = VW_DECODER_WRITE_PHOTO,
        .photo_format = encoding->format,
        .header = {encoding->width_px, encoding->height_px, encoding->channels, VW_PIXEL_FLOAT32},
        .eight_bit = encoding->eight_bit};
    struct vw_decoder_job *job = NULL;
    struct vw_decoder_answer answer = {0};
    size_t pixels_bytes = (size_t)encoding->width_px * encoding->height_px * encoding->channels * sizeof(float);
    if (encoding->compression) strncpy(request.compression, encoding->compression, sizeof request.compression - 1);
    enum vw_status status = vw_decoder_begin(&request, -1, pixels, pixels_bytes, needed_bytes(&request.header), &job);
    if (!status) status = vw_decoder_finish(job, &answer);
    if (!status && answer.payload_bytes > DECODER_BYTES + 2 * pixels_bytes)
        status = vw_fail(VW_ERROR_IO, "the encoder gives too many bytes");
    void *file = status ? NULL : vw_allocate(answer.payload_bytes, 1);
    if (!status && !file) status = VW_ERROR_MEMORY;
    if (!status) status = vw_decoder_receive(job, file, answer.payload_bytes);
    vw_decoder_end(&job);
    if (status) {
        free(file);
        return status;
    }
    *data = file;
    *size_bytes = answer.payload_bytes;
    return VW_OK;
}

enum vw_status vw_image_encode_webp(uint32_t width_px, uint32_t height_px, const char *compression, const float *pixels,
                                    void **data, size_t *size_bytes) {
    struct vw_image_encoding encoding = {
        .width_px = width_px, .height_px = height_px, .channels = 3, .eight_bit = true, .compression = compression};
    return vw_photo_format_of_name("picture.webp", &encoding.format)
               ? vw_image_encode(&encoding, pixels, data, size_bytes)
               : vw_fail(VW_ERROR_IO, "WebP is not a format that is written");
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
    struct vw_image_encoding encoding = {.width_px = width_px, .height_px = height_px, .channels = channels};
    if (!vw_photo_format_of_name(path, &encoding.format))
        return vw_fail(VW_ERROR_USAGE, "%s: cannot write the image: unknown image format; use .png or .exr", path);
    const char *dot = strrchr(path, '.');
    bool linear = !strcasecmp(dot, ".exr");
    float *converted = NULL;
    void *file = NULL;
    size_t file_bytes = 0;
    encoding.eight_bit = !linear;
    if (linear) {
        converted = to_linear((size_t)width_px * height_px, channels, pixels);
        if (!converted) return VW_ERROR_MEMORY;
    }
    enum vw_status status = vw_image_encode(&encoding, linear ? converted : pixels, &file, &file_bytes);
    if (status) vw_fail_context(status, "%s: cannot write the image", path);
    else status = vw_file_write(path, file, file_bytes);
    free(file);
    free(converted);
    return status;
}

// ---- Thumbnails ----------------------------------------------------------------------------------------------------

// A thumbnail's pixel is the mean of this many samples along each axis, evenly spread over the photo pixels that it
// covers. So the time does not grow with the photo, and is a tenth of that of a proper filter.
enum { SEEN_PER_SIDE = 4, WIDEST = 4 };

// Returns the position of the `place`-th of `count` evenly spread samples along a side.
static uint32_t place_on(uint32_t side_px, uint64_t place, uint64_t count) {
    return (uint32_t)((2 * place + 1) * side_px / (2 * count));
}

static void average(const struct vw_image *image, const uint32_t small_px[2], uint32_t x_px, uint32_t y_px,
                    const float background[3], float *rgb) {
    float sum[3] = {0};
    for (uint32_t i = 0; i < SEEN_PER_SIDE * SEEN_PER_SIDE; i++) {
        uint64_t x = (uint64_t)x_px * SEEN_PER_SIDE + i % SEEN_PER_SIDE,
                 y = (uint64_t)y_px * SEEN_PER_SIDE + i / SEEN_PER_SIDE;
        float rgba[4];
        vw_image_pixel(image, place_on(image->width_px, x, (uint64_t)small_px[0] * SEEN_PER_SIDE),
                       place_on(image->height_px, y, (uint64_t)small_px[1] * SEEN_PER_SIDE), rgba);
        for (int c = 0; c < 3; c++) sum[c] += rgba[3] * rgba[c] + (1 - rgba[3]) * background[c];
    }
    for (int c = 0; c < 3; c++) rgb[c] = sum[c] / (SEEN_PER_SIDE * SEEN_PER_SIDE);
}

enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3],
                                       void **data, size_t *size_bytes) {
    uint32_t small_height_px = image->height_px < height_px ? image->height_px : height_px;
    uint64_t width_px = ((uint64_t)image->width_px * small_height_px + image->height_px / 2) / image->height_px;
    uint32_t widest_px = WIDEST * height_px, small_width_px = width_px < widest_px ? (uint32_t)width_px : widest_px;
    const uint32_t small_px[2] = {small_width_px ? small_width_px : 1, small_height_px};
    float *pixels = vw_allocate((size_t)small_px[0] * small_px[1], 3 * sizeof *pixels);
    if (!pixels) return VW_ERROR_MEMORY;
    for (uint32_t y = 0; y < small_px[1]; y++)
        for (uint32_t x = 0; x < small_px[0]; x++)
            average(image, small_px, x, y, background, pixels + 3 * ((size_t)y * small_px[0] + x));
    enum vw_status status = vw_image_encode_webp(small_px[0], small_px[1], "webp:70", pixels, data, size_bytes);
    free(pixels);
    return status ? vw_fail_context(status, "thumbnail") : VW_OK;
}

// ---- Pictures as texts ---------------------------------------------------------------------------------------------

char *vw_webp_to_text(const void *data, size_t size_bytes) {
    size_t text_bytes = sodium_base64_encoded_len(size_bytes, sodium_base64_VARIANT_ORIGINAL);
    char *text = vw_allocate(text_bytes, 1);
    return text ? sodium_bin2base64(text, text_bytes, data, size_bytes, sodium_base64_VARIANT_ORIGINAL) : NULL;
}

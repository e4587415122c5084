#include "fuzz/fuzz.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "image/decode/oiio_shim.h"
#include "image/decode/tasks.h"
#include "image/photo_formats.h"

enum { PIXELS_MOST = 1 << 20, CHANNELS_MOST = 64 };

#define CHECK(condition) fuzz_check(condition, #condition)

static void check_failure(const struct vw_decoder_answer *answer) {
    CHECK(memchr(answer->message, 0, sizeof answer->message) && *answer->message);
    CHECK(!strpbrk(answer->message, "\r\n"));
    CHECK(!answer->payload_bytes);
}

static void check_image(const struct vw_decoder_answer *answer, const struct vw_image *image) {
    size_t pixel_count = (size_t)image->width_px * image->height_px;
    CHECK(answer->payload_bytes ==
          pixel_count * (4 * vw_pixel_channel_bytes(image->format) + (image->unusable != NULL)));
    CHECK((image->unusable != NULL) == (image->masked_count > 0) && image->masked_count <= pixel_count);
    for (size_t i = 0; i < 4 * pixel_count; i++) {
        float value = vw_pixel_get(image->format, image->pixels, i);
        CHECK(value >= 0 && value <= 1);
    }
}

static void read_photo(struct vw_decoder_request *request, const uint8_t *data, size_t size_bytes) {
    struct vw_decoder_answer answer;
    struct vw_image image = {0};
    vw_task_read_photo(request, data, size_bytes, &answer, &image);
    if (answer.status) check_failure(&answer);
    else check_image(&answer, &image);
    vw_image_clear(&image);
}

// Tries a photo. The signature chooses the reader, as in the product; without one the first byte does, so that no
// reader is spared.
void fuzz_photo(const uint8_t *data, size_t size_bytes) {
    static bool prepared;
    struct vw_decoder_request request = {.downscale = 1};
    struct vw_decoder_answer answer;
    if (!prepared) {
        vw_oiio_prepare_server();
        prepared = vw_oiio_prepare_worker();
    }
    if (!vw_photo_format_of_bytes(data, size_bytes, &request.photo_format)) {
        if (size_bytes < 2) return;
        request.photo_format = *data % VW_PHOTO_FORMAT_COUNT;
        data++, size_bytes--;
    }
    vw_task_read_header(&request, data, size_bytes, &answer);
    if (answer.status) {
        check_failure(&answer);
        return;
    }
    request.header = answer.header;
    const struct vw_image_header *header = &request.header;
    CHECK(header->width_px && header->height_px && header->channels && header->format <= VW_PIXEL_FLOAT32);
    if (header->channels > CHANNELS_MOST || (uint64_t)header->width_px * header->height_px > PIXELS_MOST) return;
    read_photo(&request, data, size_bytes);
    request.downscale = 3;
    read_photo(&request, data, size_bytes);
    request.header.width_px++; // another file than at first
    vw_task_read_photo(&request, data, size_bytes, &answer, &(struct vw_image){0});
    CHECK(answer.status != VW_OK);
}

// The tasks of a worker: it turns the bytes of a file into an answer, and back. Fuzzers call these functions, too.
#ifndef VIEWWORTH_IMAGE_DECODE_TASKS_H
#define VIEWWORTH_IMAGE_DECODE_TASKS_H

#include <stddef.h>

#include "image/decoder_protocol.h"
#include "image/image.h"

void vw_task_read_header(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                         struct vw_decoder_answer *answer);
// Reads a photo. `*image` is owned by the caller (vw_image_clear), and unchanged after a failure.
void vw_task_read_photo(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                        struct vw_decoder_answer *answer, struct vw_image *image);
// Writes a photo. `pixels` has the size and channels of request->header. After VW_OK `*file` is owned by the caller
// (free) and has answer->payload_bytes.
void vw_task_write_photo(const struct vw_decoder_request *request, const float *pixels,
                         struct vw_decoder_answer *answer, void **file);

// Replaces the pixels by floor(size / factor), at least 1, along each axis; UINT16 for integer images. `factor` > 1.
// After a failure the image is unchanged.
enum vw_status vw_image_downscale(struct vw_image *image, uint32_t factor);

#endif

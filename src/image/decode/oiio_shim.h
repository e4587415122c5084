// The interface to OpenImageIO: plain C types, no exceptions. `plugin` is OpenImageIO's name of a format: no other
// reader is tried. Files are bytes in memory.
#ifndef VIEWWORTH_IMAGE_DECODE_OIIO_SHIM_H
#define VIEWWORTH_IMAGE_DECODE_OIIO_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image/pixel.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// The result of every call: after VW_OK the fields below, otherwise a one-line message without the file's name.
struct vw_oiio_result {
    enum vw_status status; // VW_ERROR_INPUT: the header cannot be used; VW_ERROR_IO: the pixels; VW_ERROR_MEMORY
    char message[400];
    struct vw_image_header header;
    int rgba_channel[4]; // indices of red, green, blue and alpha among the channels; alpha is -1 if there is none
    bool premultiplied;  // the stored colour is multiplied by alpha
    void *data; // malloc'ed; interleaved pixels of vw_oiio_read and _resize, the file's bytes of vw_oiio_encode
    size_t size_bytes;
};

// Switches off plug-ins from other places and registers the formats; call it first. It starts no thread: if one had a
// lock while a worker is forked, the lock would stay taken in the worker for ever.
void vw_oiio_prepare_server(void);
// Switches off OpenImageIO's threads, in the process that reads and writes; false if they do not end.
bool vw_oiio_prepare_worker(void);
struct vw_oiio_result vw_oiio_probe(const char *plugin, const void *file, size_t file_bytes); // header only, no data
struct vw_oiio_result vw_oiio_read(const char *plugin, const void *file, size_t file_bytes,
                                   const struct vw_image_header *expected); // VW_ERROR_IO if it has another header
// Filters RGBA floats to another size with a 3-lobed Lanczos filter.
struct vw_oiio_result vw_oiio_resize(const float *rgba, uint32_t width_px, uint32_t height_px, uint32_t new_width_px,
                                     uint32_t new_height_px);
// Encodes an image file. 8 bit with straight alpha if `eight_bit`, otherwise float with premultiplied alpha.
// `compression` is OpenImageIO's, for example "webp:70"; "": the format's default.
struct vw_oiio_result vw_oiio_encode(const char *plugin, const struct vw_image_header *header, bool eight_bit,
                                     const char *compression, const float *pixels);

#ifdef __cplusplus
}
#endif

#endif

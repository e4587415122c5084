// The interface to OpenImageIO: plain C types, no exceptions. Only src/image calls it, through oiio_module.c: without
// the module viewworth_oiio.so, every call fails with VW_ERROR_IO.
#ifndef VIEWWORTH_OIIO_SHIM_H
#define VIEWWORTH_OIIO_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// The result of every call: after VW_OK the fields below, otherwise a one-line message without the file's name.
struct vw_oiio_result {
    enum vw_status status; // VW_ERROR_INPUT: the header cannot be used; VW_ERROR_IO: the pixels; VW_ERROR_MEMORY
    char message[400];
    uint32_t width_px, height_px, channels;
    enum vw_pixel_format format;
    int rgba_channel[4]; // indices of red, green, blue and alpha among the channels; alpha is -1 if there is none
    bool premultiplied;  // the stored colour is multiplied by alpha
    void *data; // malloc'ed; interleaved pixels of vw_oiio_read and _resize, the file's bytes of vw_oiio_encode
    size_t size_bytes;
};

struct vw_oiio_result vw_oiio_probe(const char *path); // header only, no data
struct vw_oiio_result vw_oiio_read(const char *path);
// Filters RGBA floats to another size with a 3-lobed Lanczos filter.
struct vw_oiio_result vw_oiio_resize(const float *rgba, uint32_t width_px, uint32_t height_px, uint32_t new_width_px,
                                     uint32_t new_height_px);
// The bytes of an image file; the extension of `path` names the format. 8 bit with straight alpha if `eight_bit`,
// otherwise float with premultiplied alpha. `compression` is OpenImageIO's, for example "webp:70"; NULL: the format's
// default.
struct vw_oiio_result vw_oiio_encode(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                                     bool eight_bit, const char *compression, const float *pixels);

#ifdef __cplusplus
}
#endif

#endif

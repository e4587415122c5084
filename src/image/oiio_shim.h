// The border to OpenImageIO: plain C types in and out, no exception passes. Only image.c and its neighbours call it, by
// way of oiio_module.c: without the module viewworth_oiio.so every call is VW_ERROR_IO and says so.
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

// What every call returns: on VW_OK the fields below, else a one-line message without the file's name.
struct vw_oiio_result {
    enum vw_status status; // VW_ERROR_INPUT: the header cannot be used; VW_ERROR_IO: the pixels; VW_ERROR_MEMORY
    char message[400];
    uint32_t width_px, height_px, channels;
    enum vw_pixel_format format;
    int rgba_channel[4]; // where red, green, blue and alpha lie among the channels; alpha is -1 when there is none
    bool premultiplied;  // colour is stored times alpha
    void *data; // malloc'ed; interleaved pixels of vw_oiio_read and _resize, the file's bytes of vw_oiio_encode
    size_t size_bytes;
};

struct vw_oiio_result vw_oiio_probe(const char *path); // header only, no data
struct vw_oiio_result vw_oiio_read(const char *path);
// Filters RGBA floats to another size with a 3-lobed Lanczos filter.
struct vw_oiio_result vw_oiio_resize(const float *rgba, uint32_t width_px, uint32_t height_px, uint32_t new_width_px,
                                     uint32_t new_height_px);
// The bytes of an image file of the kind that `path`'s extension names: 8 bit where `eight_bit`, else float. Alpha is
// straight where `eight_bit`, premultiplied otherwise. `compression` is OpenImageIO's, such as "webp:70"; NULL leaves
// it to the format.
struct vw_oiio_result vw_oiio_encode(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                                     bool eight_bit, const char *compression, const float *pixels);

#ifdef __cplusplus
}
#endif

#endif

// The formats of photos that are read and written. A file's first bytes choose the format, never its name; nothing else
// reaches OpenImageIO, which has readers for 50 formats and tries one after the other.
#ifndef VIEWWORTH_IMAGE_PHOTO_FORMATS_H
#define VIEWWORTH_IMAGE_PHOTO_FORMATS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct vw_photo_format {
    const char *name;                // as a message calls it
    const char *plugin;              // OpenImageIO's name of the reader and writer
    const char *const extensions[4]; // under which it is written, without the dot; up to the first NULL
    struct {
        const char *bytes; // the file begins with these
        size_t count;      // 0: the end of the list
        const char *at_8;  // and has these four after eight bytes; NULL: any
    } signatures[9];
};

enum { VW_PHOTO_FORMAT_COUNT = 8, VW_PHOTO_SIGNATURE_BYTES = 12 };
#define VW_PHOTO_FORMAT_NAMES "PNG, JPEG, TIFF, OpenEXR, WebP, JPEG 2000, Radiance HDR and PNM"
extern const struct vw_photo_format vw_photo_formats[VW_PHOTO_FORMAT_COUNT];

// Finds the format of a file with these first bytes (VW_PHOTO_SIGNATURE_BYTES are enough for any), as an index; false:
// none.
bool vw_photo_format_of_bytes(const void *bytes, size_t count, uint32_t *format);
// Finds the format to write under a file name; false: none.
bool vw_photo_format_of_name(const char *name, uint32_t *format);

#endif

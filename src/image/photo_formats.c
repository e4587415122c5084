#include "image/photo_formats.h"

#include <string.h>
#include <strings.h>

const struct vw_photo_format vw_photo_formats[VW_PHOTO_FORMAT_COUNT] = {
    {"PNG", "png", {"png"}, {{"\x89PNG\r\n\x1a\n", 8, NULL}}},
    {"JPEG", "jpeg", {"jpg", "jpeg"}, {{"\xff\xd8\xff", 3, NULL}}},
    {"TIFF", // little- and big-endian; BigTIFF
     "tiff",
     {NULL},
     {{"II*\0", 4, NULL}, {"MM\0*", 4, NULL}, {"II+\0", 4, NULL}, {"MM\0+", 4, NULL}}},
    {"OpenEXR", "openexr", {"exr"}, {{"\x76\x2f\x31\x01", 4, NULL}}},
    {"WebP", "webp", {"webp"}, {{"RIFF", 4, "WEBP"}}},
    {"JPEG 2000", // a JP2 file, or a bare codestream
     "jpeg2000",
     {NULL},
     {{"\0\0\0\x0cjP  \r\n\x87\n", 12, NULL}, {"\xff\x4f\xff\x51", 4, NULL}}},
    {"Radiance HDR", "hdr", {NULL}, {{"#?RADIANCE", 10, NULL}, {"#?RGBE", 6, NULL}}},
    {"PNM",
     "pnm",
     {NULL},
     {{"P1", 2, NULL},
      {"P2", 2, NULL},
      {"P3", 2, NULL},
      {"P4", 2, NULL},
      {"P5", 2, NULL},
      {"P6", 2, NULL},
      {"PF", 2, NULL},
      {"Pf", 2, NULL}}},
};

static bool begins_as(const struct vw_photo_format *format, const char *bytes, size_t count) {
    for (size_t i = 0; format->signatures[i].count; i++) {
        const char *at_8 = format->signatures[i].at_8;
        if (count < format->signatures[i].count || (at_8 && count < 12)) continue;
        if (!memcmp(bytes, format->signatures[i].bytes, format->signatures[i].count) &&
            (!at_8 || !memcmp(bytes + 8, at_8, 4)))
            return true;
    }
    return false;
}

bool vw_photo_format_of_bytes(const void *bytes, size_t count, uint32_t *format) {
    for (uint32_t i = 0; i < VW_PHOTO_FORMAT_COUNT; i++) {
        if (!begins_as(&vw_photo_formats[i], bytes, count)) continue;
        *format = i;
        return true;
    }
    return false;
}

bool vw_photo_format_of_name(const char *name, uint32_t *format) {
    const char *dot = strrchr(name, '.');
    for (uint32_t i = 0; dot && i < VW_PHOTO_FORMAT_COUNT; i++) {
        for (const char *const *extension = vw_photo_formats[i].extensions; *extension; extension++) {
            if (strcasecmp(dot + 1, *extension) != 0) continue;
            *format = i;
            return true;
        }
    }
    return false;
}

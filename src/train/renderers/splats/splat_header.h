// The header of a .ply file of splats: where in a row the numbers of a splat are.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLAT_HEADER_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLAT_HEADER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

enum { VW_SPLAT_FIELDS = 14, VW_SPLAT_RESTS = 45, VW_SPLAT_NUMBERS = VW_SPLAT_FIELDS + VW_SPLAT_RESTS };

struct vw_splat_property {
    bool present, is_double;
    uint32_t offset_bytes; // in a row
};

struct vw_splat_header {
    uint64_t count;
    uint32_t row_bytes, degree;
    bool antialiased;
    size_t size_bytes; // rows follow
    struct vw_splat_property properties[VW_SPLAT_NUMBERS];
};

// Returns the name of a number: the fields of every splat, then f_rest_0 and so on.
const char *vw_splat_property_name(uint32_t number, char name[20]);
// Returns where params have it, with harmonics of a degree: 4 * column + lane.
uint32_t vw_splat_property_place(uint32_t number, uint32_t degree);
// Reads a header. VW_ERROR_INPUT names the line and the remedy; `path` is for messages.
enum vw_status vw_splat_header_read(const char *path, const char *data, size_t size_bytes,
                                    struct vw_splat_header *header);

#endif

#include "train/renderers/splats/splat_header.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "interface.h"

enum { LINE_BYTES = 512, HEADER_BYTES_MOST = 1 << 16, ROW_BYTES_MOST = 4096 };

static const char rewrite[] = "write it again as binary little-endian .ply of splats, for example by splat-transform";

static const struct {
    const char *name;
    uint32_t place; // 4 * column + lane
} fields[VW_SPLAT_FIELDS] = {
    {"x", 4 * SPLAT_MEAN},
    {"y", 4 * SPLAT_MEAN + 1},
    {"z", 4 * SPLAT_MEAN + 2},
    {"opacity", 4 * SPLAT_MEAN + 3},
    {"scale_0", 4 * SPLAT_SCALE},
    {"scale_1", 4 * SPLAT_SCALE + 1},
    {"scale_2", 4 * SPLAT_SCALE + 2},
    {"rot_0", 4 * SPLAT_TURN},
    {"rot_1", 4 * SPLAT_TURN + 1},
    {"rot_2", 4 * SPLAT_TURN + 2},
    {"rot_3", 4 * SPLAT_TURN + 3},
    {"f_dc_0", 4 * SPLAT_HARMONICS},
    {"f_dc_1", 4 * SPLAT_HARMONICS + 1},
    {"f_dc_2", 4 * SPLAT_HARMONICS + 2},
};

const char *vw_splat_property_name(uint32_t number, char name[20]) {
    if (number < VW_SPLAT_FIELDS) return fields[number].name;
    snprintf(name, 20, "f_rest_%" PRIu32, number - VW_SPLAT_FIELDS);
    return name;
}

static uint32_t rests_of(uint32_t degree) { return (degree + 1) * (degree + 1) - 1; } // per channel

uint32_t vw_splat_property_place(uint32_t number, uint32_t degree) {
    if (number < VW_SPLAT_FIELDS) return fields[number].place;
    uint32_t rest = number - VW_SPLAT_FIELDS, each = rests_of(degree);
    return 4 * (SPLAT_HARMONICS + 1 + rest % each) + rest / each;
}

// ---- Lines ----------------------------------------------------------------------------------------------------------

struct lines {
    const char *path, *at, *end;
    uint32_t number;
    char text[LINE_BYTES];
};

static enum vw_status refuse(const struct lines *lines, const char *what) {
    return vw_fail(VW_ERROR_INPUT, "%s:%" PRIu32 ": \"%.60s\" %s", lines->path, lines->number, lines->text, what);
}

static enum vw_status next_line(struct lines *lines) {
    size_t left = (size_t)(lines->end - lines->at);
    const char *end = left ? memchr(lines->at, '\n', left) : NULL;
    lines->number++;
    if (!end)
        return vw_fail(VW_ERROR_INPUT, "%s:%" PRIu32 ": the header has no end_header; %s", lines->path, lines->number,
                       rewrite);
    size_t length = (size_t)(end - lines->at);
    if (length && lines->at[length - 1] == '\r') length--;
    snprintf(lines->text, sizeof lines->text, "%.*s", (int)(length < LINE_BYTES ? length : LINE_BYTES - 1), lines->at);
    if (length >= LINE_BYTES || strlen(lines->text) != length)
        return refuse(lines, "and so on is not a line of a header; is this a .ply file?");
    lines->at = end + 1;
    return VW_OK;
}

// Returns what follows a first word and a space; NULL when the line has another one.
static const char *after(const struct lines *lines, const char *word) {
    size_t length = strlen(word);
    return !strncmp(lines->text, word, length) && lines->text[length] == ' ' ? lines->text + length + 1 : NULL;
}

// ---- Properties -----------------------------------------------------------------------------------------------------

static uint32_t size_of_type(const char *type) {
    static const struct {
        const char *name;
        uint32_t bytes;
    } types[] = {{"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
                 {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
                 {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(types); i++)
        if (!strcmp(type, types[i].name)) return types[i].bytes;
    return 0;
}

static struct vw_splat_property *find_property(struct vw_splat_header *header, const char *name) {
    char known[20];
    for (uint32_t i = 0; i < VW_SPLAT_NUMBERS; i++)
        if (!strcmp(name, vw_splat_property_name(i, known))) return &header->properties[i];
    return NULL;
}

static enum vw_status take_property(const struct lines *lines, const char *rest, struct vw_splat_header *header) {
    char type[32], name[64], more;
    int words = sscanf(rest, "%31s %63s %c", type, name, &more);
    uint32_t bytes = words == 2 ? size_of_type(type) : 0;
    if (!bytes) return refuse(lines, "is not a property of one number; write it again without it");
    bool real = !strcmp(type, "float") || !strcmp(type, "float32") || bytes == 8;
    struct vw_splat_property *property = find_property(header, name);
    if (property && !real) return refuse(lines, "is not a property of floats; write it again with float");
    if (property && property->present) return refuse(lines, "is there twice; leave one out");
    if (!property && !strncmp(name, "f_rest_", 7))
        return refuse(lines, "is of harmonics above degree 3; write it again with degree 3 at most");
    if (property)
        *property =
            (struct vw_splat_property){.present = true, .is_double = bytes == 8, .offset_bytes = header->row_bytes};
    header->row_bytes += bytes;
    return header->row_bytes <= ROW_BYTES_MOST ? VW_OK
                                               : refuse(lines, "makes rows of more than 4096 bytes; leave some out");
}

static enum vw_status take_element(const struct lines *lines, const char *rest, bool first,
                                   struct vw_splat_header *header) {
    char name[64] = "", more;
    int words = sscanf(rest, "%63s %" SCNu64 " %c", name, &header->count, &more);
    if (first && !strcmp(name, "chunk"))
        return refuse(lines, "begins a compressed .ply; decompress it, for example by splat-transform IN.ply OUT.ply");
    if (words != 2 || strchr(rest, '-')) return refuse(lines, "is not an element with its number of rows");
    if (strcmp(name, "vertex")) return refuse(lines, "comes before element vertex, which must be the first");
    return VW_OK;
}

static bool says_antialiased(const char *comment) {
    return !strcmp(comment, "SplatRenderMode: mip") || !strcmp(comment, "antialiased 1");
}

// Reads the lines between the format and end_header. Elements after the splats are left alone.
static enum vw_status read_lines(struct lines *lines, struct vw_splat_header *header) {
    uint32_t elements = 0;
    enum vw_status status = next_line(lines);
    for (; !status && strcmp(lines->text, "end_header"); status = status ? status : next_line(lines)) {
        const char *rest;
        if ((rest = after(lines, "comment"))) header->antialiased |= says_antialiased(rest);
        else if ((rest = after(lines, "element")))
            status = elements++ ? VW_OK : take_element(lines, rest, true, header);
        else if ((rest = after(lines, "property")))
            status = elements == 1 ? take_property(lines, rest, header)
                     : elements    ? VW_OK
                                   : refuse(lines, "comes before element vertex");
        else if (strcmp(lines->text, "comment") && !after(lines, "obj_info"))
            status = refuse(lines, "is not a line of a header; is this a .ply file of splats?");
    }
    if (!status && !elements) status = refuse(lines, "comes before element vertex: there are no splats");
    return status;
}

static enum vw_status check_properties(const char *path, struct vw_splat_header *header) {
    uint32_t rests = 0;
    char name[20];
    for (uint32_t i = 0; i < VW_SPLAT_FIELDS; i++)
        if (!header->properties[i].present)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: element vertex lacks property %s of splats; name a .ply "
                           "of splats",
                           path, fields[i].name);
    for (uint32_t i = 0; i < VW_SPLAT_RESTS; i++) rests += header->properties[VW_SPLAT_FIELDS + i].present;
    while (header->degree < VW_SPLAT_DEGREE_MAX && 3 * rests_of(header->degree) < rests) header->degree++;
    for (uint32_t i = 0; i < 3 * rests_of(header->degree); i++)
        if (!header->properties[VW_SPLAT_FIELDS + i].present)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: element vertex has no property %s: f_rest_* are 0, 9, 24 or 45, by the degree of the "
                           "harmonics; write them all",
                           path, vw_splat_property_name(VW_SPLAT_FIELDS + i, name));
    return VW_OK;
}

enum vw_status vw_splat_header_read(const char *path, const char *data, size_t size_bytes,
                                    struct vw_splat_header *header) {
    size_t limit = size_bytes < HEADER_BYTES_MOST ? size_bytes : HEADER_BYTES_MOST;
    struct lines lines = {.path = path, .at = data, .end = data + limit};
    *header = (struct vw_splat_header){0};
    enum vw_status status = next_line(&lines);
    if (status || strcmp(lines.text, "ply"))
        return vw_fail(VW_ERROR_INPUT, "%s: does not begin with the line ply; name a .ply file of splats", path);
    status = next_line(&lines);
    if (!status && strcmp(lines.text, "format binary_little_endian 1.0")) {
        char what[160];
        snprintf(what, sizeof what, "is not the format that is read; %s", rewrite);
        status = refuse(&lines, what);
    }
    if (!status) status = read_lines(&lines, header);
    if (!status) status = check_properties(path, header);
    header->size_bytes = (size_t)(lines.at - data);
    return status;
}

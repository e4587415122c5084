#include "train/renderers/splats/splat_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/text.h"
#include "interface.h"
#include "viewworth/log.h"

// ---- The header -----------------------------------------------------------------------------------------------------

// The numbers of a splat: fields that each has, then f_rest_0 and so on.
enum { FIELDS = 14, RESTS = 45, NUMBERS = FIELDS + RESTS };

struct property {
    bool present, is_double;
    uint32_t offset_bytes; // in a row
};

struct header {
    uint64_t count;
    uint32_t row_bytes, degree;
    bool antialiased;
    size_t size_bytes; // rows follow
    struct property properties[NUMBERS];
};

enum { LINE_BYTES = 512, HEADER_READ_MOST = 1 << 16, ROW_BYTES_MOST = 4096 };

static const char rewrite[] = "write it again as binary little-endian .ply of splats, for example by splat-transform";

static const struct {
    const char *name;
    uint32_t place; // 4 * column + lane
} fields[FIELDS] = {
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

// Returns the name of a number.
static const char *property_name(uint32_t number, char name[20]) {
    if (number < FIELDS) return fields[number].name;
    snprintf(name, 20, "f_rest_%" PRIu32, number - FIELDS);
    return name;
}

static uint32_t rests_of(uint32_t degree) { return (degree + 1) * (degree + 1) - 1; } // per channel

// Returns where params have it, with harmonics of a degree: 4 * column + lane.
static uint32_t property_place(uint32_t number, uint32_t degree) {
    if (number < FIELDS) return fields[number].place;
    uint32_t rest = number - FIELDS, each = rests_of(degree);
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

static struct property *find_property(struct header *header, const char *name) {
    char known[20];
    for (uint32_t i = 0; i < NUMBERS; i++)
        if (!strcmp(name, property_name(i, known))) return &header->properties[i];
    return NULL;
}

static enum vw_status take_property(const struct lines *lines, const char *rest, struct header *header) {
    char type[32], name[64], more;
    int words = sscanf(rest, "%31s %63s %c", type, name, &more);
    uint32_t bytes = words == 2 ? size_of_type(type) : 0;
    if (!bytes) return refuse(lines, "is not a property of one number; write it again without it");
    bool real = !strcmp(type, "float") || !strcmp(type, "float32") || bytes == 8;
    struct property *property = find_property(header, name);
    if (property && !real) return refuse(lines, "is not a property of floats; write it again with float");
    if (property && property->present) return refuse(lines, "is there twice; leave one out");
    if (!property && !strncmp(name, "f_rest_", 7))
        return refuse(lines, "is of harmonics above degree 3; write it again with degree 3 at most");
    if (property)
        *property = (struct property){.present = true, .is_double = bytes == 8, .offset_bytes = header->row_bytes};
    header->row_bytes += bytes;
    return header->row_bytes <= ROW_BYTES_MOST ? VW_OK
                                               : refuse(lines, "makes rows of more than 4096 bytes; leave some out");
}

static enum vw_status take_element(const struct lines *lines, const char *rest, bool first, struct header *header) {
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
static enum vw_status read_lines(struct lines *lines, struct header *header) {
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

static enum vw_status check_properties(const char *path, struct header *header) {
    uint32_t rests = 0;
    char name[20];
    for (uint32_t i = 0; i < FIELDS; i++)
        if (!header->properties[i].present)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: element vertex lacks property %s of splats; name a .ply "
                           "of splats",
                           path, fields[i].name);
    for (uint32_t i = 0; i < RESTS; i++) rests += header->properties[FIELDS + i].present;
    while (header->degree < VW_SPLAT_DEGREE_MAX && 3 * rests_of(header->degree) < rests) header->degree++;
    for (uint32_t i = 0; i < 3 * rests_of(header->degree); i++)
        if (!header->properties[FIELDS + i].present)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: element vertex has no property %s: f_rest_* are 0, 9, 24 or 45, by the degree of the "
                           "harmonics; write them all",
                           path, property_name(FIELDS + i, name));
    return VW_OK;
}

// Reads a header. VW_ERROR_INPUT names the line and the remedy; `path` is for messages.
static enum vw_status read_header(const char *path, const char *data, size_t size_bytes, struct header *header) {
    size_t limit = size_bytes < HEADER_READ_MOST ? size_bytes : HEADER_READ_MOST;
    struct lines lines = {.path = path, .at = data, .end = data + limit};
    *header = (struct header){0};
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

// ---- The file -------------------------------------------------------------------------------------------------------

enum { SPLATS_MOST = 1 << 20, HEADER_WRITTEN_MOST = 4096, NORMALS = 3 };

static const size_t FILE_BYTES_MOST = (size_t)1 << 30;
static const float COLOUR_MOST = 1e6f; // sums of harmonics stay finite, and so do pixels that a splat does not reach
static const double TURN_LEAST = 1e-12, TURN_MOST = 1e15; // squared norms of quaternions that turn: projection.glsl

// ---- Reading --------------------------------------------------------------------------------------------------------

static float number_at(const char *row, const struct property *property) {
    float single;
    double number;
    if (property->is_double) {
        memcpy(&number, row + property->offset_bytes, sizeof number);
        return fabs(number) <= 3.4e38 ? (float)number : NAN;
    }
    memcpy(&single, row + property->offset_bytes, sizeof single);
    return single;
}

static enum vw_status read_splat(const char *path, const char *row, const struct header *header, uint32_t splat,
                                 struct vw_splat_file *file) {
    char name[20];
    double turn2 = 0.0;
    for (uint32_t i = 0; i < NUMBERS; i++) {
        if (!header->properties[i].present) continue;
        uint32_t place = property_place(i, header->degree);
        float number = number_at(row, &header->properties[i]);
        if (!isfinite(number))
            return vw_fail(VW_ERROR_INPUT,
                           "%s: splat %" PRIu32 ": %s is not finite; filter such splats, for example by "
                           "splat-transform -N",
                           path, splat, property_name(i, name));
        if (place / 4 >= SPLAT_HARMONICS && fabsf(number) > COLOUR_MOST)
            return vw_fail(VW_ERROR_INPUT, "%s: splat %" PRIu32 ": %s is %g, beyond all colours; remove such splats",
                           path, splat, property_name(i, name), (double)number);
        file->params[4 * ((size_t)(place / 4) * file->count + splat) + place % 4] = number;
        if (place / 4 == SPLAT_TURN) turn2 += (double)number * (double)number;
    }
    if (turn2 >= TURN_LEAST && turn2 <= TURN_MOST) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: splat %" PRIu32
                   ": rot_* is a quaternion of length %g, which turns nothing; filter such splats, "
                   "for example by splat-transform -N",
                   path, splat, sqrt(turn2));
}

// Says whether all harmonics of the highest degree are 0, as importers want them that know degree 3 alone.
static bool is_padded(const struct vw_splat_file *file) {
    size_t column = 4 * (size_t)file->count, end = VW_SPLAT_COLUMNS(file->degree) * column;
    for (size_t i = VW_SPLAT_COLUMNS(file->degree - 1) * column; i < end; i++)
        if (file->params[i] != 0.0f) return false;
    return true;
}

static enum vw_status read_splats(const char *path, const char *data, size_t size_bytes, uint32_t splats_most,
                                  struct vw_splat_file *file) {
    struct header header;
    enum vw_status status = read_header(path, data, size_bytes, &header);
    if (status) return status;
    if (!header.count || header.count > splats_most)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: has %" PRIu64 " splats; from 1 to %" PRIu32 " can be read; reduce it, for example by "
                       "splat-transform --decimate",
                       path, header.count, splats_most);
    uint64_t there = (size_bytes - header.size_bytes) / header.row_bytes;
    if (there < header.count)
        return vw_fail(VW_ERROR_INPUT, "%s: has only %" PRIu64 " of %" PRIu64 " splats: it was cut; copy it again",
                       path, there, header.count);
    *file = (struct vw_splat_file){
        .count = (uint32_t)header.count, .degree = header.degree, .antialiased = header.antialiased};
    file->params = vw_allocate((size_t)4 * VW_SPLAT_COLUMNS(file->degree) * file->count, sizeof *file->params);
    if (!file->params) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < file->count && !status; i++)
        status = read_splat(path, data + header.size_bytes + (size_t)i * header.row_bytes, &header, i, file);
    while (!status && file->degree && is_padded(file)) file->degree--;
    return status;
}

enum vw_status vw_splat_file_read(const char *path, uint32_t splats_most, struct vw_splat_file *file) {
    void *data = NULL;
    size_t size_bytes = 0;
    uint8_t hash[VW_HASH_BYTES];
    *file = (struct vw_splat_file){0};
    enum vw_status status = vw_file_read(path, FILE_BYTES_MOST, &data, &size_bytes);
    if (!status) status = read_splats(path, data, size_bytes, splats_most, file);
    if (!status) vw_sha256(data, size_bytes, hash);
    if (!status) vw_hash_to_hex(hash, file->sha256);
    free(data);
    return status;
}

void vw_splat_file_free(struct vw_splat_file *file) {
    free(file->params);
    *file = (struct vw_splat_file){0};
}

// ---- Box and world --------------------------------------------------------------------------------------------------

static double edge_of(const struct vw_box *box) { return 2.0 * box->half_extent_world; }

enum vw_status vw_splat_file_place(const struct vw_splat_file *file, const char *path, uint32_t degree,
                                   const struct vw_box *box, float *params) {
    size_t column = 4 * (size_t)file->count;
    double edge = edge_of(box);
    memcpy(params, file->params, VW_SPLAT_COLUMNS(file->degree < degree ? file->degree : degree) * column * 4);
    for (size_t splat = 0; splat < file->count; splat++) {
        float *mean = params + SPLAT_MEAN * column + 4 * splat, *scale = params + SPLAT_SCALE * column + 4 * splat;
        for (int i = 0; i < 3; i++) {
            double at = ((double)mean[i] - box->centre_world[i]) / edge + 0.5;
            if (!(fabs(at) <= 1e30))
                return vw_fail(VW_ERROR_INPUT,
                               "%s: splat %zu: lies %g box edges from the scene; name a file of this scene", path,
                               splat, fabs(at));
            mean[i] = (float)at;
            scale[i] = (float)((double)scale[i] - log(edge));
        }
    }
    return VW_OK;
}

// ---- Writing --------------------------------------------------------------------------------------------------------

static size_t write_header(char header[HEADER_WRITTEN_MOST], uint32_t count, uint32_t rests) {
    static const char *const before[] = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
    static const char *const after[] = {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"};
    size_t at = (size_t)snprintf(header, HEADER_WRITTEN_MOST,
                                 "ply\nformat binary_little_endian 1.0\ncomment made by viewworth\n"
                                 "comment SplatRenderMode: default\nelement vertex %" PRIu32 "\n",
                                 count);
    for (size_t i = 0; i < VW_ARRAY_COUNT(before); i++)
        at += (size_t)snprintf(header + at, HEADER_WRITTEN_MOST - at, "property float %s\n", before[i]);
    for (uint32_t i = 0; i < rests; i++)
        at += (size_t)snprintf(header + at, HEADER_WRITTEN_MOST - at, "property float f_rest_%" PRIu32 "\n", i);
    for (size_t i = 0; i < VW_ARRAY_COUNT(after); i++)
        at += (size_t)snprintf(header + at, HEADER_WRITTEN_MOST - at, "property float %s\n", after[i]);
    return at + (size_t)snprintf(header + at, HEADER_WRITTEN_MOST - at, "end_header\n");
}

// Writes the numbers of a row, all of them but normals, which stay 0.
static void write_row(const float *params, uint32_t count, uint32_t degree, uint32_t written, const struct vw_box *box,
                      uint32_t splat, float *row) {
    enum { X = 0, OPACITY = 3, SCALE = 4, TURN = 7, CONSTANT = 11 }; // places in the table of fields
    uint32_t rests = 3 * rests_of(written);
    for (uint32_t i = 0; i < FIELDS + rests; i++) {
        uint32_t place = property_place(i, written);
        bool known = place / 4 < VW_SPLAT_COLUMNS(degree);
        double number = known ? (double)params[4 * ((size_t)(place / 4) * count + splat) + place % 4] : 0.0;
        if (i < OPACITY) {
            row[i] = (float)((number - 0.5) * edge_of(box) + box->centre_world[i]);
        } else if (i == OPACITY) {
            row[9 + rests] = (float)number;
        } else if (i < TURN) {
            double filter = (double)params[4 * ((size_t)SPLAT_SCALE * count + splat) + 3];
            row[10 + rests + i - SCALE] = (float)(0.5 * log(exp(2.0 * number) + filter) + log(edge_of(box)));
        } else if (i < CONSTANT) {
            row[13 + rests + i - TURN] = (float)number;
        } else if (i < FIELDS) {
            row[3 + NORMALS + i - CONSTANT] = (float)number;
        } else {
            row[9 + i - FIELDS] = (float)number;
        }
    }
}

enum vw_status vw_splat_file_make(const float *params, uint32_t count, uint32_t degree, uint32_t least,
                                  const struct vw_box *box, void **data, size_t *size_bytes) {
    char header[HEADER_WRITTEN_MOST];
    uint32_t written = degree > least ? degree : least, rests = 3 * rests_of(written),
             numbers = FIELDS + NORMALS + rests;
    size_t header_bytes = write_header(header, count, rests), row_bytes = numbers * sizeof(float);
    char *bytes = vw_allocate(header_bytes + row_bytes * count, 1);
    if (!bytes) return VW_ERROR_MEMORY;
    memcpy(bytes, header, header_bytes);
    for (uint32_t splat = 0; splat < count; splat++) {
        float row[NUMBERS + NORMALS] = {0};
        write_row(params, count, degree, written, box, splat, row);
        memcpy(bytes + header_bytes + row_bytes * splat, row, row_bytes);
    }
    *data = bytes;
    *size_bytes = header_bytes + row_bytes * count;
    return VW_OK;
}

// ---- The file that a run begins from --------------------------------------------------------------------------------

static enum vw_status check_hash(const char *path, const struct vw_splat_file *file, const char *sha256) {
    if (!strcmp(file->sha256, sha256)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: is not the file that the run begins from, whose SHA-256 is %s; restore it",
                   path, sha256);
}

static enum vw_status check_file(const char *path, const struct vw_splat_file *file, const struct vw_config *config) {
    if (config->initial_sha256[0] && check_hash(path, file, config->initial_sha256)) return VW_ERROR_INPUT;
    if (file->degree > config->harmonics)
        return vw_fail(VW_ERROR_USAGE,
                       "--initial %s: has harmonics of degree %" PRIu32 "; train with --harmonics %" PRIu32, path,
                       file->degree, file->degree);
    if (config->splats && file->count > config->splats)
        return vw_fail(VW_ERROR_USAGE,
                       "--initial %s: has %" PRIu32 " splats, more than --splats %" PRIu32 "; leave --splats out", path,
                       file->count, config->splats);
    if (file->antialiased)
        vw_log_warning("--initial %s: was made to be drawn anti-aliased, as this program does not: small splats are "
                       "brighter at first",
                       path);
    return VW_OK;
}

enum vw_status vw_splats_begin_from(const char *path, struct vw_config *config) {
    struct vw_splat_file file = {0};
    if (config->field != VW_FIELD_SPLATS) return vw_fail(VW_ERROR_USAGE, "--initial: needs --field splats");
    char *full = realpath(path, NULL);
    enum vw_status status = VW_OK;
    if (full && (strlen(full) >= sizeof config->initial || !vw_text_is_clean(full)))
        status = vw_fail(VW_ERROR_USAGE,
                         "--initial %s: its full path is too long, or has characters that cannot be "
                         "shown; rename it",
                         path);
    if (!status) status = vw_splat_file_read(path, SPLATS_MOST, &file);
    if (!status) status = check_file(path, &file, config);
    if (!status) {
        snprintf(config->initial, sizeof config->initial, "%s", full ? full : path);
        snprintf(config->initial_sha256, sizeof config->initial_sha256, "%s", file.sha256);
        config->splats = file.count;
    }
    vw_splat_file_free(&file);
    free(full);
    return status;
}

enum vw_status vw_splats_read_initial(const char *path, const char *sha256, struct vw_splat_file *file) {
    enum vw_status status = vw_splat_file_read(path, SPLATS_MOST, file);
    return status ? status : check_hash(path, file, sha256);
}

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
#include "train/renderers/splats/splat_header.h"
#include "viewworth/log.h"

enum { SPLATS_MOST = 1 << 20, HEADER_BYTES_MOST = 4096, NORMALS = 3 };

static const size_t FILE_BYTES_MOST = (size_t)1 << 30;
static const float COLOUR_MOST = 1e6f; // sums of harmonics stay finite, and so do pixels that a splat does not reach
static const double TURN_LEAST = 1e-12, TURN_MOST = 1e15; // squared norms of quaternions that turn: projection.glsl

// ---- Reading --------------------------------------------------------------------------------------------------------

static float number_at(const char *row, const struct vw_splat_property *property) {
    float single;
    double number;
    if (property->is_double) {
        memcpy(&number, row + property->offset_bytes, sizeof number);
        return fabs(number) <= 3.4e38 ? (float)number : NAN;
    }
    memcpy(&single, row + property->offset_bytes, sizeof single);
    return single;
}

static enum vw_status read_splat(const char *path, const char *row, const struct vw_splat_header *header,
                                 uint32_t splat, struct vw_splat_file *file) {
    char name[20];
    double turn2 = 0.0;
    for (uint32_t i = 0; i < VW_SPLAT_NUMBERS; i++) {
        if (!header->properties[i].present) continue;
        uint32_t place = vw_splat_property_place(i, header->degree);
        float number = number_at(row, &header->properties[i]);
        if (!isfinite(number))
            return vw_fail(VW_ERROR_INPUT,
                           "%s: splat %" PRIu32 ": %s is not finite; filter such splats, for example by "
                           "splat-transform -N",
                           path, splat, vw_splat_property_name(i, name));
        if (place / 4 >= SPLAT_HARMONICS && fabsf(number) > COLOUR_MOST)
            return vw_fail(VW_ERROR_INPUT, "%s: splat %" PRIu32 ": %s is %g, beyond all colours; remove such splats",
                           path, splat, vw_splat_property_name(i, name), (double)number);
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

static enum vw_status read_splats(const char *path, const char *data, size_t size_bytes, uint32_t splats_most,
                                  struct vw_splat_file *file) {
    struct vw_splat_header header;
    enum vw_status status = vw_splat_header_read(path, data, size_bytes, &header);
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

static size_t write_header(char header[HEADER_BYTES_MOST], uint32_t count, uint32_t rests) {
    static const char *const before[] = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
    static const char *const after[] = {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"};
    size_t at = (size_t)snprintf(header, HEADER_BYTES_MOST,
                                 "ply\nformat binary_little_endian 1.0\ncomment made by viewworth\n"
                                 "comment SplatRenderMode: default\nelement vertex %" PRIu32 "\n",
                                 count);
    for (size_t i = 0; i < VW_ARRAY_COUNT(before); i++)
        at += (size_t)snprintf(header + at, HEADER_BYTES_MOST - at, "property float %s\n", before[i]);
    for (uint32_t i = 0; i < rests; i++)
        at += (size_t)snprintf(header + at, HEADER_BYTES_MOST - at, "property float f_rest_%" PRIu32 "\n", i);
    for (size_t i = 0; i < VW_ARRAY_COUNT(after); i++)
        at += (size_t)snprintf(header + at, HEADER_BYTES_MOST - at, "property float %s\n", after[i]);
    return at + (size_t)snprintf(header + at, HEADER_BYTES_MOST - at, "end_header\n");
}

// Writes the numbers of a row, all of them but normals, which stay 0.
static void write_row(const float *params, uint32_t count, uint32_t degree, const struct vw_box *box, uint32_t splat,
                      float *row) {
    enum { X = 0, OPACITY = 3, SCALE = 4, TURN = 7, CONSTANT = 11 }; // places in the table of splat_header.c
    uint32_t rests = 3 * ((degree + 1) * (degree + 1) - 1);
    for (uint32_t i = 0; i < VW_SPLAT_FIELDS + rests; i++) {
        uint32_t place = vw_splat_property_place(i, degree);
        double number = params[4 * ((size_t)(place / 4) * count + splat) + place % 4];
        if (i < OPACITY) {
            row[i] = (float)((number - 0.5) * edge_of(box) + box->centre_world[i]);
        } else if (i == OPACITY) {
            row[9 + rests] = (float)number;
        } else if (i < TURN) {
            row[10 + rests + i - SCALE] = (float)(number + log(edge_of(box)));
        } else if (i < CONSTANT) {
            row[13 + rests + i - TURN] = (float)number;
        } else if (i < VW_SPLAT_FIELDS) {
            row[3 + NORMALS + i - CONSTANT] = (float)number;
        } else {
            row[9 + i - VW_SPLAT_FIELDS] = (float)number;
        }
    }
}

enum vw_status vw_splat_file_make(const float *params, uint32_t count, uint32_t degree, const struct vw_box *box,
                                  void **data, size_t *size_bytes) {
    char header[HEADER_BYTES_MOST];
    uint32_t rests = 3 * ((degree + 1) * (degree + 1) - 1), numbers = VW_SPLAT_FIELDS + NORMALS + rests;
    size_t header_bytes = write_header(header, count, rests), row_bytes = numbers * sizeof(float);
    char *bytes = vw_allocate(header_bytes + row_bytes * count, 1);
    if (!bytes) return VW_ERROR_MEMORY;
    memcpy(bytes, header, header_bytes);
    for (uint32_t splat = 0; splat < count; splat++) {
        float row[VW_SPLAT_NUMBERS + NORMALS] = {0};
        write_row(params, count, degree, box, splat, row);
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

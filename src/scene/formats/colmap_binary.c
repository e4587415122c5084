// COLMAP's binary files: little-endian numbers without padding. Every count is compared with the number of remaining
// bytes before anything is allocated or read, so that a false count costs no memory.
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 32;
enum { // smallest size of a record
    CAMERA_BYTES_MIN = 4 + 4 + 8 + 8 + 3 * 8,
    IMAGE_BYTES_MIN = 4 + 7 * 8 + 4 + 1 + 8,
    FEATURE_BYTES = 2 * 8 + 8,
    POINT_BYTES_MIN = 8 + 3 * 8 + 3 + 8 + 8,
    TRACK_BYTES = 4 + 4,
};

// A file while it is parsed. After a failure nothing more is read and all numbers are 0.
struct bytes {
    const uint8_t *next, *end, *begin;
    enum vw_status status;
};

static size_t left(const struct bytes *bytes) { return (size_t)(bytes->end - bytes->next); }

static void refuse_end(struct bytes *bytes, const char *field) {
    if (bytes->status) return;
    bytes->status = vw_fail(VW_ERROR_INPUT, "ends within field %s, after %zu bytes; copy or export the file again",
                            field, (size_t)(bytes->end - bytes->begin));
}

static void read_bytes(struct bytes *bytes, const char *field, void *value, size_t size_bytes) {
    if (left(bytes) < size_bytes) refuse_end(bytes, field);
    if (bytes->status) {
        memset(value, 0, size_bytes);
        return;
    }
    memcpy(value, bytes->next, size_bytes);
    bytes->next += size_bytes;
}

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "COLMAP's numbers are taken as they lie in memory, which must be little-endian"
#endif

static uint32_t read_u32(struct bytes *bytes, const char *field) {
    uint32_t value;
    read_bytes(bytes, field, &value, sizeof value);
    return value;
}

static uint64_t read_u64(struct bytes *bytes, const char *field) {
    uint64_t value;
    read_bytes(bytes, field, &value, sizeof value);
    return value;
}

// Reads the number of records that follow, each of at least `record_bytes`.
static uint64_t take_count(struct bytes *bytes, const char *field, size_t record_bytes) {
    uint64_t count = read_u64(bytes, field);
    if (!bytes->status && count > left(bytes) / record_bytes)
        bytes->status =
            vw_fail(VW_ERROR_INPUT, "field %s is %" PRIu64 " but only %zu bytes follow; copy or export the file again",
                    field, count, left(bytes));
    return bytes->status ? 0 : count;
}

static const char *take_text(struct bytes *bytes, const char *field) {
    const char *text = (const char *)bytes->next;
    const uint8_t *zero = memchr(bytes->next, 0, left(bytes));
    if (!zero) refuse_end(bytes, field);
    if (bytes->status) return "";
    bytes->next = zero + 1;
    return text;
}

// ---- Records ----

static enum vw_status read_camera(struct bytes *bytes, struct colmap_builder *builder) {
    uint32_t id = read_u32(bytes, "camera_id");
    int32_t model_id = (int32_t)read_u32(bytes, "model_id");
    uint64_t width_px = read_u64(bytes, "width"), height_px = read_u64(bytes, "height");
    const struct colmap_camera_model *model;
    double params[COLMAP_PARAMS_MAX] = {0};
    struct vw_camera camera;
    if (bytes->status) return bytes->status;
    enum vw_status status = colmap_camera_model_by_id(id, model_id, &model);
    if (!status) {
        read_bytes(bytes, "params", params, colmap_camera_param_count(model) * sizeof params[0]);
        status = bytes->status;
    }
    if (!status) status = colmap_camera_make(id, model, width_px, height_px, params, &camera);
    return status ? status : colmap_add_camera(builder, id, &camera);
}

static enum vw_status read_features(struct bytes *bytes, struct colmap_builder *builder) {
    uint64_t count = take_count(bytes, "num_points2D", FEATURE_BYTES);
    enum vw_status status = bytes->status;
    for (uint64_t i = 0; !status && i < count; i++) {
        double position_px[2];
        read_bytes(bytes, "points2D", position_px, sizeof position_px);
        read_u64(bytes, "point3D_id"); // the tracks have the same information
        status = colmap_add_feature(builder, position_px[0], position_px[1]);
    }
    return status;
}

static enum vw_status read_image(struct bytes *bytes, struct colmap_builder *builder) {
    struct colmap_image_fields fields = {.id = read_u32(bytes, "image_id")};
    read_bytes(bytes, "quaternion", fields.rotation, sizeof fields.rotation);
    read_bytes(bytes, "translation", fields.translation, sizeof fields.translation);
    fields.camera_id = read_u32(bytes, "camera_id");
    fields.name = take_text(bytes, "name");
    enum vw_status status = bytes->status;
    if (!status) status = colmap_add_image(builder, &fields);
    return status ? status : read_features(bytes, builder);
}

static enum vw_status read_point(struct bytes *bytes, struct colmap_builder *builder) {
    struct colmap_point_fields fields = {.id = read_u64(bytes, "point3D_id")};
    read_bytes(bytes, "xyz", fields.position_world, sizeof fields.position_world);
    read_bytes(bytes, "rgb", fields.rgb, sizeof fields.rgb);
    read_bytes(bytes, "error", &fields.error_px, sizeof fields.error_px);
    uint64_t track_count = take_count(bytes, "track_length", TRACK_BYTES);
    enum vw_status status = bytes->status;
    if (!status) status = colmap_add_point(builder, &fields);
    for (uint64_t i = 0; !status && i < track_count; i++) {
        uint32_t image_id = read_u32(bytes, "track"), feature = read_u32(bytes, "track");
        status = colmap_add_track(builder, image_id, feature);
    }
    return status;
}

// ---- Files ----

static const struct file_kind {
    const char *count_field;
    size_t record_bytes_min;
    enum vw_status (*read)(struct bytes *bytes, struct colmap_builder *builder);
} kinds[COLMAP_FILES] = {
    {"num_cameras", CAMERA_BYTES_MIN, read_camera},
    {"num_images", IMAGE_BYTES_MIN, read_image},
    {"num_points3D", POINT_BYTES_MIN, read_point},
};

static enum vw_status read_file(const char *path, enum colmap_file file, struct colmap_builder *builder) {
    const struct file_kind *kind = &kinds[file];
    void *data;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(builder->scene_folder, path, FILE_LIMIT_BYTES, &data, &size_bytes);
    if (status) return status; // its message names the file
    struct bytes bytes = {.begin = data, .next = data, .end = (const uint8_t *)data + size_bytes};
    uint64_t count = take_count(&bytes, kind->count_field, kind->record_bytes_min);
    status = bytes.status;
    for (uint64_t i = 0; !status && i < count; i++) status = kind->read(&bytes, builder);
    if (!status && left(&bytes))
        status = vw_fail(VW_ERROR_INPUT,
                         "%zu bytes follow the %" PRIu64 " records that field %s states; export the file again",
                         left(&bytes), count, kind->count_field);
    if (!status) status = colmap_file_done(builder, file);
    free(data);
    return status ? vw_fail_context(status, "%s", path) : VW_OK;
}

const struct colmap_file_reader colmap_binary_reader = {"bin", read_file};

// Finds the files of a COLMAP model and reads them, binary or text. Both have the same records of the same fields in
// the same order: a record is read once, field by field, and an encoding says how a field is read.
//
// Binary files are little-endian numbers without padding. Every count is compared with the number of remaining bytes
// before anything is allocated or read, so that a false count costs no memory. Text files have one record per line (an
// image has two), fields separated by spaces, and comments after #.
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 32;

// A file while it is read: the bytes of a binary file, with the records and the items of a list that are left; or the
// lines of a text file, whose next_line is NULL at its end, with the rest of the current one. After a failure nothing
// more is read and all numbers are 0.
struct fields {
    enum vw_status status;
    const uint8_t *begin, *next, *end;
    uint64_t record_count, records, items;
    char *next_line, *rest;
    int line; // 0: none, as in a binary file
};

struct encoding;

// One of the three files of a model.
struct file_kind {
    const char *name, *count_field;
    size_t record_bytes_min; // smallest size of a record
    enum vw_status (*read)(const struct encoding *encoding, struct fields *fields, struct colmap_builder *builder);
};

// The functions that read fields. A list is what a record has many of; in text, it may be on a line of its own.
struct encoding {
    const char *extension;
    void (*begin)(struct fields *fields, char *data, size_t size_bytes, const struct file_kind *kind);
    bool (*next_record)(struct fields *fields);
    void (*end)(struct fields *fields, const struct file_kind *kind);
    uint64_t (*whole)(struct fields *fields, const char *field, size_t size_bytes); // has no sign
    void (*reals)(struct fields *fields, const char *field, double *values, uint32_t count);
    const char *(*name)(struct fields *fields);
    const struct colmap_camera_model *(*camera_model)(struct fields *fields, uint32_t camera);
    void (*begin_list)(struct fields *fields, const char *field, size_t item_bytes, bool own_line);
    bool (*next_item)(struct fields *fields);
    void (*end_line)(struct fields *fields);
};

// ---- Binary --------------------------------------------------------------------------------------------------------

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "COLMAP's numbers are taken as they lie in memory, which must be little-endian"
#endif

static size_t left(const struct fields *fields) { return (size_t)(fields->end - fields->next); }

static void refuse_end(struct fields *fields, const char *field) {
    if (fields->status) return;
    fields->status = vw_fail(VW_ERROR_INPUT, "ends within field %s, after %zu bytes; copy or export the file again",
                             field, (size_t)(fields->end - fields->begin));
}

// Reads into `value`, which is zero before.
static void read_bytes(struct fields *fields, const char *field, void *value, size_t size_bytes) {
    if (left(fields) < size_bytes) refuse_end(fields, field);
    if (fields->status) return;
    memcpy(value, fields->next, size_bytes);
    fields->next += size_bytes;
}

static uint64_t binary_whole(struct fields *fields, const char *field, size_t size_bytes) {
    uint64_t value = 0;
    read_bytes(fields, field, &value, size_bytes);
    return value;
}

static void binary_reals(struct fields *fields, const char *field, double *values, uint32_t count) {
    memset(values, 0, count * sizeof *values);
    read_bytes(fields, field, values, count * sizeof *values);
}

static const char *binary_name(struct fields *fields) {
    const char *text = (const char *)fields->next;
    const uint8_t *zero = memchr(fields->next, 0, left(fields));
    if (!zero) refuse_end(fields, "name");
    if (fields->status) return "";
    fields->next = zero + 1;
    return text;
}

static const struct colmap_camera_model *binary_camera_model(struct fields *fields, uint32_t camera) {
    const struct colmap_camera_model *model = NULL;
    int32_t id = (int32_t)binary_whole(fields, "model_id", sizeof id);
    if (!fields->status) fields->status = colmap_camera_model_by_id(camera, id, &model);
    return model;
}

// Reads the number of records or items that follow, each of at least `item_bytes`.
static uint64_t read_count(struct fields *fields, const char *field, size_t item_bytes) {
    uint64_t count = binary_whole(fields, field, sizeof count);
    if (!fields->status && count > left(fields) / item_bytes)
        fields->status =
            vw_fail(VW_ERROR_INPUT, "field %s is %" PRIu64 " but only %zu bytes follow; copy or export the file again",
                    field, count, left(fields));
    return fields->status ? 0 : count;
}

static void binary_begin_list(struct fields *fields, const char *field, size_t item_bytes, bool own_line) {
    (void)own_line;
    fields->items = read_count(fields, field, item_bytes);
}

static bool binary_next_item(struct fields *fields) { return !fields->status && fields->items && fields->items--; }

static void binary_end_line(struct fields *fields) { (void)fields; }

static void binary_begin(struct fields *fields, char *data, size_t size_bytes, const struct file_kind *kind) {
    fields->begin = fields->next = (const uint8_t *)data;
    fields->end = fields->begin + size_bytes;
    fields->record_count = fields->records = read_count(fields, kind->count_field, kind->record_bytes_min);
}

static bool binary_next_record(struct fields *fields) { return fields->records && fields->records--; }

static void binary_end(struct fields *fields, const struct file_kind *kind) {
    if (left(fields))
        fields->status = vw_fail(VW_ERROR_INPUT,
                                 "%zu bytes follow the %" PRIu64 " records that field %s states; export the file again",
                                 left(fields), fields->record_count, kind->count_field);
}

// ---- Text ----------------------------------------------------------------------------------------------------------

static const char SPACES[] = " \t\r";

static bool next_line(struct fields *fields) {
    fields->rest = strsep(&fields->next_line, "\n");
    fields->line++;
    return fields->rest != NULL;
}

static bool line_ended(struct fields *fields) {
    fields->rest += strspn(fields->rest, SPACES);
    return !*fields->rest;
}

static void text_begin(struct fields *fields, char *data, size_t size_bytes, const struct file_kind *kind) {
    (void)kind;
    fields->next_line = data;
    if (strlen(data) < size_bytes)
        fields->status = vw_fail(VW_ERROR_INPUT, "has zero bytes, so it is not a text file; export the file again");
}

static bool text_next_record(struct fields *fields) {
    while (next_line(fields))
        if (!line_ended(fields) && *fields->rest != '#') return true;
    return false;
}

static void text_end(struct fields *fields, const struct file_kind *kind) { (void)fields, (void)kind; }

static const char *take_word(struct fields *fields, const char *field) {
    if (fields->status) return "0";
    if (line_ended(fields)) {
        fields->status =
            vw_fail(VW_ERROR_INPUT, "field %s is missing; complete the line or export the file again", field);
        return "0";
    }
    char *word = fields->rest;
    fields->rest += strcspn(word, SPACES);
    if (*fields->rest) *fields->rest++ = 0;
    return word;
}

static void refuse_word(struct fields *fields, const char *field, const char *word, const char *wanted) {
    if (fields->status) return;
    fields->status = vw_fail(VW_ERROR_INPUT, "field %s is \"%.32s\"; %s", field, word, wanted);
}

// Leaves infinities and NaN to the builder, which knows the record.
static void text_reals(struct fields *fields, const char *field, double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const char *word = take_word(fields, field);
        char *end;
        values[i] = strtod(word, &end);
        if (*end) refuse_word(fields, field, word, "give a number");
        if (fields->status) values[i] = 0;
    }
}

static uint64_t text_whole(struct fields *fields, const char *field, size_t size_bytes) {
    const char *word = take_word(fields, field);
    char *end;
    errno = 0;
    unsigned long long value = strtoull(word, &end, 10);
    if (*end || *word == '-' || errno || value > UINT64_MAX >> (64 - 8 * size_bytes))
        refuse_word(fields, field, word, "give a whole number that is neither negative nor too large");
    return fields->status ? 0 : value;
}

// Returns the rest of the line, which may contain spaces.
static const char *text_name(struct fields *fields) {
    const char *name = fields->status || line_ended(fields) ? take_word(fields, "name") : fields->rest;
    char *end = fields->rest + strlen(fields->rest);
    while (end > name && strchr(SPACES, end[-1])) *--end = 0;
    fields->rest = end;
    return name;
}

static const struct colmap_camera_model *text_camera_model(struct fields *fields, uint32_t camera) {
    const struct colmap_camera_model *model = NULL;
    const char *name = take_word(fields, "model");
    if (!fields->status) fields->status = colmap_camera_model_by_name(camera, name, &model);
    return model;
}

// Moves to the line of an image's points; an empty line has none. Other lists end their record's line.
static void text_begin_list(struct fields *fields, const char *field, size_t item_bytes, bool own_line) {
    (void)field, (void)item_bytes;
    if (!fields->status && own_line && !next_line(fields))
        fields->status =
            vw_fail(VW_ERROR_INPUT, "the line of the last image's points2D is missing; copy or export the file again");
}

static bool text_next_item(struct fields *fields) { return !fields->status && !line_ended(fields); }

static void text_end_line(struct fields *fields) {
    if (fields->status || line_ended(fields)) return;
    fields->status =
        vw_fail(VW_ERROR_INPUT, "\"%.32s\" follows the last field; remove it or export the file again", fields->rest);
}

static const struct encoding encodings[] = {
    // in the order in which they are tried
    {"bin", binary_begin, binary_next_record, binary_end, binary_whole, binary_reals, binary_name, binary_camera_model,
     binary_begin_list, binary_next_item, binary_end_line},
    {"txt", text_begin, text_next_record, text_end, text_whole, text_reals, text_name, text_camera_model,
     text_begin_list, text_next_item, text_end_line},
};

// ---- Records -------------------------------------------------------------------------------------------------------

static enum vw_status read_camera(const struct encoding *read, struct fields *fields, struct colmap_builder *builder) {
    uint32_t id = (uint32_t)read->whole(fields, "camera_id", sizeof id);
    const struct colmap_camera_model *model = read->camera_model(fields, id);
    uint64_t width_px = read->whole(fields, "width", sizeof width_px),
             height_px = read->whole(fields, "height", sizeof height_px);
    double params[COLMAP_PARAMS_MAX] = {0};
    struct vw_camera camera;
    if (fields->status) return fields->status;
    read->reals(fields, "params", params, colmap_camera_param_count(model));
    read->end_line(fields);
    if (fields->status) return fields->status;
    enum vw_status status = colmap_camera_make(id, model, width_px, height_px, params, &camera);
    return status ? status : colmap_add_camera(builder, id, &camera);
}

// Skips the ids of points, since the tracks of points have the same information.
static enum vw_status read_features(const struct encoding *read, struct fields *fields,
                                    struct colmap_builder *builder) {
    enum { FEATURE_BYTES = 2 * 8 + 8 };
    enum vw_status status = VW_OK;
    read->begin_list(fields, "num_points2D", FEATURE_BYTES, true);
    while (!status && read->next_item(fields)) {
        double position_px[2], point;
        read->reals(fields, "points2D", position_px, 2);
        read->reals(fields, "point3D_id", &point, 1);
        status = fields->status ? fields->status : colmap_add_feature(builder, position_px[0], position_px[1]);
    }
    return status ? status : fields->status;
}

static enum vw_status read_image(const struct encoding *read, struct fields *fields, struct colmap_builder *builder) {
    struct colmap_image_fields image = {.id = (uint32_t)read->whole(fields, "image_id", sizeof image.id)};
    read->reals(fields, "quaternion", image.rotation, 4);
    read->reals(fields, "translation", image.translation, 3);
    image.camera_id = (uint32_t)read->whole(fields, "camera_id", sizeof image.camera_id);
    image.name = read->name(fields);
    enum vw_status status = fields->status ? fields->status : colmap_add_image(builder, &image);
    return status ? status : read_features(read, fields, builder);
}

static enum vw_status read_point(const struct encoding *read, struct fields *fields, struct colmap_builder *builder) {
    enum { TRACK_BYTES = 4 + 4 };
    struct colmap_point_fields point = {.id = read->whole(fields, "point3D_id", sizeof point.id)};
    read->reals(fields, "xyz", point.position_world, 3);
    for (int i = 0; i < 3; i++) point.rgb[i] = (uint8_t)read->whole(fields, "rgb", 1);
    read->reals(fields, "error", &point.error_px, 1);
    read->begin_list(fields, "track_length", TRACK_BYTES, false);
    enum vw_status status = fields->status ? fields->status : colmap_add_point(builder, &point);
    while (!status && read->next_item(fields)) {
        uint32_t image_id = (uint32_t)read->whole(fields, "track", sizeof image_id),
                 feature = (uint32_t)read->whole(fields, "track", sizeof feature);
        status = fields->status ? fields->status : colmap_add_track(builder, image_id, feature);
    }
    return status ? status : fields->status;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static const struct file_kind kinds[COLMAP_FILES] = {
    {"cameras", "num_cameras", 4 + 4 + 8 + 8 + 3 * 8, read_camera},
    {"images", "num_images", 4 + 7 * 8 + 4 + 1 + 8, read_image},
    {"points3D", "num_points3D", 8 + 3 * 8 + 3 + 8 + 8, read_point},
};

static enum vw_status read_file(const char *path, const struct encoding *encoding, enum colmap_file file,
                                struct colmap_builder *builder) {
    void *data;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(builder->scene_folder, path, FILE_LIMIT_BYTES, &data, &size_bytes);
    if (status) return status; // its message names the file
    struct fields fields = {.status = VW_OK};
    encoding->begin(&fields, data, size_bytes, &kinds[file]);
    while (!fields.status && encoding->next_record(&fields))
        fields.status = kinds[file].read(encoding, &fields, builder);
    bool at_line = fields.status && fields.line;
    if (!fields.status) encoding->end(&fields, &kinds[file]);
    status = fields.status ? fields.status : colmap_file_done(builder, file);
    free(data);
    if (!status) return VW_OK;
    return at_line ? vw_fail_context(status, "%s:%d", path, fields.line) : vw_fail_context(status, "%s", path);
}

static const char *const folders[] = {"sparse/0", "sparse", "dense/sparse/0", "dense/sparse"};

static bool has_file(const char *folder, const char *name, const char *extension) {
    char *path = vw_format_text("%s/%s.%s", folder, name, extension);
    bool exists = path && vw_file_exists(path);
    free(path);
    return exists;
}

static bool has_all_files(const char *folder, const char *extension) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(kinds); i++)
        if (!has_file(folder, kinds[i].name, extension)) return false;
    return true;
}

static bool looks_like_model(const char *folder) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(encodings); i++)
        if (has_file(folder, kinds[0].name, encodings[i].extension)) return true;
    return false;
}

char *vw_colmap_find(const char *scene_folder) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(folders); i++) {
        char *folder = vw_path_join(scene_folder, folders[i]);
        if (!folder || looks_like_model(folder)) return folder;
        free(folder);
    }
    return NULL;
}

enum vw_status vw_colmap_read(const char *model_folder, const char *scene_folder, struct vw_colmap_model *model) {
    const struct encoding *encoding = NULL;
    for (size_t i = 0; !encoding && i < VW_ARRAY_COUNT(encodings); i++)
        if (has_all_files(model_folder, encodings[i].extension)) encoding = &encodings[i];
    if (!encoding)
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: the COLMAP model is not complete; put cameras, images and points3D there, all .bin or all .txt",
            model_folder);
    struct vw_colmap_model read = {0};
    struct colmap_builder builder = {.model = &read, .scene_folder = scene_folder};
    enum vw_status status = VW_OK;
    for (enum colmap_file file = 0; !status && file < COLMAP_FILES; file++) {
        char *path = vw_format_text("%s/%s.%s", model_folder, kinds[file].name, encoding->extension);
        status = path ? read_file(path, encoding, file, &builder) : VW_ERROR_MEMORY;
        free(path);
    }
    colmap_builder_clear(&builder);
    if (status) vw_colmap_clear(&read);
    else *model = read;
    return status;
}

void vw_colmap_clear(struct vw_colmap_model *model) {
    for (size_t i = 0; i < model->image_count; i++) free(model->images[i].name);
    vw_name_index_clear(&model->names);
    free(model->cameras);
    free(model->images);
    free(model->features);
    free(model->points);
    free(model->tracks);
    *model = (struct vw_colmap_model){0};
}

ptrdiff_t vw_colmap_find_image(const struct vw_colmap_model *model, const char *name) {
    size_t place = 0;
    return vw_name_index_find(&model->names, name, &place) ? (ptrdiff_t)place : -1;
}

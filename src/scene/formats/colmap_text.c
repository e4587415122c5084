// COLMAP's text files: one record per line (an image has two), fields separated by spaces, comments after #.
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 32;
static const char SPACES[] = " \t\r";

// A file while it is parsed. After a failure nothing more is read and all numbers are 0.
struct text {
    char *next_line; // NULL at the end
    char *rest;      // rest of the current line
    int line;
    enum vw_status status;
};

static bool next_line(struct text *text) {
    text->rest = strsep(&text->next_line, "\n");
    text->line++;
    return text->rest != NULL;
}

// Moves to the next line with a record; false at the end.
static bool next_record(struct text *text) {
    while (next_line(text)) {
        text->rest += strspn(text->rest, SPACES);
        if (*text->rest && *text->rest != '#') return true;
    }
    return false;
}

static bool line_ended(struct text *text) {
    text->rest += strspn(text->rest, SPACES);
    return !*text->rest;
}

// ---- Fields ----

static const char *take_word(struct text *text, const char *field) {
    if (text->status) return "0";
    if (line_ended(text)) {
        text->status =
            vw_fail(VW_ERROR_INPUT, "field %s is missing; complete the line or export the file again", field);
        return "0";
    }
    char *word = text->rest;
    text->rest += strcspn(word, SPACES);
    if (*text->rest) *text->rest++ = 0;
    return word;
}

static void refuse_word(struct text *text, const char *field, const char *word, const char *wanted) {
    if (text->status) return;
    text->status = vw_fail(VW_ERROR_INPUT, "field %s is \"%.32s\"; %s", field, word, wanted);
}

static double take_real(struct text *text, const char *field) {
    const char *word = take_word(text, field);
    char *end;
    double value = strtod(word, &end);
    if (*end) refuse_word(text, field, word, "give a number");
    return text->status ? 0 : value; // infinities and NaN are refused by the builder, which knows the record
}

static uint64_t take_whole(struct text *text, const char *field, uint64_t most) {
    const char *word = take_word(text, field);
    char *end;
    errno = 0;
    unsigned long long value = strtoull(word, &end, 10);
    if (*end || *word == '-' || errno || value > most)
        refuse_word(text, field, word, "give a whole number that is neither negative nor too large");
    return text->status ? 0 : value;
}

static uint32_t take_id(struct text *text, const char *field) { return (uint32_t)take_whole(text, field, UINT32_MAX); }

static void take_reals(struct text *text, const char *field, double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) values[i] = take_real(text, field);
}

// Returns the rest of the line, which may contain spaces.
static const char *take_name(struct text *text) {
    const char *name = text->status || line_ended(text) ? take_word(text, "name") : text->rest;
    char *end = text->rest + strlen(text->rest);
    while (end > name && strchr(SPACES, end[-1])) *--end = 0;
    text->rest = end;
    return name;
}

static void expect_end(struct text *text) {
    if (text->status || line_ended(text)) return;
    text->status =
        vw_fail(VW_ERROR_INPUT, "\"%.32s\" follows the last field; remove it or export the file again", text->rest);
}

// ---- Records ----

static enum vw_status read_camera(struct text *text, struct colmap_builder *builder) {
    uint32_t id = take_id(text, "camera_id");
    const char *name = take_word(text, "model");
    uint64_t width_px = take_whole(text, "width", UINT64_MAX), height_px = take_whole(text, "height", UINT64_MAX);
    const struct colmap_camera_model *model;
    double params[COLMAP_PARAMS_MAX] = {0};
    struct vw_camera camera;
    enum vw_status status = text->status;
    if (!status) status = colmap_camera_model_by_name(id, name, &model);
    if (status) return status;
    take_reals(text, "params", params, colmap_camera_param_count(model));
    expect_end(text);
    if (text->status) return text->status;
    status = colmap_camera_make(id, model, width_px, height_px, params, &camera);
    return status ? status : colmap_add_camera(builder, id, &camera);
}

// Reads the line after an image: its points; an empty line has none.
static enum vw_status read_features(struct text *text, struct colmap_builder *builder) {
    if (!next_line(text))
        return vw_fail(VW_ERROR_INPUT,
                       "the line of the last image's points2D is missing; copy or export the file again");
    enum vw_status status = VW_OK;
    while (!status && !line_ended(text)) {
        double x_px = take_real(text, "points2D"), y_px = take_real(text, "points2D");
        take_real(text, "point3D_id"); // -1: none; the tracks have the same information
        status = text->status ? text->status : colmap_add_feature(builder, x_px, y_px);
    }
    return status;
}

static enum vw_status read_image(struct text *text, struct colmap_builder *builder) {
    struct colmap_image_fields fields = {.id = take_id(text, "image_id")};
    take_reals(text, "quaternion", fields.rotation, 4);
    take_reals(text, "translation", fields.translation, 3);
    fields.camera_id = take_id(text, "camera_id");
    fields.name = take_name(text);
    enum vw_status status = text->status;
    if (!status) status = colmap_add_image(builder, &fields);
    return status ? status : read_features(text, builder);
}

static enum vw_status read_point(struct text *text, struct colmap_builder *builder) {
    struct colmap_point_fields fields = {.id = take_whole(text, "point3D_id", UINT64_MAX)};
    take_reals(text, "xyz", fields.position_world, 3);
    for (int i = 0; i < 3; i++) fields.rgb[i] = (uint8_t)take_whole(text, "rgb", UINT8_MAX);
    fields.error_px = take_real(text, "error");
    enum vw_status status = text->status;
    if (!status) status = colmap_add_point(builder, &fields);
    while (!status && !line_ended(text)) {
        uint32_t image_id = take_id(text, "track"), feature = take_id(text, "track");
        status = text->status ? text->status : colmap_add_track(builder, image_id, feature);
    }
    return status;
}

// ---- Files ----

static enum vw_status (*const records[COLMAP_FILES])(struct text *text, struct colmap_builder *builder) = {
    read_camera, read_image, read_point};

static enum vw_status read_file(const char *path, enum colmap_file file, struct colmap_builder *builder) {
    void *data;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(builder->scene_folder, path, FILE_LIMIT_BYTES, &data, &size_bytes);
    if (status) return status; // its message names the file
    struct text text = {.next_line = data};
    if (strlen(data) < size_bytes)
        status = vw_fail(VW_ERROR_INPUT, "has zero bytes, so it is not a text file; export the file again");
    while (!status && next_record(&text)) status = records[file](&text, builder);
    bool at_line = status && text.line;
    if (!status) status = colmap_file_done(builder, file);
    free(data);
    if (!status) return VW_OK;
    return at_line ? vw_fail_context(status, "%s:%d", path, text.line) : vw_fail_context(status, "%s", path);
}

const struct colmap_file_reader colmap_text_reader = {"txt", read_file};

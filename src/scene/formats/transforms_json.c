// transforms.json as Blender's NeRF scenes, instant-ngp and nerfstudio write it: one file, or
// transforms_{train,val,test}.json.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/transforms.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 25; // a frame takes about 1 KiB
static const char *const extensions[] = {"", ".png", ".jpg", ".jpeg", ".exr", ".PNG", ".JPG", ".JPEG", ".EXR"};
enum { FILES_MOST = 3 };
static const char *const split_files[FILES_MOST] = {"transforms_train.json", "transforms_val.json",
                                                    "transforms_test.json"}; // by enum vw_split

struct reader {
    struct vw_scene_builder *builder;
    struct vw_ngp_box box;        // box of the first file that has one
    json_t *splits;               // from the current file's own keys; NULL: none
    struct vw_name_index frames;  // owned; of the current file
    struct vw_name_index earlier; // owned; of the views of the files before
};

// ---- Splits ----

static enum vw_status refuse_two_splits(const char *where, const char *name, const char *first, const char *second) {
    return vw_fail(VW_ERROR_INPUT, "%s: %s is in two splits, %s and %s; keep it in one", where, name, first, second);
}

static enum vw_status read_names(const char *path, const json_t *names, enum vw_split split, json_t *splits) {
    if (!json_is_array(names))
        return vw_fail(VW_ERROR_INPUT, "%s: field %s is not a list of file paths; correct it or leave it out", path,
                       vw_transforms_split_key(split));
    for (size_t i = 0; i < json_array_size(names); i++) {
        const char *name = json_string_value(json_array_get(names, i));
        if (!name)
            return vw_fail(VW_ERROR_INPUT, "%s: field %s: entry %zu is not a text; name a frame's photo", path,
                           vw_transforms_split_key(split), i);
        name = vw_view_name_of(name);
        const json_t *other = json_object_get(splits, name);
        if (other && json_integer_value(other) != (json_int_t)split)
            return refuse_two_splits(path, name, vw_transforms_split_key(json_integer_value(other)),
                                     vw_transforms_split_key(split));
        if (!other && json_object_set_new(splits, name, json_integer((json_int_t)split)))
            return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for %s", path, vw_transforms_split_key(split));
    }
    return VW_OK;
}

// Reads the splits that a file gives its photos by the keys train_filenames, val_filenames and test_filenames, as
// nerfstudio has them: an object of enum vw_split by name, owned by the caller; NULL if the file has none of these
// keys. Photos that none of them names are excluded. VW_ERROR_INPUT if a value is not a list of names, and for a photo
// in two splits.
static enum vw_status read_splits(const char *path, const json_t *file, json_t **splits) {
    json_t *read = NULL;
    enum vw_status status = VW_OK;
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++) {
        const json_t *names = json_object_get(file, vw_transforms_split_key(split));
        if (!names) continue;
        if (!read) read = json_object();
        status = read ? read_names(path, names, split, read)
                      : vw_fail(VW_ERROR_MEMORY, "%s: out of memory for splits", path);
    }
    if (status) json_decref(read);
    else *splits = read;
    return status;
}

// ---- Finding files ----

bool vw_transforms_probe(const char *path) {
    if (!vw_folder_exists(path)) return vw_file_exists(path) && vw_path_ends_with(path, ".json");
    for (size_t i = 0; i < VW_ARRAY_COUNT(split_files); i++)
        if (vw_scene_has_file(path, split_files[i])) return true;
    return vw_scene_has_file(path, "transforms.json");
}

struct transforms_file {
    char *path;          // owned
    enum vw_split split; // by the file's name; train for a single file
};

// Finds the files of the scene at `path`: the path itself if it is not a folder, otherwise the existing files of
// transforms_{train,val,test}.json, otherwise transforms.json, which may be missing. Free the paths also after a
// failure.
static enum vw_status find_files(const char *path, struct transforms_file files[FILES_MOST], size_t *count) {
    bool is_folder = vw_folder_exists(path), whole = true;
    *count = 0;
    for (enum vw_split split = 0; is_folder && split < VW_SPLIT_EXCLUDED; split++)
        if (vw_scene_has_file(path, split_files[split]))
            files[(*count)++] = (struct transforms_file){vw_path_join(path, split_files[split]), split};
    if (*count == 0)
        files[(*count)++] =
            (struct transforms_file){is_folder ? vw_path_join(path, "transforms.json") : vw_copy_text(path), 0};
    for (size_t i = 0; i < *count; i++) whole &= files[i].path != NULL;
    return whole ? VW_OK : VW_ERROR_MEMORY;
}

// Refuses an existing file that must not be read. `field` names the field with the path, which is relative to the scene
// folder; `file` is the file itself.
static enum vw_status check_file(const struct vw_scene_builder *builder, const char *where, const char *field,
                                 const char *file) {
    enum vw_status status = vw_scene_file_check(builder->folder, file);
    return status ? vw_fail_context(status, "%s: field %s", where, field) : VW_OK;
}

static enum vw_status check_name(const char *where, const char *field, const char *name) {
    if (!vw_text_is_clean(name))
        return vw_fail(VW_ERROR_INPUT, "%s: field %s has control characters; rename the file", where, field);
    if (!vw_path_leaves_folder(name)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: field %s leaves the scene folder; use a path relative to it without ..", where,
                   field);
}

// Finds the photo that a frame names, possibly without its extension; `*path` (owned by the caller) stays NULL if there
// is none.
static enum vw_status find_image(const struct reader *reader, const char *where, const char *name, char **path) {
    enum vw_status status = check_name(where, "file_path", name);
    bool other_kind = false; // a folder, pipe or device has this name
    for (size_t i = 0; !status && !*path && i < VW_ARRAY_COUNT(extensions); i++) {
        char *file = vw_format_text("%s/%s%s", reader->builder->folder, name, extensions[i]);
        if (!file) return VW_ERROR_MEMORY;
        if (vw_file_exists(file)) *path = vw_copy_text(file);
        else other_kind |= i == 0 && access(file, F_OK) == 0;
        if (*path) status = check_file(reader->builder, where, "file_path", file);
        free(file);
    }
    if (!status && !*path && other_kind)
        status = vw_fail(VW_ERROR_INPUT, "%s: field file_path: %s is not a plain file; name a photo", where, name);
    return status;
}

// Sets the mask of the view added last, if its frame names one.
static enum vw_status take_mask(const struct reader *reader, const char *where, const json_t *frame) {
    const json_t *given = json_object_get(frame, "mask_path");
    if (!given || json_is_null(given)) return VW_OK;
    if (!json_is_string(given))
        return vw_fail(VW_ERROR_INPUT, "%s: field mask_path is not a text; name the mask or leave it out", where);
    enum vw_status status = check_name(where, "mask_path", json_string_value(given));
    if (status) return status;
    char *path = vw_format_text("%s/%s", reader->builder->folder, vw_view_name_of(json_string_value(given)));
    if (!path) return VW_ERROR_MEMORY;
    status = vw_file_exists(path)
                 ? check_file(reader->builder, where, "mask_path", path)
                 : vw_fail(VW_ERROR_INPUT, "%s: field mask_path: %s does not exist; add the mask or remove the field",
                           where, path);
    if (!status) status = vw_scene_builder_set_mask(reader->builder, path);
    free(path);
    return status;
}

// ---- Frames ----

static enum vw_status add_frame(struct reader *reader, const char *where, const json_t *file, const json_t *frame,
                                enum vw_split split, const char *name, const char *image_path) {
    struct vw_camera camera;
    double camera_to_world[3][4];
    bool rescaled = false;
    struct vw_image_header header = {0};
    enum vw_status status = vw_transforms_refuse_unknown(where, frame);
    if (!status) status = vw_transforms_pose(where, frame, camera_to_world);
    if (!status) {
        status = vw_scene_photo_probe(reader->builder, image_path, &header);
        if (status) vw_fail_context(status, "%s", where);
    }
    if (!status)
        status = vw_transforms_camera(where, file, frame, header.width_px, header.height_px, &camera, &rescaled);
    if (status) return status;
    struct vw_view *view = vw_scene_builder_add_view(reader->builder, name, image_path, &header);
    if (!view) return VW_ERROR_MEMORY;
    view->split = split;
    view->camera = camera;
    memcpy(view->camera_to_world, camera_to_world, sizeof camera_to_world);
    reader->builder->rescaled_count += rescaled;
    return take_mask(reader, where, frame);
}

// Refuses a frame whose photo an earlier one has.
static enum vw_status refuse_again(const struct reader *reader, const char *where, size_t place, const char *name,
                                   enum vw_split split) {
    const struct vw_scene *scene = reader->builder->scene;
    size_t first = place, view = 0;
    if (vw_name_index_find(&reader->earlier, name, &view) && scene->views[view].split != split)
        return refuse_two_splits(where, name, vw_split_name(scene->views[view].split), vw_split_name(split));
    if (vw_name_index_find(&reader->earlier, name, &view) ||
        (vw_name_index_find(&reader->frames, name, &first) && first < place))
        return vw_fail(VW_ERROR_INPUT, "%s: field file_path: %s appears twice; remove one of the frames", where, name);
    return VW_OK;
}

static enum vw_status load_frame(struct reader *reader, const char *where, const json_t *file, size_t place,
                                 enum vw_split split) {
    const json_t *frame = json_array_get(json_object_get(file, "frames"), place);
    const char *spelled = json_string_value(json_object_get(frame, "file_path"));
    if (!spelled || !*vw_view_name_of(spelled))
        return vw_fail(VW_ERROR_INPUT, "%s: field file_path is missing or not a text; name the frame's photo", where);
    const char *name = vw_view_name_of(spelled);
    const json_t *own = json_object_get(reader->splits, name);
    if (reader->splits) split = own ? (enum vw_split)json_integer_value(own) : VW_SPLIT_EXCLUDED;
    char *image_path = NULL;
    enum vw_status status = find_image(reader, where, name, &image_path);
    if (!status && !image_path) return vw_scene_builder_count_missing(reader->builder, name);
    if (!status) status = refuse_again(reader, where, place, name, split);
    if (!status) status = add_frame(reader, where, file, frame, split, name, image_path);
    free(image_path);
    return status;
}

// ---- Files ----

static enum vw_status positive_number(const char *path, const json_t *file, const char *key, double fallback,
                                      double *value) {
    const json_t *given = json_object_get(file, key);
    *value = given ? json_number_value(given) : fallback;
    if (*value > 0 || (!given && fallback == 0)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: field %s must be a number above 0; correct it or leave it out", path, key);
}

// Reads `offset`, one number for all axes, or three.
static enum vw_status read_offset(const char *path, const json_t *file, double offset[3]) {
    const json_t *given = json_object_get(file, "offset");
    for (size_t i = 0; i < 3; i++) {
        const json_t *value = json_is_array(given) ? json_array_get(given, i) : given;
        if (given && !json_is_number(value))
            return vw_fail(VW_ERROR_INPUT, "%s: field offset must be a number or three; correct it or leave it out",
                           path);
        offset[i] = given ? json_number_value(value) : 0.5;
    }
    return VW_OK;
}

// Reads the box, with instant-ngp's defaults.
static enum vw_status read_box(const char *path, const json_t *file, struct vw_ngp_box *box) {
    enum vw_status status = positive_number(path, file, "aabb_scale", 0, &box->aabb_scale);
    if (!status) status = positive_number(path, file, "scale", 0.33, &box->scale);
    if (!status) status = read_offset(path, file, box->offset);
    return status;
}

enum vw_status vw_transforms_parse(const char *folder, const char *path, json_t **file) {
    void *text;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(folder, path, FILE_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    status = vw_json_parse(path, text, size_bytes, file);
    free(text);
    return status;
}

static const char *name_of_frame(const json_t *frames, size_t place) {
    return json_string_value(json_object_get(json_array_get(frames, place), "file_path"));
}

static void forget_names(struct reader *reader) {
    vw_name_index_clear(&reader->frames);
    vw_name_index_clear(&reader->earlier);
}

static enum vw_status index_names(struct reader *reader, const json_t *frames) {
    const struct vw_scene *scene = reader->builder->scene;
    size_t count = json_array_size(frames);
    const char **names = vw_allocate(count, sizeof *names);
    forget_names(reader);
    for (size_t i = 0; names && i < count; i++) names[i] = name_of_frame(frames, i);
    enum vw_status status =
        names ? vw_name_index_make(names, sizeof *names, 0, count, &reader->frames) : VW_ERROR_MEMORY;
    free(names);
    return status ? status
                  : vw_name_index_make(scene->views, sizeof *scene->views, offsetof(struct vw_view, name),
                                       scene->view_count, &reader->earlier);
}

static enum vw_status load_frames(struct reader *reader, const char *path, const json_t *file, enum vw_split split) {
    const json_t *frames = json_object_get(file, "frames");
    if (!json_array_size(frames))
        return vw_fail(VW_ERROR_INPUT, "%s: field frames is missing or empty; give a scene file with posed photos",
                       path);
    if (!reader->box.aabb_scale) {
        enum vw_status status = read_box(path, file, &reader->box);
        if (status) return status;
    }
    enum vw_status status = vw_transforms_refuse_unknown(path, file);
    if (!status) status = index_names(reader, frames);
    for (size_t i = 0; !status && i < json_array_size(frames); i++) {
        const char *name = name_of_frame(frames, i);
        char *where = vw_format_text("%s: frame %zu (%s)", path, i, name ? name : "unnamed");
        status = where ? load_frame(reader, where, file, i, split) : VW_ERROR_MEMORY;
        free(where);
    }
    return status;
}

static const char *first_name(const json_t *file) {
    const char *name = name_of_frame(json_object_get(file, "frames"), 0);
    return name ? vw_view_name_of(name) : "unnamed";
}

static enum vw_status load_file(struct reader *reader, const char *path, enum vw_split split) {
    json_t *file = NULL;
    uint32_t view_count = reader->builder->scene->view_count, missing_count = reader->builder->missing_count;
    const char *given = reader->builder->params->path;
    enum vw_status status = vw_transforms_parse(vw_folder_exists(given) ? given : NULL, path, &file);
    if (!status) status = read_splits(path, file, &reader->splits);
    if (!status) status = load_frames(reader, path, file, split);
    if (!status && reader->builder->scene->view_count == view_count)
        status = vw_fail(VW_ERROR_INPUT, "%s: no image file of its %u frames exists (first: %s); check file_path", path,
                         reader->builder->missing_count - missing_count, first_name(file));
    forget_names(reader);
    json_decref(file);
    json_decref(reader->splits);
    reader->splits = NULL;
    return status;
}

// Uses the first half of the test rows (in file order) for validation if there are no validation rows.
static void halve_test(struct vw_scene *scene) {
    uint32_t count = 0, test_count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split == VW_SPLIT_VAL) return;
        test_count += scene->views[v].split == VW_SPLIT_TEST;
    }
    if (test_count == scene->view_count) return; // there is no train view
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_TEST && count++ < (test_count + 1) / 2)
            scene->views[v].split = VW_SPLIT_VAL;
}

static enum vw_status load_all(struct reader *reader, const char *path) {
    struct transforms_file files[FILES_MOST] = {0};
    size_t count = 0;
    enum vw_status status = find_files(path, files, &count);
    for (size_t i = 0; !status && i < count; i++) status = load_file(reader, files[i].path, files[i].split);
    for (size_t i = 0; i < count; i++) free(files[i].path);
    if (!status) halve_test(reader->builder->scene);
    return status;
}

enum vw_status vw_transforms_load(struct vw_scene_builder *builder) {
    struct reader reader = {.builder = builder};
    enum vw_status status = load_all(&reader, builder->params->path);
    if (!status) status = vw_scene_builder_note_repairs(builder);
    if (!status) status = vw_sfm_evidence_find(builder);
    if (!status) status = vw_bounds_choose(&reader.box, builder->scene);
    return status;
}

// Writes transforms.json with the chosen photos: one file, or transforms_{train,val,test}.json.
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/photo_list.h"
#include "scene/formats/transforms.h"
#include "viewworth/log.h"

// A file while it is written.
struct target {
    char *path;         // owned
    json_t *keys;       // owned: all keys of the scene's file except frames and splits; NULL until the first frame
    json_t *frames;     // owned
    const char *source; // the file that the keys are from, while the scene's files are read
};

struct writer {
    const struct vw_photo_list *list;
    struct vw_name_index photos; // owned; of the list
    bool single;
    char *way; // owned; relative path from the new files to the scene's folder
    struct target targets[VW_TRANSFORMS_FILES_MOST];
    json_t *splits[VW_TRANSFORMS_FILES_MOST]; // owned: the names of a single file's frames, by split
    bool *seen;                               // owned: of each photo
    uint32_t unknown_count;                   // frames that were not valued
    char *first_unknown;                      // owned
};

static enum vw_status out_of_memory(const struct writer *writer) {
    return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for the list", writer->list->to);
}

// ---- Keys ----

static bool is_path_key(const char *key) {
    const char suffix[] = "_path";
    size_t length = strlen(key), suffix_length = sizeof suffix - 1;
    return length > suffix_length && strcmp(key + length - suffix_length, suffix) == 0;
}

// Makes the relative paths of an object relative to the place of the list.
static enum vw_status lead_paths(const struct writer *writer, json_t *object) {
    const char *key;
    json_t *value;
    if (!*writer->way) return VW_OK;
    json_object_foreach(object, key, value) {
        if (!is_path_key(key) || !json_is_string(value) || json_string_value(value)[0] == '/') continue;
        char *path = vw_format_text("%s%s", writer->way, vw_view_name_of(json_string_value(value)));
        bool failed = !path || json_object_iter_set_new(object, json_object_key_to_iter(key), json_string(path));
        free(path);
        if (failed) return out_of_memory(writer);
    }
    return VW_OK;
}

// Copies all keys of a file that do not belong to frames or splits.
static enum vw_status copy_keys(const struct writer *writer, const json_t *file, json_t **keys) {
    json_t *copy = json_copy((json_t *)file); // the copy shares the values, which are replaced but never changed
    if (!copy) return out_of_memory(writer);
    json_object_del(copy, "frames");
    for (enum vw_split split = 0; split < VW_SPLIT_EXCLUDED; split++)
        json_object_del(copy, vw_transforms_split_key(split));
    enum vw_status status = lead_paths(writer, copy);
    if (status) json_decref(copy);
    else *keys = copy;
    return status;
}

// ---- Frames ----

// Returns the file for a frame. Frames of several files may go to one file only if their other keys are equal.
static enum vw_status open_target(struct writer *writer, enum vw_split split, const char *path, json_t *keys,
                                  struct target **target) {
    *target = &writer->targets[writer->single ? 0 : split];
    if (!(*target)->keys) {
        (*target)->keys = json_incref(keys);
        (*target)->frames = json_array();
        (*target)->source = path;
        return (*target)->frames ? VW_OK : out_of_memory(writer);
    }
    if (json_equal((*target)->keys, keys)) return VW_OK;
    return vw_fail(
        VW_ERROR_INPUT,
        "%s: its keys other than frames differ from those of %s, so that one file cannot have the frames of both; %s",
        path, (*target)->source,
        writer->single ? "name a folder in place of a .json file"
                       : "give all files the same, or value without lists of splits");
}

static enum vw_status add_frame(struct writer *writer, const json_t *frame, enum vw_split split,
                                struct target *target) {
    json_t *copy = json_copy((json_t *)frame);
    enum vw_status status = copy ? lead_paths(writer, copy) : out_of_memory(writer);
    json_t *name = json_object_get(copy, "file_path");
    if (!status && writer->single && json_array_append(writer->splits[split], name)) status = out_of_memory(writer);
    if (!status && json_array_append(target->frames, copy)) status = out_of_memory(writer);
    json_decref(copy);
    return status;
}

static enum vw_status count_unknown(struct writer *writer, const char *name) {
    if (writer->unknown_count++) return VW_OK;
    writer->first_unknown = vw_copy_text(name);
    if (!writer->first_unknown) return VW_ERROR_MEMORY;
    vw_text_make_line(writer->first_unknown); // for the warning: the name is not checked
    return VW_OK;
}

static enum vw_status take_frame(struct writer *writer, const char *path, json_t *keys, const json_t *frame) {
    const char *name = json_string_value(json_object_get(frame, "file_path"));
    if (!name) return vw_fail(VW_ERROR_INPUT, "%s: a frame has no file_path; restore the scene that was valued", path);
    size_t place = 0;
    if (!vw_name_index_find(&writer->photos, name, &place)) return count_unknown(writer, name);
    const struct vw_listed_photo *photo = &writer->list->photos[place];
    writer->seen[place] = true;
    if (!vw_photo_list_keeps(photo)) return VW_OK;
    struct target *target = NULL;
    enum vw_status status = open_target(writer, photo->split, path, keys, &target);
    return status ? status : add_frame(writer, frame, photo->split, target);
}

static enum vw_status take_file(struct writer *writer, const char *path) {
    const char *given = writer->list->scene_path;
    json_t *file = NULL, *keys = NULL;
    enum vw_status status = vw_transforms_parse(vw_folder_exists(given) ? given : NULL, path, &file);
    if (!status) status = copy_keys(writer, file, &keys);
    const json_t *frames = json_object_get(file, "frames");
    for (size_t i = 0; !status && i < json_array_size(frames); i++)
        status = take_frame(writer, path, keys, json_array_get(frames, i));
    json_decref(keys);
    json_decref(file);
    return status;
}

static enum vw_status check_seen(const struct writer *writer) {
    for (uint32_t i = 0; i < writer->list->photo_count; i++)
        if (!writer->seen[i]) return vw_photo_list_refuse_missing(writer->list, &writer->list->photos[i]);
    if (writer->unknown_count && !writer->list->check_only)
        vw_log_warning("left out %u frame%s of %s whose photo was not valued (first: %s)", writer->unknown_count,
                       vw_plural(writer->unknown_count), writer->list->scene_path, writer->first_unknown);
    return VW_OK;
}

static const char *name_of_photo(const void *context, size_t place) {
    return ((const struct vw_photo_list *)context)->photos[place].name;
}

static enum vw_status take_scene(struct writer *writer) {
    struct vw_transforms_file files[VW_TRANSFORMS_FILES_MOST] = {0};
    size_t count = 0;
    enum vw_status status = vw_name_index_make(name_of_photo, writer->list, writer->list->photo_count, &writer->photos);
    if (!status) status = vw_transforms_find(writer->list->scene_path, files, &count);
    for (size_t i = 0; !status && i < count; i++) status = take_file(writer, files[i].path);
    for (size_t i = 0; i < count; i++) free(files[i].path);
    return status ? status : check_seen(writer);
}

// ---- Files ----

static bool ends_with(const char *text, const char *suffix) {
    size_t length = strlen(text), suffix_length = strlen(suffix);
    return length >= suffix_length && strcmp(text + length - suffix_length, suffix) == 0;
}

static const char *last_part(const char *path) { return strrchr(path, '/') ? strrchr(path, '/') + 1 : path; }

// Refuses a file of another kind: the user may have another scene in mind. Creates at most one folder, which is removed
// after a failure.
static enum vw_status make_folder(const char *to) {
    if (vw_folder_exists(to)) return VW_OK;
    if (strchr(last_part(to), '.'))
        return vw_fail(
            VW_ERROR_USAGE,
            "--to %s: the scene has the format transforms; name a .json file, or a folder for one file per split", to);
    if (!mkdir(to, 0777)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--to %s: cannot create the folder: %s; name one in a folder that exists", to,
                   strerror(errno));
}

// Names the files to write; none may exist.
static enum vw_status name_targets(struct writer *writer) {
    const char *to = writer->list->to;
    char *folder = writer->single ? vw_path_folder(to) : vw_copy_text(to);
    enum vw_status status = folder ? vw_photo_list_way(writer->list, folder, &writer->way) : VW_ERROR_MEMORY;
    free(folder);
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++) {
        char name[40];
        snprintf(name, sizeof name, "transforms_%s.json", vw_split_name(split));
        if (writer->single && split > 0) break;
        writer->targets[split].path = writer->single ? vw_copy_text(to) : vw_path_join(to, name);
        status = writer->targets[split].path ? vw_photo_list_check_new(writer->targets[split].path) : VW_ERROR_MEMORY;
    }
    return status;
}

static enum vw_status write_target(const struct writer *writer, const struct target *target) {
    bool failed = false;
    for (enum vw_split split = 0; writer->single && split < VW_SPLIT_EXCLUDED; split++)
        failed |= json_object_set(target->keys, vw_transforms_split_key(split), writer->splits[split]) != 0;
    failed |= json_object_set(target->keys, "frames", target->frames) != 0;
    char *bare =
        failed ? NULL
               : vw_json_to_text(target->keys, JSON_INDENT(1) | JSON_REAL_PRECISION(17)); // numbers read back unchanged
    char *text = bare ? vw_format_text("%s\n", bare) : NULL;
    enum vw_status status = text ? vw_file_write(target->path, text, strlen(text)) : out_of_memory(writer);
    free(bare);
    free(text);
    return status;
}

// Writes all files or none.
static enum vw_status write_targets(const struct writer *writer) {
    enum vw_status status = VW_OK;
    size_t written = 0;
    while (!status && written < VW_TRANSFORMS_FILES_MOST) {
        const struct target *target = &writer->targets[written];
        if (target->keys) status = write_target(writer, target);
        written += !status;
    }
    for (size_t i = 0; status && i < written; i++)
        if (writer->targets[i].keys) unlink(writer->targets[i].path);
    return status;
}

static void close_writer(struct writer *writer) {
    for (size_t i = 0; i < VW_TRANSFORMS_FILES_MOST; i++) {
        free(writer->targets[i].path);
        json_decref(writer->targets[i].keys);
        json_decref(writer->targets[i].frames);
        json_decref(writer->splits[i]);
    }
    vw_name_index_clear(&writer->photos);
    free(writer->way);
    free(writer->seen);
    free(writer->first_unknown);
}

enum vw_status vw_transforms_write_list(const struct vw_photo_list *list, bool *opens) {
    struct writer writer = {
        .list = list, .single = ends_with(list->to, ".json"), .seen = vw_allocate(list->photo_count, sizeof(bool))};
    bool existed = vw_folder_exists(list->to), whole = writer.seen != NULL;
    for (size_t i = 0; i < VW_TRANSFORMS_FILES_MOST; i++) whole &= (writer.splits[i] = json_array()) != NULL;
    enum vw_status status = whole ? VW_OK : out_of_memory(&writer);
    if (!status && !writer.single) status = make_folder(list->to);
    if (!status) status = name_targets(&writer);
    if (!status) status = take_scene(&writer);
    if (!status && !list->check_only) status = write_targets(&writer);
    if ((status || list->check_only) && !writer.single && !existed)
        rmdir(list->to); // fails if the folder has other files, which is fine
    if (!status) *opens = strncmp(writer.way, "../", 3) != 0;
    close_writer(&writer);
    return status;
}

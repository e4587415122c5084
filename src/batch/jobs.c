#include "batch/batch.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"

struct file {
    const char *folder;
    const json_t *root; // checked, but for its jobs
    struct vw_jobs *jobs;
    size_t capacity;
};

// ---- Fields -------------------------------------------------------------------------------------------------------

// Checks a name of an item of `array`: it becomes a folder, and a part of the names of jobs.
static void check_name(struct vw_json_reader *reader, const json_t *item, const json_t *array) {
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    const char *name = "";
    vw_json_text(reader, item, "name", &name);
    size_t length = strlen(name);
    if (!length || length > VW_JOB_NAME_PART_MAX || strspn(name, allowed) != length || *name == '-')
        vw_json_refuse(reader, "name", "give 1 to %d letters, digits, _ and -, not - first", VW_JOB_NAME_PART_MAX);
    for (size_t i = 0; json_array_get(array, i) != item; i++)
        if (json_equal(json_object_get(item, "name"), json_object_get(json_array_get(array, i), "name")))
            vw_json_refuse(reader, "name", "\"%s\" is the name of an earlier one; give another name", name);
}

static void check_scene(struct vw_json_reader *reader, const json_t *item) {
    const char *scene = "";
    vw_json_text(reader, item, "scene", &scene);
    if (!*scene || strlen(scene) >= PATH_MAX || !vw_text_is_clean(scene))
        vw_json_refuse(reader, "scene", "give the scene's folder or file, a text without line breaks");
}

static void check_seeds(struct vw_json_reader *reader, const json_t *object) {
    const json_t *array = json_object_get(object, "seeds");
    size_t count = json_array_size(array);
    if (array && (!json_is_array(array) || !count || count > VW_JOBS_MAX))
        vw_json_refuse(reader, "seeds", "give an array of 1 to %d whole numbers", VW_JOBS_MAX);
    for (size_t i = 0; i < count && !reader->status; i++) {
        const json_t *seed = json_array_get(array, i);
        if (!json_is_integer(seed) || json_integer_value(seed) < 0)
            vw_json_refuse(reader, "seeds", "a seed is a whole number from 0 to %" PRId64, INT64_MAX);
        for (size_t j = 0; j < i; j++)
            if (json_equal(seed, json_array_get(array, j)))
                vw_json_refuse(reader, "seeds", "%" JSON_INTEGER_FORMAT " is named twice", json_integer_value(seed));
    }
}

static bool is_option_value(const json_t *value) {
    if (!json_is_string(value)) return json_is_boolean(value) || json_is_number(value);
    return json_string_length(value) <= VW_JOB_OPTION_BYTES_MAX && vw_text_is_clean(json_string_value(value));
}

static void check_option(struct vw_json_reader *reader, const char *key, const json_t *value) {
    static const char own[] = "out,seed,resume,device,devices,json,quiet,help";
    if (!*key || strspn(key, "abcdefghijklmnopqrstuvwxyz0123456789-") != strlen(key) || *key == '-')
        vw_json_refuse(reader, "options", "a key is not an option of value, written without its two dashes");
    else if (vw_word_list_has(own, key))
        vw_json_refuse(reader, key, "no option of a job: batch has its own way for it, or none; remove it");
    else if (!is_option_value(value))
        vw_json_refuse(reader, key, "give a number, a text of at most %d bytes without line breaks, true, or false",
                       VW_JOB_OPTION_BYTES_MAX);
}

static void check_options(struct vw_json_reader *reader, const json_t *object, const char *member) {
    const char *key;
    json_t *options = json_object_get(object, member), *value;
    if (options && (!json_is_object(options) || json_object_size(options) > VW_JOB_OPTIONS_MAX))
        vw_json_refuse(reader, member, "give an object of at most %d options", VW_JOB_OPTIONS_MAX);
    json_object_foreach(options, key, value) { check_option(reader, key, value); }
}

// ---- The jobs -----------------------------------------------------------------------------------------------------

// Returns "--epochs=16", owned by the caller; NULL if memory is short.
static char *write_option(const char *key, const json_t *value) {
    if (json_is_true(value)) return vw_format_text("--%s", key);
    if (json_is_string(value)) return vw_format_text("--%s=%s", key, json_string_value(value));
    if (json_is_integer(value)) return vw_format_text("--%s=%" JSON_INTEGER_FORMAT, key, json_integer_value(value));
    char number[32];
    for (int digits = 15; digits <= 17; digits++) { // the shortest that reads back to the same number
        snprintf(number, sizeof number, "%.*g", digits, json_real_value(value));
        if (strtod(number, NULL) == json_real_value(value)) break;
    }
    return vw_format_text("--%s=%s", key, number);
}

static void append_option(json_t **words, const char *key, const json_t *value) {
    char *word = write_option(key, value);
    vw_json_append(words, word ? json_string(word) : NULL);
    free(word);
}

// Makes the words: options of all jobs, then those of the config, then those of the scene; later ones win.
static json_t *make_words(const struct file *file, const json_t *item, const json_t *config, json_t *seed) {
    json_t *parts[] = {json_object_get(file->root, "defaults"), json_object_get(config, "options"),
                       json_object_get(item, "options")};
    const char *key;
    json_t *options = json_object(), *value, *words = json_array();
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++) json_object_foreach(parts[i], key, value) {
            vw_json_set(&options, key, json_incref(value));
        }
    vw_json_append(&words, json_string("value"));
    vw_json_append(&words, json_incref(json_object_get(item, "scene")));
    append_option(&words, "seed", seed);
    json_object_foreach(options, key, value) {
        if (!json_is_false(value)) append_option(&words, key, value);
    }
    if (!options) vw_json_append(&words, NULL); // memory is short
    json_decref(options);
    return words;
}

static void add_job(struct vw_json_reader *reader, struct file *file, const json_t *item, const json_t *config,
                    json_t *seed) {
    struct vw_jobs *jobs = file->jobs;
    const char *name = json_string_value(json_object_get(item, "name")),
               *of_config = json_string_value(json_object_get(config, "name"));
    if (jobs->count == VW_JOBS_MAX)
        vw_json_refuse(reader, "jobs", "more than %d valuations in all; divide the file", VW_JOBS_MAX);
    if (!reader->status)
        reader->status = vw_grow((void **)&jobs->jobs, &file->capacity, jobs->count + 1, sizeof *jobs->jobs);
    if (reader->status) return;
    struct vw_job *job = &jobs->jobs[jobs->count++];
    job->name = vw_format_text("%s%s%s/seed-%" JSON_INTEGER_FORMAT, name, of_config ? "/" : "",
                               of_config ? of_config : "", json_integer_value(seed));
    job->scene = vw_path_join(file->folder, json_string_value(json_object_get(item, "scene")));
    job->words = make_words(file, item, config, seed);
    if (!job->name || !job->scene || !job->words) reader->status = vw_fail(VW_ERROR_MEMORY, "out of memory for jobs");
}

// ---- The file -----------------------------------------------------------------------------------------------------

static void read_config(struct vw_json_reader *reader, const json_t *item, void *context) {
    const struct file *file = context;
    vw_json_check_keys(reader, item, "name options");
    check_name(reader, item, json_object_get(file->root, "configs"));
    check_options(reader, item, "options");
}

// Adds the jobs of a scene. Without configs, or without seeds, one that sets nothing, or seed 0, takes their place.
static void read_scene(struct vw_json_reader *reader, const json_t *item, void *context) {
    struct file *file = context;
    const json_t *configs = json_object_get(file->root, "configs"), *seeds = json_object_get(item, "seeds");
    json_t *zero = json_integer(0);
    if (!seeds) seeds = json_object_get(file->root, "seeds");
    vw_json_check_keys(reader, item, "name scene seeds options");
    check_name(reader, item, json_object_get(file->root, "jobs"));
    check_scene(reader, item);
    check_seeds(reader, item);
    check_options(reader, item, "options");
    for (size_t c = 0; !reader->status && c < (json_array_size(configs) ? json_array_size(configs) : 1); c++)
        for (size_t i = 0; !reader->status && i < (seeds ? json_array_size(seeds) : 1); i++)
            add_job(reader, file, item, json_array_get(configs, c), seeds ? json_array_get(seeds, i) : zero);
    json_decref(zero);
}

static enum vw_status read_file(const char *path, struct file *file) {
    struct vw_json_reader reader = {.path = path};
    vw_json_check_keys(&reader, file->root, "defaults seeds configs jobs");
    check_options(&reader, file->root, "defaults");
    check_seeds(&reader, file->root);
    if (json_object_get(file->root, "configs"))
        vw_json_each(&reader, file->root, "configs", VW_JOBS_MAX, read_config, file);
    vw_json_each(&reader, file->root, "jobs", VW_JOBS_MAX, read_scene, file);
    if (!file->jobs->count) vw_json_refuse(&reader, "jobs", "is empty; name a scene");
    return reader.status;
}

enum vw_status vw_jobs_load(const char *path, struct vw_jobs *jobs) {
    json_t *root = NULL;
    char *folder = vw_path_folder(path);
    *jobs = (struct vw_jobs){0};
    enum vw_status status = folder ? vw_json_read_file(path, VW_JOBS_FILE_BYTES_MAX, &root) : VW_ERROR_MEMORY;
    if (!status) status = read_file(path, &(struct file){.folder = folder, .root = root, .jobs = jobs});
    json_decref(root);
    free(folder);
    return status;
}

void vw_jobs_free(struct vw_jobs *jobs) {
    for (uint32_t i = 0; i < jobs->count; i++) {
        free(jobs->jobs[i].name);
        free(jobs->jobs[i].scene);
        json_decref(jobs->jobs[i].words);
    }
    free(jobs->jobs);
    *jobs = (struct vw_jobs){0};
}

char **vw_job_list_words(const struct vw_job *job, char *const *more) {
    size_t own = json_array_size(job->words), count = 0;
    while (more[count]) count++;
    char **words = vw_allocate(own + count + 2, sizeof *words);
    if (!words) return NULL;
    words[0] = (char *)"viewworth";
    for (size_t i = 0; i < own; i++) words[i + 1] = (char *)json_string_value(json_array_get(job->words, i));
    words[2] = job->scene; // after "value"
    memcpy(words + own + 1, more, count * sizeof *words);
    return words;
}

#include "batch/jobs.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "viewworth/ledger.h"

enum { SEED_WORD = 2 }; // index in a job's words, after "value" and the scene

// A name with options, as the file has it: a config, or a scene. Texts and objects are borrowed from the file.
struct entry {
    const char *name, *scene;
    const json_t *options, *seeds;
};

struct entries {
    struct entry *entries; // owned
    size_t count, capacity;
};

struct file {
    const char *folder;
    const json_t *options, *seeds; // common to all jobs
    struct entries configs, scenes;
    struct vw_jobs *jobs;
    size_t capacity;
};

// ---- Fields -------------------------------------------------------------------------------------------------------

// Names become folders, and parts of a job's name.
static void read_name(struct vw_json_reader *reader, const json_t *object, const struct entries *before,
                      const char **name) {
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    *name = "";
    vw_json_text(reader, object, "name", name);
    size_t length = strlen(*name);
    if (!length || length > VW_JOB_NAME_PART_MAX || strspn(*name, allowed) != length || **name == '-')
        vw_json_refuse(reader, "name", "give 1 to %d letters, digits, _ and -, not - first", VW_JOB_NAME_PART_MAX);
    for (size_t i = 0; i < before->count; i++)
        if (!strcmp(before->entries[i].name, *name))
            vw_json_refuse(reader, "name", "\"%s\" is the name of an earlier one; give another name", *name);
}

static void read_scene(struct vw_json_reader *reader, const json_t *object, const char **scene) {
    *scene = "";
    vw_json_text(reader, object, "scene", scene);
    if (!**scene || strlen(*scene) >= PATH_MAX || !vw_text_is_clean(*scene))
        vw_json_refuse(reader, "scene", "give the scene's folder or file, a text without line breaks");
}

static bool is_seed(const json_t *seed) { return json_is_integer(seed) && json_integer_value(seed) >= 0; }

// Reads the seeds of a job, or of all jobs; without any, `*seeds` is unchanged.
static void read_seeds(struct vw_json_reader *reader, const json_t *object, const json_t **seeds) {
    const json_t *array = json_object_get(object, "seeds");
    size_t count = json_array_size(array);
    if (!array) return;
    if (!json_is_array(array) || !count || count > VW_JOBS_MAX)
        vw_json_refuse(reader, "seeds", "give an array of 1 to %d whole numbers", VW_JOBS_MAX);
    for (size_t i = 0; i < count && !reader->status; i++) {
        const json_t *seed = json_array_get(array, i);
        if (!is_seed(seed)) vw_json_refuse(reader, "seeds", "a seed is a whole number from 0 to %" PRId64, INT64_MAX);
        for (size_t j = 0; j < i; j++)
            if (json_equal(seed, json_array_get(array, j)))
                vw_json_refuse(reader, "seeds", "%" JSON_INTEGER_FORMAT " is named twice", json_integer_value(seed));
    }
    *seeds = array;
}

static bool is_option_value(const json_t *value) {
    if (!json_is_string(value)) return json_is_boolean(value) || json_is_number(value);
    return json_string_length(value) <= VW_JOB_OPTION_BYTES_MAX && vw_text_is_clean(json_string_value(value));
}

static void check_option(struct vw_json_reader *reader, const char *key, const json_t *value) {
    static const char own[] = "out,seed,resume,device,devices,json,quiet,help,help-all,kfold";
    if (!*key || strspn(key, "abcdefghijklmnopqrstuvwxyz0123456789-") != strlen(key) || *key == '-')
        vw_json_refuse(reader, "options", "a key is not an option of value, written without its two dashes");
    else if (vw_word_list_has(own, key))
        vw_json_refuse(reader, key, "no option of a job: batch has its own way for it, or none; remove it");
    else if (!is_option_value(value))
        vw_json_refuse(reader, key, "give a number, a text of at most %d bytes without line breaks, true, or false",
                       VW_JOB_OPTION_BYTES_MAX);
}

static void read_options(struct vw_json_reader *reader, const json_t *object, const char *member,
                         const json_t **options) {
    const char *key;
    json_t *value;
    *options = json_object_get(object, member);
    if (!*options) return;
    if (!json_is_object(*options) || json_object_size(*options) > VW_JOB_OPTIONS_MAX)
        vw_json_refuse(reader, member, "give an object of at most %d options", VW_JOB_OPTIONS_MAX);
    json_object_foreach((json_t *)*options, key, value) { check_option(reader, key, value); }
}

// ---- The file -----------------------------------------------------------------------------------------------------

static struct entry *add_entry(struct vw_json_reader *reader, struct entries *entries) {
    if (!reader->status)
        reader->status =
            vw_grow((void **)&entries->entries, &entries->capacity, entries->count + 1, sizeof *entries->entries);
    return reader->status ? NULL : &entries->entries[entries->count];
}

static void read_config(struct vw_json_reader *reader, const json_t *item, void *context) {
    struct entries *configs = &((struct file *)context)->configs;
    vw_json_check_keys(reader, item, "name options");
    struct entry *config = add_entry(reader, configs);
    if (!config) return;
    read_name(reader, item, configs, &config->name);
    read_options(reader, item, "options", &config->options);
    configs->count++;
}

static void read_job(struct vw_json_reader *reader, const json_t *item, void *context) {
    struct file *file = context;
    vw_json_check_keys(reader, item, "name scene seeds options");
    struct entry *scene = add_entry(reader, &file->scenes);
    if (!scene) return;
    scene->seeds = file->seeds;
    read_name(reader, item, &file->scenes, &scene->name);
    read_scene(reader, item, &scene->scene);
    read_seeds(reader, item, &scene->seeds);
    read_options(reader, item, "options", &scene->options);
    file->scenes.count++;
}

static void read_file(struct vw_json_reader *reader, const json_t *root, struct file *file) {
    vw_json_check_keys(reader, root, "defaults seeds configs jobs");
    read_options(reader, root, "defaults", &file->options);
    read_seeds(reader, root, &file->seeds);
    if (json_object_get(root, "configs")) vw_json_each(reader, root, "configs", VW_JOBS_MAX, read_config, file);
    vw_json_each(reader, root, "jobs", VW_JOBS_MAX, read_job, file);
    if (!file->scenes.count) vw_json_refuse(reader, "jobs", "is empty; name a scene");
    // One job without configs is that of a config without name and options.
    if (!file->configs.count && add_entry(reader, &file->configs))
        file->configs.entries[file->configs.count++].name = "";
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

// Writes the options of all jobs, then those of the config, then those of the scene: later ones win.
static enum vw_status write_words(const struct file *file, const struct entry *scene, const struct entry *config,
                                  json_int_t seed, struct vw_job *job) {
    const json_t *parts[] = {file->options, config->options, scene->options};
    const char *key;
    json_t *options = json_object(), *value;
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts) && options; i++) {
        json_object_foreach((json_t *)parts[i], key, value) { vw_json_set(&options, key, json_incref(value)); }
    }
    job->seed = (uint64_t)seed;
    job->words = vw_allocate(json_object_size(options) + 4, sizeof *job->words);
    bool complete = options && job->words;
    if (complete) {
        job->scene = vw_copy_text(scene->scene);
        complete = job->scene;
        job->words[job->word_count++] = vw_copy_text("value");
        job->words[job->word_count++] = vw_path_join(file->folder, scene->scene);
        job->words[job->word_count++] = vw_format_text("--seed=%" JSON_INTEGER_FORMAT, seed); // SEED_WORD
        json_object_foreach(options, key, value) {
            if (!json_is_false(value)) job->words[job->word_count++] = write_option(key, value);
        }
    }
    for (uint32_t i = 0; complete && i < job->word_count; i++) complete = job->words[i];
    json_decref(options);
    return complete ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for the jobs");
}

static void add_job(struct vw_json_reader *reader, struct file *file, const struct entry *scene,
                    const struct entry *config, json_int_t seed) {
    struct vw_jobs *jobs = file->jobs;
    if (jobs->count == VW_JOBS_MAX)
        vw_json_refuse(reader, "jobs", "more than %d valuations in all; divide the file", VW_JOBS_MAX);
    if (!reader->status)
        reader->status = vw_grow((void **)&jobs->jobs, &file->capacity, jobs->count + 1, sizeof *jobs->jobs);
    if (reader->status) return;
    struct vw_job *job = &jobs->jobs[jobs->count++];
    job->name =
        vw_format_text("%s%s%s/seed-%" JSON_INTEGER_FORMAT, scene->name, *config->name ? "/" : "", config->name, seed);
    reader->status = job->name ? write_words(file, scene, config, seed, job) : VW_ERROR_MEMORY;
}

static void add_jobs(struct vw_json_reader *reader, struct file *file) {
    for (size_t s = 0; s < file->scenes.count; s++)
        for (size_t c = 0; c < file->configs.count; c++) {
            const struct entry *scene = &file->scenes.entries[s], *config = &file->configs.entries[c];
            size_t count = scene->seeds ? json_array_size(scene->seeds) : 1;
            for (size_t i = 0; i < count && !reader->status; i++)
                add_job(reader, file, scene, config, json_integer_value(json_array_get(scene->seeds, i)));
        }
}

static enum vw_status parse(const char *path, json_t **root) {
    void *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read(path, VW_JOBS_FILE_BYTES_MAX, &text, &size_bytes);
    if (!status) status = vw_json_parse(path, text, size_bytes, root);
    free(text);
    return status;
}

enum vw_status vw_jobs_load(const char *path, struct vw_jobs *jobs) {
    *jobs = (struct vw_jobs){0};
    json_t *root = NULL;
    char *folder = vw_path_folder(path);
    struct file file = {.folder = folder, .jobs = jobs};
    struct vw_json_reader reader = {.path = path, .status = folder ? parse(path, &root) : VW_ERROR_MEMORY};
    if (!reader.status) read_file(&reader, root, &file);
    if (!reader.status) add_jobs(&reader, &file);
    free(file.configs.entries);
    free(file.scenes.entries);
    free(folder);
    json_decref(root);
    return reader.status;
}

// Compares names without their seeds.
static bool have_one_folder(const struct vw_job *a, const struct vw_job *b) {
    size_t length = (size_t)(strrchr(a->name, '/') - a->name);
    return !strncmp(a->name, b->name, length + 1) && !strchr(b->name + length + 1, '/');
}

bool vw_jobs_fit(const struct vw_job *a, const struct vw_job *b) {
    bool fit = !a->single && !b->single && a->word_count == b->word_count && have_one_folder(a, b);
    for (uint32_t i = 0; fit && i < a->word_count; i++) fit = i == SEED_WORD || !strcmp(a->words[i], b->words[i]);
    return fit;
}

void vw_jobs_free(struct vw_jobs *jobs) {
    for (uint32_t i = 0; i < jobs->count; i++) {
        for (uint32_t w = 0; w < jobs->jobs[i].word_count; w++) free(jobs->jobs[i].words[w]);
        free(jobs->jobs[i].words);
        free(jobs->jobs[i].name);
        free(jobs->jobs[i].scene);
    }
    free(jobs->jobs);
    *jobs = (struct vw_jobs){0};
}

// ---- Records -----------------------------------------------------------------------------------------------------

enum { RECORD_BYTES_MAX = 1 << 20 };

// Writes the scene as the file names it: a batch is the same wherever its file is named from.
static json_t *words_to_json(const struct vw_job *job) {
    json_t *words = json_array();
    for (uint32_t i = 0; i < job->word_count; i++)
        vw_json_append(&words, vw_json_string(i == 1 ? job->scene : job->words[i]));
    return words;
}

// Hashes what a run is: its run_id, which covers scene, photos, seed and device, and its config with the epochs.
static void hash_run(const struct vw_ledger_run *row, char run[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, row->run_id);
    vw_hasher_add_text(&hasher, row->config_json);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, run);
}

// Finds which run a job's folder has; "" where it has none of the job's seed.
static void find_run(const char *out, const struct vw_job *job, char run[VW_HASH_HEX_BYTES]) {
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run row;
    char *name = vw_format_text("%s/ledger.db", job->name), *path = name ? vw_path_join(out, name) : NULL;
    enum vw_status status = path ? vw_file_check_inside(out, name) : VW_ERROR_MEMORY;
    *run = 0;
    if (!status) status = vw_ledger_open(path, &ledger);
    if (!status) status = vw_ledger_get_run(ledger, &row);
    if (!status && (uint64_t)row.seed == job->seed) hash_run(&row, run);
    vw_ledger_close(&ledger);
    free(path);
    free(name);
}

static enum vw_status fail_foreign(const char *out, const struct vw_job *job, struct vw_job_result *result) {
    free(result->message);
    result->state = VW_JOB_FAILED;
    result->message =
        vw_format_text("%s/%s: is not the run that the job left there; remove this folder", out, job->name);
    return result->message ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_job_result_check(const char *out, const struct vw_job *job, struct vw_job_result *result) {
    char run[VW_HASH_HEX_BYTES];
    find_run(out, job, run);
    return *run && strcmp(run, result->run) == 0 ? VW_OK : fail_foreign(out, job, result);
}

enum vw_status vw_job_result_note_run(const char *out, const struct vw_job *job, struct vw_job_result *result) {
    find_run(out, job, result->run);
    return *result->run ? VW_OK : fail_foreign(out, job, result);
}

// Returns whether a ledger is in the job's folder.
static bool has_ledger(const char *out, const struct vw_job *job) {
    char *ledger = vw_format_text("%s/ledger.db", job->name);
    bool there = ledger && vw_file_exists_inside(out, ledger);
    free(ledger);
    return there;
}

static enum vw_status read_result(const char *out, const json_t *object, const struct vw_job *job,
                                  struct vw_job_result *result) {
    const json_t *code = json_object_get(object, "exit_code"), *seconds = json_object_get(object, "seconds");
    const char *message = json_string_value(json_object_get(object, "message"));
    const char *run = json_string_value(json_object_get(object, "run"));
    json_t *words = words_to_json(job);
    bool same = words && json_equal(words, json_object_get(object, "words")) && json_is_integer(code) &&
                json_integer_value(code) >= 0 && json_integer_value(code) <= UINT8_MAX &&
                json_number_value(seconds) >= 0;
    json_decref(words);
    if (!same) return VW_OK;
    bool failed = message && *message; // stopped: neither
    bool done = !failed && !json_integer_value(code) && run && *run && has_ledger(out, job);
    result->state = done ? VW_JOB_DONE : failed ? VW_JOB_FAILED : VW_JOB_WAITING;
    if (done || failed) result->exit_code = (int)json_integer_value(code);
    result->seconds = json_number_value(seconds);
    if (failed && !(result->message = vw_copy_text(message))) return VW_ERROR_MEMORY;
    if (done) snprintf(result->run, sizeof result->run, "%s", run);
    return done ? vw_job_result_check(out, job, result) : VW_OK;
}

enum vw_status vw_job_result_read(const char *out, const struct vw_job *job, struct vw_job_result *result) {
    void *text = NULL;
    size_t size_bytes = 0;
    char *name = vw_format_text("%s.json", job->name);
    *result = (struct vw_job_result){.exit_code = -1};
    if (!name) return VW_ERROR_MEMORY;
    bool there = vw_file_exists_inside(out, name);
    enum vw_status status = there ? vw_file_read_inside(out, name, RECORD_BYTES_MAX, &text, &size_bytes) : VW_OK;
    json_t *object = !status && there ? vw_json_load(text, size_bytes, 0, NULL) : NULL;
    status = read_result(out, object, job, result);
    json_decref(object);
    free(text);
    free(name);
    return status;
}

enum vw_status vw_job_result_write(const char *out, const struct vw_job *job, const struct vw_job_result *result) {
    char *path = vw_format_text("%s/%s.json", out, job->name);
    json_t *object =
        json_pack("{s:o, s:i, s:f, s:s, s:s}", "words", words_to_json(job), "exit_code", result->exit_code, "seconds",
                  result->seconds, "message", result->message ? result->message : "", "run", result->run);
    enum vw_status status = vw_json_write_file(path, object);
    free(path);
    return status;
}

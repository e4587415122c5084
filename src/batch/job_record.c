#include "batch/job_record.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"

enum { RECORD_BYTES_MAX = 1 << 20 };

// Writes the scene as the file names it: a batch is the same wherever its file is named from.
static json_t *words_to_json(const struct vw_job *job) {
    json_t *words = json_array();
    for (uint32_t i = 0; i < job->word_count; i++)
        vw_json_append(&words, vw_json_string(i == 1 ? job->scene : job->words[i]));
    return words;
}

bool vw_job_record_is_done(const char *out, const struct vw_job *job, const struct vw_job_record *record) {
    char *ledger = vw_format_text("%s/ledger.db", job->name);
    bool done = ledger && record->exit_code == 0 && vw_file_exists_inside(out, ledger);
    free(ledger);
    return done;
}

static enum vw_status take(const json_t *object, const struct vw_job *job, struct vw_job_record *record) {
    const json_t *code = json_object_get(object, "exit_code"), *seconds = json_object_get(object, "seconds");
    const char *message = json_string_value(json_object_get(object, "message"));
    json_t *words = words_to_json(job);
    bool same = words && json_equal(words, json_object_get(object, "words")) && json_is_integer(code) &&
                json_integer_value(code) >= 0 && json_integer_value(code) <= UINT8_MAX &&
                json_number_value(seconds) >= 0;
    json_decref(words);
    if (!same) return VW_OK;
    record->exit_code = (int)json_integer_value(code);
    record->seconds = json_number_value(seconds);
    if (message && *message && !(record->message = vw_copy_text(message))) return VW_ERROR_MEMORY;
    return VW_OK;
}

enum vw_status vw_job_record_read(const char *out, const struct vw_job *job, struct vw_job_record *record) {
    void *text = NULL;
    size_t size_bytes = 0;
    char *name = vw_format_text("%s.json", job->name);
    *record = (struct vw_job_record){.exit_code = -1};
    if (!name) return VW_ERROR_MEMORY;
    bool there = vw_file_exists_inside(out, name);
    enum vw_status status = there ? vw_file_read_inside(out, name, RECORD_BYTES_MAX, &text, &size_bytes) : VW_OK;
    json_t *object = !status && there ? vw_json_load(text, size_bytes, 0, NULL) : NULL;
    status = take(object, job, record);
    json_decref(object);
    free(text);
    free(name);
    return status;
}

enum vw_status vw_job_record_write(const char *out, const struct vw_job *job, const struct vw_job_record *record) {
    char *path = vw_format_text("%s/%s.json", out, job->name);
    json_t *object = json_pack("{s:o, s:i, s:f, s:s}", "words", words_to_json(job), "exit_code", record->exit_code,
                               "seconds", record->seconds, "message", record->message ? record->message : "");
    enum vw_status status = vw_json_write_file(path, object);
    free(path);
    return status;
}

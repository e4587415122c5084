// Files of ours, and what other programs give us: checkpoints, fields, splats, step logs, jobs, and what a report
// reads.
#include "fuzz/fuzz.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "batch/batch.h"
#include "interface.h"
#include "ledger/step_log.h"
#include "train/files/training_files.h"
#include "train/renderers/splats/splat_file.h"

enum { STATE_BYTES = 32, LAST_STEP = 100 };

void fuzz_checkpoint(const uint8_t *data, size_t size_bytes) {
    static const uint8_t run_id[VW_HASH_BYTES]; // 64 zeros in hexadecimal digits
    struct vw_hashed_file file;
    uint64_t step = UINT64_MAX;
    const char *path = fuzz_write_hashed("checkpoint_0.vwc", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_checkpoint_open(path, run_id, LAST_STEP, STATE_BYTES, &file, &step);
    fuzz_check_message(status);
    if (status) return;
    fuzz_check(step <= LAST_STEP, "the step is one up to the last");
    fuzz_check_hashed(&file, STATE_BYTES);
    vw_hashed_file_close(&file);
}

enum { PARAM_BYTES = 16 };

void fuzz_field(const uint8_t *data, size_t size_bytes) {
    struct vw_hashed_file file;
    const char *path = fuzz_write_hashed("field.vwf", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_field_file_open(path, "{\"param_bytes\":16}", PARAM_BYTES, &file);
    fuzz_check_message(status);
    if (status) return;
    fuzz_check_hashed(&file, PARAM_BYTES);
    vw_hashed_file_close(&file);
}

enum { SPLATS_MOST = 1000 };

void fuzz_splats(const uint8_t *data, size_t size_bytes) {
    struct vw_splat_file file;
    const char *path = fuzz_write("splats.ply", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_splat_file_read(path, SPLATS_MOST, &file);
    fuzz_check_message(status);
    if (!status) {
        fuzz_check(file.count > 0 && file.count <= SPLATS_MOST && file.degree <= VW_SPLAT_DEGREE_MAX,
                   "sizes are sound");
        for (size_t i = 0; i < (size_t)4 * VW_SPLAT_COLUMNS(file.degree) * file.count; i++)
            fuzz_check(isfinite(file.params[i]), "every number is finite");
    }
    vw_splat_file_free(&file);
}

void fuzz_steps(const uint8_t *data, size_t size_bytes) {
    struct vw_step_log log = {0};
    const char *path = fuzz_write("steps.csv", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_step_log_read(path, &log);
    fuzz_check_message(status);
    for (uint32_t i = 0; !status && i < log.record_count; i++) {
        const struct vw_step_record *record = &log.records[i];
        fuzz_check(record->step == i, "steps count from 0");
        fuzz_check(record->epoch < log.epochs, "an epoch is one of the log's");
        fuzz_check(i == 0 || record->view < log.image_count, "a step has a photo");
    }
    for (uint32_t i = 1; !status && i < log.image_count; i++)
        fuzz_check(strcmp(log.images[i - 1].name, log.images[i].name) < 0, "photos are in order, each once");
    vw_step_log_clear(&log);
}

// Returns whether a name stays below OUT: parts without dots, with single slashes between.
static bool is_place(const char *name) {
    bool part = false;
    for (; *name; name++) {
        if (*name == '.' || (*name == '/' && !part)) return false;
        part = *name != '/';
    }
    return part;
}

void fuzz_jobs(const uint8_t *data, size_t size_bytes) {
    struct vw_jobs jobs;
    const char *path = fuzz_write("jobs.json", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_jobs_load(path, &jobs);
    fuzz_check_message(status);
    fuzz_check(status || (jobs.count && jobs.count <= VW_JOBS_MAX), "there are as many jobs as are allowed");
    for (uint32_t i = 0; !status && i < jobs.count; i++) {
        const struct vw_job *job = &jobs.jobs[i];
        fuzz_check(is_place(job->name), "a job has a folder below OUT");
        char **words = vw_job_list_words(job, (char *[]){NULL});
        fuzz_check(words && words[1] && words[2] && words[3], "a job has words");
        for (uint32_t w = 0; words[w]; w++) fuzz_check(vw_text_is_clean(words[w]), "a word is clean text");
        for (uint32_t w = 3; words[w]; w++)
            fuzz_check(!strncmp(words[w], "--", 2) && words[w][2] != '=', "all but the scene are options");
        free(words);
    }
    vw_jobs_free(&jobs);
}

// Tries a table of a report; the first byte says which one.
void fuzz_tables(const uint8_t *data, size_t size_bytes) {
    static const char *const names[] = {"providers.csv", "payout.csv", "duplicates.csv", "tradeoff.csv", "summary.csv"};
    enum { NAME_COUNT = sizeof names / sizeof names[0] };
    const char *name = names[size_bytes ? data[0] % NAME_COUNT : 0];
    fuzz_check_report(name, data + (size_bytes > 0), size_bytes - (size_bytes > 0));
}

void fuzz_compare(const uint8_t *data, size_t size_bytes) { fuzz_check_report("compare.json", data, size_bytes); }

#include "fuzz/fuzz.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "batch/jobs.h"

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

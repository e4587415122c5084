#include "cli/commands/value_jobs.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/word_list.h"
#include "batch/child.h"
#include "cli/interrupt.h"
#include "cli/output/progress.h"
#include "cli/output/run_output.h"
#include "cli/params.h"
#include "gpu/compute.h"
#include "run/run.h"

_Static_assert((int)VW_CHILD_JOBS_MAX == (int)VW_TRAINERS_TOGETHER_MAX, "a device takes as many as a process gets");

struct job {
    uint64_t seed;
    char *out;                   // owned
    int log;                     // open
    struct vw_progress progress; // shown of the first one
    struct vw_run *run;          // NULL: not open
};

struct work {
    const struct vw_options *options;
    struct vw_session session;
    struct job jobs[VW_CHILD_JOBS_MAX];
    uint32_t count;
    enum vw_status status; // the first failure
    struct vw_saved_error why;
};

static void note(struct work *work, enum vw_status status) {
    if (work->status || !status) return;
    work->status = status;
    work->why = vw_error_save();
}

// ---- Jobs ---------------------------------------------------------------------------------------------------------

static enum vw_status add_job(struct work *work, struct vw_word seed) {
    char *folder = vw_path_folder(work->options->out), *end = NULL;
    struct job *job = &work->jobs[work->count];
    if (!folder) return VW_ERROR_MEMORY;
    job->seed = strtoull(seed.text, &end, 10);
    job->log = VW_CHILD_LOG + (int)work->count;
    job->out = vw_format_text("%s/seed-%" PRIu64, folder, job->seed);
    free(folder);
    if (end != seed.text + seed.length || fcntl(job->log, F_SETFD, FD_CLOEXEC))
        return vw_fail(VW_ERROR_USAGE, VW_CHILD_SEEDS_VARIABLE " is set, but not by viewworth batch; unset it");
    work->count++;
    return job->out ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status list_jobs(struct work *work, const char *seeds) {
    enum vw_status status = VW_OK;
    for (struct vw_word word; !status && work->count < VW_CHILD_JOBS_MAX && vw_word_list_next(&seeds, &word);)
        status = add_job(work, word);
    return status;
}

// What is said from here on is said of this job.
static enum vw_status take_log(const struct job *job) {
    fflush(stdout);
    if (dup2(job->log, STDOUT_FILENO) >= 0 && dup2(job->log, STDERR_FILENO) >= 0) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s.log: cannot be written: %s", job->out, strerror(errno));
}

// ---- Some at a time -----------------------------------------------------------------------------------------------

static enum vw_status open_job(struct work *work, struct job *job) {
    struct vw_config config = work->options->config;
    struct vw_run_params params;
    config.seed = job->seed;
    enum vw_status status = vw_params_of_run(work->options, &params);
    params.config = &config;
    params.out = job->out;
    params.progress = vw_progress_show;
    params.context = &job->progress;
    if (!status) status = take_log(job);
    return status ? status : vw_run_open_in_session(&params, &work->session, 0, &job->run);
}

static uint64_t device_bytes(const struct vw_session *session) {
    return session->device_count ? vw_gpu_buffer_bytes(session->devices[0].gpu) : 0;
}

// As many as fit: the first one shows how much of the device's memory each takes. Returns how many it tried.
static uint32_t open_jobs(struct work *work, struct job *jobs, uint32_t count) {
    uint32_t tried = 0, wanted = 1;
    uint64_t before = device_bytes(&work->session);
    for (; tried < count && tried < wanted; tried++) {
        jobs[tried].progress.quiet = work->options->quiet || tried;
        note(work, open_job(work, &jobs[tried]));
        if (!tried && jobs->run)
            wanted =
                vw_session_at_a_time(&work->session, work->options->together, device_bytes(&work->session) - before);
    }
    return tried;
}

static enum vw_status finish_job(struct job *job) {
    enum vw_status status = take_log(job);
    if (!status) status = vw_run_finish(job->run);
    return status ? status : vw_run_print(job->run, false, false);
}

static uint32_t make_some(struct work *work, struct job *jobs, uint32_t count) {
    struct vw_run *runs[VW_CHILD_JOBS_MAX];
    struct job *opened[VW_CHILD_JOBS_MAX];
    enum vw_status statuses[VW_CHILD_JOBS_MAX];
    uint32_t tried = open_jobs(work, jobs, count), open_count = 0;
    for (uint32_t i = 0; i < tried; i++) {
        if (!jobs[i].run) continue;
        jobs[i].progress.interrupt = vw_interrupt_watch();
        opened[open_count] = &jobs[i];
        runs[open_count++] = jobs[i].run;
    }
    if (open_count) note(work, take_log(opened[0])); // where progress is shown
    note(work, vw_runs_advance(runs, open_count, statuses));
    for (uint32_t i = 0; i < open_count; i++) {
        vw_progress_end(&opened[i]->progress);
        if (!statuses[i]) note(work, finish_job(opened[i]));
        vw_run_close(&opened[i]->run);
    }
    return tried;
}

enum vw_status vw_value_jobs(const struct vw_options *options, const char *seeds) {
    struct work *work = vw_allocate(1, sizeof *work);
    if (!work) return VW_ERROR_MEMORY;
    work->options = options;
    note(work, list_jobs(work, seeds));
    bool runs = !work->status;
    const struct vw_interrupt interrupt = vw_interrupt_watch();
    for (uint32_t done = 0; runs && done < work->count && !vw_interrupt_requested(&interrupt);)
        done += make_some(work, &work->jobs[done], work->count - done);
    for (uint32_t i = 0; i < VW_CHILD_JOBS_MAX; i++) free(work->jobs[i].out);
    vw_session_close(&work->session);
    enum vw_status status = work->status;
    if (status) vw_error_restore(&work->why);
    free(work);
    return status;
}

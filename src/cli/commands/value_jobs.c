#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "batch/child.h"
#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/answer.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "run/run.h"
#include "train/training_pool.h"

_Static_assert((int)VW_CHILD_JOBS_MAX == (int)VW_TRAINERS_TOGETHER_MAX, "a device takes as many as a process gets");

struct job {
    uint64_t seed;
    char *out; // owned
    int log;   // open
    struct vw_run *run;
    struct vw_progress progress;
};

struct work {
    const struct vw_options *options;
    struct vw_session session;
    struct job jobs[VW_CHILD_JOBS_MAX];
    uint32_t count;
    const struct job *shown; // later output is about it; NULL: none
    struct vw_first_failure failure;
};

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

// Sends all further output to the log of this job.
static enum vw_status take_log(const struct job *job) {
    fflush(stdout);
    if (dup2(job->log, STDOUT_FILENO) >= 0 && dup2(job->log, STDERR_FILENO) >= 0) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s.log: cannot be written: %s", job->out, strerror(errno));
}

// ---- Some at a time -----------------------------------------------------------------------------------------------

static enum vw_status begin_run(struct work *work, struct job *job, uint32_t device) {
    struct vw_config config = work->options->config;
    struct vw_run_params params;
    config.seed = job->seed;
    enum vw_status status = vw_params_of_run(work->options, &params);
    job->progress.quiet = work->options->quiet || work->shown != job;
    job->progress.interrupt = vw_interrupt_watch();
    params.config = &config;
    params.out = job->out;
    params.progress = vw_progress_show;
    params.context = &job->progress;
    if (!status) status = vw_run_open_in_session(&params, &work->session, device, &job->run);
    return status ? status : vw_run_begin(job->run, UINT64_MAX);
}

static enum vw_status finish_run(const struct job *job) {
    struct vw_answer answer;
    enum vw_status status = take_log(job);
    if (!status) status = vw_run_finish(job->run);
    if (!status) status = vw_run_print(job->run, false, false);
    if (!status) vw_answer_begin(job->run, job->out, &answer);
    return status ? status : vw_answer_print(&answer);
}

// Ends a job. Its failure ends no other.
static enum vw_status end_job(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    struct work *work = context;
    struct job *job = &work->jobs[seat->place];
    vw_progress_end(&job->progress);
    vw_first_failure_note(&work->failure, status ? status : finish_run(job));
    vw_run_close(&job->run);
    if (work->shown == job) work->shown = NULL;
    return VW_OK;
}

static enum vw_status begin_job(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct work *work = context;
    struct job *job = &work->jobs[seat->place];
    const struct vw_interrupt interrupt = vw_interrupt_watch();
    if (vw_interrupt_requested(&interrupt)) return vw_fail(VW_ERROR_INTERRUPTED, "interrupted before all jobs began");
    if (!work->shown) work->shown = job;
    enum vw_status status = take_log(job);
    if (!status) status = begin_run(work, job, seat->device);
    if (status) *answer = VW_POOL_NO_SEAT;
    if (status) (void)end_job(work, seat, status);
    if (work->shown) (void)take_log(work->shown);
    return VW_OK;
}

static enum vw_status advance_job(void *context, const struct vw_pool_seat *seat, bool *ended) {
    struct work *work = context;
    return vw_run_step(work->jobs[seat->place].run, ended);
}

// Opens the session, whose lines are in the log of the first job.
static enum vw_status open_session(struct work *work) {
    struct vw_run_params params;
    enum vw_status status = vw_params_of_run(work->options, &params);
    if (!status) status = take_log(&work->jobs[0]);
    const struct vw_session_params session = {
        .scene = params.scene, .devices.first = params.device, .timers = params.profile};
    return status ? status : vw_session_open(&session, &work->session);
}

enum vw_status vw_value_jobs(const struct vw_options *options, const char *seeds) {
    struct work *work = vw_allocate(1, sizeof *work);
    if (!work) return VW_ERROR_MEMORY;
    work->options = options;
    enum vw_status status = list_jobs(work, seeds);
    if (!status) status = open_session(work);
    const struct vw_training_pool pool = {.devices = work->session.devices,
                                          .device_count = work->session.device_count,
                                          .together = options->together,
                                          .begin = begin_job,
                                          .advance = advance_job,
                                          .end = end_job,
                                          .context = work};
    if (!status) status = vw_training_pool_run(&pool, work->count);
    vw_first_failure_note(&work->failure, status);
    for (uint32_t i = 0; i < VW_CHILD_JOBS_MAX; i++) free(work->jobs[i].out);
    vw_session_close(&work->session);
    status = vw_first_failure_report(&work->failure);
    free(work);
    return status;
}

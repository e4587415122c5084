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
#include "run/together.h"

_Static_assert((int)VW_CHILD_JOBS_MAX == (int)VW_TRAINERS_TOGETHER_MAX, "a device takes as many as a process gets");

struct job {
    uint64_t seed;
    char *out;                   // owned
    int log;                     // open
    struct vw_progress progress; // shown of the first one
};

struct work {
    const struct vw_options *options;
    struct vw_session session;
    struct job jobs[VW_CHILD_JOBS_MAX];
    uint32_t count, done; // done ones come first, then those that are made now
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

// Opens the run of a job. Later output is about the job whose progress is shown.
static enum vw_status open_job(void *context, uint32_t place, uint32_t device, struct vw_run **run) {
    struct work *work = context;
    struct job *job = &work->jobs[work->done + place];
    struct vw_config config = work->options->config;
    struct vw_run_params params;
    config.seed = job->seed;
    enum vw_status status = vw_params_of_run(work->options, &params);
    job->progress.quiet = work->options->quiet || place;
    job->progress.interrupt = vw_interrupt_watch();
    params.config = &config;
    params.out = job->out;
    params.progress = vw_progress_show;
    params.context = &job->progress;
    if (!status) status = take_log(job);
    if (!status) status = vw_run_open_in_session(&params, &work->session, device, run);
    if (!status) (void)take_log(&work->jobs[work->done]);
    return status;
}

static enum vw_status finish_job(void *context, uint32_t place, enum vw_status stepped, struct vw_run *run) {
    struct work *work = context;
    struct job *job = &work->jobs[work->done + place];
    vw_progress_end(&job->progress);
    if (stepped) return VW_OK;
    enum vw_status status = take_log(job);
    if (!status) status = vw_run_finish(run);
    if (!status) status = vw_run_print(run, false, false);
    struct vw_answer answer;
    if (!status) vw_answer_begin(run, job->out, &answer);
    return status ? status : vw_answer_print(&answer);
}

enum vw_status vw_value_jobs(const struct vw_options *options, const char *seeds) {
    struct work *work = vw_allocate(1, sizeof *work);
    if (!work) return VW_ERROR_MEMORY;
    work->options = options;
    vw_first_failure_note(&work->failure, list_jobs(work, seeds));
    bool runs = !work->failure.status;
    const struct vw_interrupt interrupt = vw_interrupt_watch();
    const struct vw_together_params together = {&work->session, options->together, open_job, finish_job, work};
    for (uint32_t made; runs && work->done < work->count && !vw_interrupt_requested(&interrupt); work->done += made)
        vw_first_failure_note(&work->failure, vw_together_make(&together, work->count - work->done, &made));
    for (uint32_t i = 0; i < VW_CHILD_JOBS_MAX; i++) free(work->jobs[i].out);
    vw_session_close(&work->session);
    enum vw_status status = vw_first_failure_report(&work->failure);
    free(work);
    return status;
}

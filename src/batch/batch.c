#include "batch/batch.h"

#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "batch/child.h"
#include "batch/jobs.h"
#include "run/out_lock.h"
#include "viewworth/log.h"

enum { LOOK_NS = 50000000, LOG_END_BYTES = 2048, SIGNAL_CODE = 128 };
// A killed batch's process may take so long to save what it has; then the job's own process says who writes there.
static const double LOCKED_WAIT_S = 30;

// Jobs of one process. Each is the first one of its process, or names it.
struct child {
    pid_t process; // process of the first; 0: none
    uint32_t first;
    double begun_s; // time at which the first began
    bool alone;     // a process of several jobs has failed: the next one takes no other
};

// The jobs that a process is to take, in their order.
struct group {
    uint32_t jobs[VW_CHILD_JOBS_MAX], count;
};

struct queue {
    const struct vw_batch_params *params;
    struct vw_batch *batch;
    struct child *children; // owned; by job
    uint32_t *on_device;    // owned: running jobs of each device
    uint32_t device_count;  // at least 1
    double started_s;
    bool stopping;
};

static const struct vw_job *job_at(const struct queue *queue, uint32_t job) { return &queue->batch->jobs->jobs[job]; }

// Returns a job's device, which may change its bits, so that it must not depend on which job ends first (decision 2).
static uint32_t device_of(const struct queue *queue, uint32_t job) { return job % queue->device_count; }

static void report(const struct queue *queue, const struct vw_job *ended) {
    if (queue->params->progress) queue->params->progress(queue->params->context, queue->batch, ended);
}

// ---- The state of every job ----------------------------------------------------------------------------------------

static const char *const state_names[] = {[VW_JOB_WAITING] = "waiting",
                                          [VW_JOB_RUNNING] = "running",
                                          [VW_JOB_DONE] = "done",
                                          [VW_JOB_FAILED] = "failed",
                                          [VW_JOB_STOPPED] = "stopped"};

static json_t *state_to_json(const struct vw_job *job, const struct vw_job_result *result) {
    json_t *code = result->exit_code < 0 ? json_null() : json_integer(result->exit_code);
    return json_pack("{s:s, s:s, s:o, s:f, s:o}", "name", job->name, "state", state_names[result->state], "exit_code",
                     code, "seconds", result->seconds, "message", vw_json_string(result->message));
}

static enum vw_status write_states(const struct vw_batch *batch, const char *out) {
    json_t *jobs = json_array();
    for (uint32_t i = 0; i < batch->jobs->count; i++)
        vw_json_append(&jobs, state_to_json(&batch->jobs->jobs[i], &batch->results[i]));
    char *path = vw_path_join(out, "batch.json");
    enum vw_status status = vw_json_write_file(path, json_pack("{s:o}", "jobs", jobs));
    free(path);
    return status;
}

// Merges the jobs that are done, in their order.
struct vw_summary_row *vw_summary_of_batch(const struct vw_batch *batch) {
    struct vw_summary_row *rows = vw_allocate(batch->jobs->count, sizeof *rows);
    uint32_t merged = 0;
    for (uint32_t i = 0; rows && i < batch->jobs->count; i++) {
        const struct vw_job_result *result = &batch->results[i];
        bool has_run = result->state == VW_JOB_DONE && merged < batch->merged.count;
        rows[i] = (struct vw_summary_row){.job = batch->jobs->jobs[i].name,
                                          .state = state_names[result->state],
                                          .exit_code = result->exit_code,
                                          .seconds = result->seconds,
                                          .run = has_run ? &batch->merged.runs[merged++] : NULL,
                                          .message = result->message};
    }
    return rows;
}

// ---- Starting -----------------------------------------------------------------------------------------------------

enum { OWN_WORDS = 3 };

// Writes the words that depend on where jobs run: owned texts, of which the last ones may be left out.
static enum vw_status make_own_words(const struct queue *queue, const struct group *group, char *own[OWN_WORDS]) {
    const struct vw_batch_params *params = queue->params;
    uint32_t first = group->jobs[0], count = 0;
    const char *device = params->device_count ? params->devices[device_of(queue, first)] : NULL;
    bool together = group->count > 1 && params->together_given;
    bool made = (own[count++] = vw_format_text("--out=%s/%s", params->out, job_at(queue, first)->name));
    if (made && device) made = (own[count++] = vw_format_text("--device=%s", device));
    if (made && together) made = (own[count++] = vw_format_text("--together=%u", params->together));
    return made ? VW_OK : VW_ERROR_MEMORY;
}

// Joins the program's name, the first job's words, and its own. The array is owned by the caller.
static char **make_words(const struct vw_job *job, char *const own[OWN_WORDS]) {
    char **words = vw_allocate(job->word_count + OWN_WORDS + 3, sizeof *words), **next = words;
    if (!words) return NULL;
    *next++ = "viewworth";
    memcpy(next, job->words, job->word_count * sizeof *next);
    next += job->word_count;
    *next++ = "--resume";
    for (uint32_t i = 0; i < OWN_WORDS; i++) *next++ = own[i];
    return words;
}

// Returns "0,1,2" for vw_child_start(), owned by the caller; "" for a single job.
static char *list_seeds(const struct queue *queue, const struct group *group) {
    char *list = vw_copy_text("");
    for (uint32_t i = 0; list && group->count > 1 && i < group->count; i++) {
        char *longer = vw_format_text("%s%s%" PRIu64, list, i ? "," : "", job_at(queue, group->jobs[i])->seed);
        free(list);
        list = longer;
    }
    return list;
}

// Names the logs, which are owned by the caller, and makes the folder that they and the jobs' own ones are in.
static enum vw_status make_folder(const struct queue *queue, const struct group *group, char **log_paths) {
    const char *out = queue->params->out;
    char *folder = vw_path_folder(job_at(queue, group->jobs[0])->name);
    enum vw_status status = folder ? vw_folder_create_inside(out, folder) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < group->count; i++) {
        const char *name = job_at(queue, group->jobs[i])->name;
        status = vw_folder_check_inside(out, name);
        log_paths[i] = vw_format_text("%s/%s.log", out, name);
        if (!status && !log_paths[i]) status = VW_ERROR_MEMORY;
    }
    free(folder);
    return status;
}

static enum vw_status start_process(struct queue *queue, const struct group *group, pid_t *process) {
    char *own[OWN_WORDS] = {NULL}, *log_paths[VW_CHILD_JOBS_MAX] = {NULL}, *seeds = list_seeds(queue, group);
    enum vw_status status = make_own_words(queue, group, own);
    char **words = make_words(job_at(queue, group->jobs[0]), own);
    if (!status && !(words && seeds)) status = VW_ERROR_MEMORY;
    if (!status) status = make_folder(queue, group, log_paths);
    const struct vw_child_params params = {.program = queue->params->program,
                                           .words = words,
                                           .seeds = seeds,
                                           .log_paths = (const char *const *)log_paths,
                                           .job_count = group->count};
    if (!status) status = vw_child_start(&params, process);
    for (int i = 0; i < OWN_WORDS; i++) free(own[i]);
    for (uint32_t i = 0; i < group->count; i++) free(log_paths[i]);
    free(seeds);
    free(words);
    return status;
}

// Returns whether another process still writes into the job's folder. It does not create a missing folder: another
// process may be about to.
static bool is_locked(const struct queue *queue, uint32_t job) {
    struct vw_out_lock *lock = NULL;
    if (vw_folder_check_inside(queue->params->out, job_at(queue, job)->name)) return false; // start() says why
    char *out = vw_format_text("%s/%s", queue->params->out, job_at(queue, job)->name);
    bool locked = out && vw_folder_exists(out) && vw_out_lock_take(out, &lock) == VW_ERROR_USAGE;
    vw_out_lock_release(&lock);
    free(out);
    return locked && vw_now_s() - queue->started_s < LOCKED_WAIT_S;
}

static bool can_start(const struct queue *queue, uint32_t job) {
    bool wanted = !queue->params->only || queue->params->only == job + 1;
    return wanted && queue->batch->results[job].state == VW_JOB_WAITING && !is_locked(queue, job);
}

// Finds a job and those after it that can run together with it. They have its device, as if each ran alone.
static struct group find_group(const struct queue *queue, uint32_t first) {
    struct group group = {{first}, 1};
    uint32_t most = queue->children[first].alone ? 1 : queue->params->together;
    for (uint32_t i = first + 1; group.count < most && i < queue->batch->jobs->count; i++)
        if (device_of(queue, i) == device_of(queue, first) && !queue->children[i].alone &&
            vw_jobs_fit(job_at(queue, first), job_at(queue, i)) && can_start(queue, i))
            group.jobs[group.count++] = i;
    return group;
}

static enum vw_status start(struct queue *queue, const struct group *group) {
    struct vw_batch *batch = queue->batch;
    uint32_t first = group->jobs[0];
    enum vw_status status = start_process(queue, group, &queue->children[first].process);
    if (status) return status;
    for (uint32_t i = 0; i < group->count; i++) {
        batch->results[group->jobs[i]].state = VW_JOB_RUNNING;
        queue->children[group->jobs[i]].first = first;
    }
    batch->running += group->count;
    queue->on_device[device_of(queue, first)]++;
    queue->children[first].begun_s = vw_now_s();
    return VW_OK;
}

static enum vw_status start_waiting(struct queue *queue) {
    uint32_t most = queue->params->per_device ? queue->params->per_device : 1;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < queue->batch->jobs->count; i++) {
        if (queue->on_device[device_of(queue, i)] >= most || !can_start(queue, i)) continue;
        const struct group group = find_group(queue, i);
        status = start(queue, &group);
    }
    return status;
}

// ---- Ending -------------------------------------------------------------------------------------------------------

// Returns the last line of a job's log, owned by the caller; NULL if there is none.
static char *read_last_line(const char *out, const struct vw_job *job) {
    static const char own[] = "viewworth: ";
    char text[LOG_END_BYTES + 1], *name = vw_format_text("%s.log", job->name), *line = text;
    int descriptor = -1;
    ssize_t got = -1;
    if (name && !vw_file_open_inside(out, name, &descriptor)) {
        off_t end = lseek(descriptor, 0, SEEK_END);
        got = pread(descriptor, text, LOG_END_BYTES, end > LOG_END_BYTES ? end - LOG_END_BYTES : 0);
        close(descriptor);
    }
    free(name);
    while (got > 0 && (text[got - 1] == '\n' || text[got - 1] == '\r' || !text[got - 1])) got--;
    if (got <= 0) return NULL;
    text[got] = 0;
    for (ssize_t i = 0; i < got; i++)
        if (text[i] == '\n' || text[i] == '\r' || !text[i]) line = text + i + 1;
    vw_text_make_line(line);
    return vw_copy_text(strncmp(line, own, strlen(own)) ? line : line + strlen(own));
}

static char *describe_failure(const struct queue *queue, uint32_t job, int exit_code) {
    if (exit_code > SIGNAL_CODE)
        return vw_format_text("signal %d (%s) ended it", exit_code - SIGNAL_CODE, strsignal(exit_code - SIGNAL_CODE));
    char *line = read_last_line(queue->params->out, job_at(queue, job));
    return line ? line : vw_format_text("exit code %d without a message", exit_code);
}

static void count_states(struct vw_batch *batch) {
    batch->done = batch->failed = batch->running = 0;
    for (uint32_t i = 0; i < batch->jobs->count; i++) {
        batch->done += batch->results[i].state == VW_JOB_DONE;
        batch->failed += batch->results[i].state == VW_JOB_FAILED;
        batch->running += batch->results[i].state == VW_JOB_RUNNING;
    }
}

static enum vw_status end_job(struct queue *queue, uint32_t job, int exit_code, double seconds) {
    struct vw_job_result *result = &queue->batch->results[job];
    result->exit_code = exit_code;
    result->seconds += seconds;
    result->state = !exit_code ? VW_JOB_DONE : queue->stopping ? VW_JOB_STOPPED : VW_JOB_FAILED;
    if (result->state == VW_JOB_FAILED) result->message = describe_failure(queue, job, exit_code);
    enum vw_status status = exit_code ? VW_OK : vw_job_result_note_run(queue->params->out, job_at(queue, job), result);
    count_states(queue->batch);
    if (!status) status = vw_job_result_write(queue->params->out, job_at(queue, job), result);
    if (!status && !queue->params->only) status = write_states(queue->batch, queue->params->out);
    report(queue, job_at(queue, job));
    return status;
}

// Runs each job of a failed group alone, since it is not known which of them failed. A job that is done then ends at
// once.
static void try_alone(struct queue *queue, uint32_t job, double seconds) {
    queue->children[job].alone = true;
    queue->batch->results[job].state = VW_JOB_WAITING;
    queue->batch->results[job].seconds += seconds;
    count_states(queue->batch);
}

// Divides the time of a process among its jobs.
static enum vw_status end_process(struct queue *queue, uint32_t first, int wait_status) {
    struct group group = {.count = 0};
    enum vw_status status = VW_OK;
    for (uint32_t i = first; i < queue->batch->jobs->count; i++)
        if (queue->batch->results[i].state == VW_JOB_RUNNING && queue->children[i].first == first)
            group.jobs[group.count++] = i;
    int exit_code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : SIGNAL_CODE + WTERMSIG(wait_status);
    double seconds = (vw_now_s() - queue->children[first].begun_s) / group.count;
    queue->children[first].process = 0;
    queue->on_device[device_of(queue, first)]--;
    for (uint32_t i = 0; i < group.count; i++) {
        if (group.count > 1 && exit_code && !queue->stopping) {
            try_alone(queue, group.jobs[i], seconds);
            continue;
        }
        enum vw_status ended = end_job(queue, group.jobs[i], exit_code, seconds);
        if (!status) status = ended;
    }
    return status;
}

static enum vw_status end_finished(struct queue *queue) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < queue->batch->jobs->count; i++) {
        int wait_status = 0;
        pid_t process = queue->children[i].process;
        if (!process || waitpid(process, &wait_status, WNOHANG) != process) continue;
        enum vw_status ended = end_process(queue, i, wait_status);
        if (!status) status = ended;
    }
    return status;
}

// Sends a signal other than SIGINT, which a shell's background processes ignore from the start.
static void stop_all(struct queue *queue) {
    if (queue->stopping) return;
    queue->stopping = true;
    for (uint32_t i = 0; i < queue->batch->jobs->count; i++)
        if (queue->children[i].process) kill(queue->children[i].process, SIGTERM);
}

// ---- The queue ----------------------------------------------------------------------------------------------------

static bool has_waiting(const struct queue *queue) {
    const struct vw_job_result *results = queue->batch->results;
    if (queue->params->only) return results[queue->params->only - 1].state == VW_JOB_WAITING;
    for (uint32_t i = 0; i < queue->batch->jobs->count; i++)
        if (results[i].state == VW_JOB_WAITING) return true;
    return false;
}

// Stops all jobs and starts no more after a failure of its own, such as a full disk.
static enum vw_status run_queue(struct queue *queue) {
    enum vw_status status = VW_OK;
    queue->started_s = vw_now_s();
    signal(SIGCHLD, SIG_DFL); // a parent may have ignored it; then no one would learn how a job ended
    while (queue->batch->running || (has_waiting(queue) && !queue->stopping)) {
        if (status || vw_interrupt_requested(&queue->params->interrupt)) stop_all(queue);
        enum vw_status ended = end_finished(queue);
        if (!status) status = ended;
        if (!status && !queue->stopping) status = start_waiting(queue);
        report(queue, NULL);
        nanosleep(&(struct timespec){.tv_nsec = LOOK_NS}, NULL);
    }
    return status;
}

// Reads the records of all jobs; of job `only` alone, counted from 1, where one is named.
static enum vw_status read_records(struct vw_batch *batch, const char *out, uint32_t only) {
    enum vw_status status = VW_OK;
    for (uint32_t i = only ? only - 1 : 0; !status && i < (only ? only : batch->jobs->count); i++)
        status = vw_job_result_read(out, &batch->jobs->jobs[i], &batch->results[i]);
    count_states(batch);
    return status;
}

// Clears failures, so that a job that failed is tried again.
static void forget_failures(struct vw_batch *batch) {
    for (uint32_t i = 0; i < batch->jobs->count; i++) {
        struct vw_job_result *result = &batch->results[i];
        if (result->state != VW_JOB_FAILED) continue;
        free(result->message);
        *result = (struct vw_job_result){.state = VW_JOB_WAITING, .exit_code = -1, .seconds = result->seconds};
    }
    count_states(batch);
}

static enum vw_status run_jobs(const struct vw_batch_params *params, struct vw_batch *batch) {
    struct queue queue = {.params = params,
                          .batch = batch,
                          .device_count = params->device_count ? params->device_count : 1,
                          .children = vw_allocate(batch->jobs->count, sizeof *queue.children)};
    queue.on_device = vw_allocate(queue.device_count, sizeof *queue.on_device);
    enum vw_status status =
        queue.children && queue.on_device ? read_records(batch, params->out, params->only) : VW_ERROR_MEMORY;
    if (!status && !params->merge_only) {
        forget_failures(batch);
        uint32_t left = params->only ? 0 : batch->jobs->count - batch->done;
        if (left) vw_log_info("batch    %u job%s; Ctrl-C keeps what is done", left, vw_plural(left));
        status = run_queue(&queue);
    }
    if (!status && queue.stopping && has_waiting(&queue)) status = VW_ERROR_INTERRUPTED;
    for (uint32_t i = 0; !status && i < batch->jobs->count; i++)
        if (batch->results[i].state == VW_JOB_STOPPED) status = VW_ERROR_INTERRUPTED;
    if (status == VW_ERROR_INTERRUPTED)
        status = vw_fail(status, "%s: stopped; the same command resumes it", params->out);
    free(queue.children);
    free(queue.on_device);
    return status;
}

// ---- The results --------------------------------------------------------------------------------------------------

static enum vw_status merge(const struct vw_batch_params *params, struct vw_batch *batch) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < batch->jobs->count; i++) {
        if (batch->results[i].state != VW_JOB_DONE) continue;
        status = vw_job_result_check(params->out, &batch->jobs->jobs[i], &batch->results[i]); // since it ended
        if (status || batch->results[i].state != VW_JOB_DONE) continue;
        char *folder = vw_path_join(params->out, batch->jobs->jobs[i].name);
        status = folder ? vw_merged_runs_add(&batch->merged, batch->jobs->jobs[i].name, folder) : VW_ERROR_MEMORY;
        free(folder);
    }
    count_states(batch);
    if (!status && batch->merged.count) status = vw_merge_write(params->out, &batch->merged);
    struct vw_summary_row *rows = status ? NULL : vw_summary_of_batch(batch);
    if (!status) status = rows ? vw_summary_write(params->out, rows, batch->jobs->count) : VW_ERROR_MEMORY;
    free(rows);
    return status ? status : write_states(batch, params->out);
}

static enum vw_status fail_jobs(const struct vw_batch_params *params, const struct vw_batch *batch) {
    uint32_t first = 0;
    while (batch->results[first].state != VW_JOB_FAILED) first++;
    const struct vw_job_result *result = &batch->results[first];
    return vw_fail(VW_ERROR_IO, "%s: %u of %u jobs failed; %s tries them again; the first is %s: %s", params->out,
                   batch->failed, params->only ? 1 : batch->jobs->count,
                   params->merge_only ? "a batch" : "the same command", batch->jobs->jobs[first].name,
                   result->message ? result->message : "out of memory");
}

static enum vw_status check(const struct vw_batch_params *params) {
    enum vw_status status = vw_merge_check_out(params->out);
    if (!status && params->only > params->jobs->count)
        status =
            vw_fail(VW_ERROR_USAGE, "--job %u: there are %u jobs; name one of them", params->only, params->jobs->count);
    return status;
}

static enum vw_status create(const struct vw_jobs *jobs, struct vw_batch *batch) {
    *batch = (struct vw_batch){.jobs = jobs, .results = vw_allocate(jobs->count, sizeof *batch->results)};
    return batch->results ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_batch_look(const struct vw_jobs *jobs, const char *out, struct vw_batch *batch) {
    enum vw_status status = create(jobs, batch);
    if (!status) status = check(&(struct vw_batch_params){.jobs = jobs, .out = out});
    return status ? status : read_records(batch, out, 0);
}

enum vw_status vw_batch_make(const struct vw_batch_params *params, struct vw_batch *batch) {
    struct vw_out_lock *lock = NULL;
    enum vw_status status = create(params->jobs, batch);
    if (!status) status = check(params);
    if (!status) status = params->only ? vw_folder_create(params->out) : vw_out_lock_take(params->out, &lock);
    if (!status) status = run_jobs(params, batch);
    if (!status && !params->only) status = merge(params, batch);
    vw_out_lock_release(&lock);
    if (!status && !params->only) vw_merge_report(params->out, &batch->merged); // locks OUT
    return !status && batch->failed ? fail_jobs(params, batch) : status;
}

void vw_batch_free(struct vw_batch *batch) {
    for (uint32_t i = 0; batch->results && i < batch->jobs->count; i++) free(batch->results[i].message);
    free(batch->results);
    vw_merged_runs_free(&batch->merged);
    *batch = (struct vw_batch){0};
}

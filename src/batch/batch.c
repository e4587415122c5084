#include "batch/batch.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_stream.h"
#include "run/out_folder.h"
#include "viewworth/log.h"

enum { LOOK_NS = 50000000, SIGNAL_CODE = 128, RECORD_BYTES_MAX = 1 << 20, LOG_BYTES_MAX = 1 << 26 };
enum { INPUT, OUTPUT, ERRORS }; // the descriptors that a process begins with
// A killed batch's process may take so long to save what it has; then the job's own process says who writes there.
static const double LOCKED_WAIT_S = 30;

struct child {
    pid_t process; // 0: none
    double begun_s;
};

struct queue {
    const struct vw_batch_params *params;
    struct vw_batch *batch;
    struct child *children; // owned; by job
    double started_s;
    bool stopping;
};

// ---- Records -------------------------------------------------------------------------------------------------------

static enum vw_status write_record(const struct vw_job *job, const struct vw_batch_row *row) {
    char *path = vw_format_text("%s.json", row->folder);
    json_t *record = json_pack("{s:O, s:i, s:f, s:o}", "words", job->words, "exit_code", row->exit_code, "seconds",
                               row->seconds, "message", vw_json_string(row->message));
    enum vw_status status = vw_json_write_file(path, record);
    free(path);
    return status;
}

// Takes what a record says that has the job's words; anything else is as if no process had ended.
static enum vw_status take_record(const json_t *record, const struct vw_job *job, struct vw_batch_row *row) {
    const json_t *code = json_object_get(record, "exit_code"), *seconds = json_object_get(record, "seconds");
    if (!json_equal(json_object_get(record, "words"), job->words) || !json_is_integer(code) ||
        !(json_number_value(seconds) >= 0))
        return VW_OK;
    char *ledger = vw_path_join(row->folder, "ledger.db");
    row->seconds = json_number_value(seconds);
    if (ledger && !json_integer_value(code) && vw_file_exists(ledger)) row->state = VW_JOB_DONE;
    if (row->state == VW_JOB_DONE) row->exit_code = 0;
    free(ledger);
    return ledger ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status read_record(const struct vw_job *job, struct vw_batch_row *row) {
    void *text = NULL;
    size_t size_bytes = 0;
    char *path = vw_format_text("%s.json", row->folder);
    bool read = path && vw_file_exists(path) && !vw_file_read(path, RECORD_BYTES_MAX, &text, &size_bytes);
    json_t *record = read ? vw_json_load(text, size_bytes, 0, NULL) : NULL;
    enum vw_status status = path ? take_record(record, job, row) : VW_ERROR_MEMORY;
    json_decref(record);
    free(text);
    free(path);
    return status;
}

static void count_states(struct vw_batch *batch) {
    batch->done = batch->failed = batch->running = 0;
    for (uint32_t i = 0; i < batch->rows.count; i++) {
        batch->done += batch->rows.rows[i].state == VW_JOB_DONE;
        batch->failed += batch->rows.rows[i].state == VW_JOB_FAILED;
        batch->running += batch->rows.rows[i].state == VW_JOB_RUNNING;
    }
}

enum vw_status vw_batch_look(const struct vw_jobs *jobs, const char *out, struct vw_batch *batch) {
    *batch = (struct vw_batch){.jobs = jobs};
    enum vw_status status = vw_merge_check_out(out);
    for (uint32_t i = 0; !status && i < jobs->count; i++) {
        char *folder = vw_path_join(out, jobs->jobs[i].name);
        status = folder ? vw_batch_rows_add(&batch->rows, jobs->jobs[i].name, folder) : VW_ERROR_MEMORY;
        if (!status) status = read_record(&jobs->jobs[i], &batch->rows.rows[i]);
        free(folder);
    }
    count_states(batch);
    return status;
}

// ---- Starting -----------------------------------------------------------------------------------------------------

// Returns a job's device, which may change its bits, so that it must not depend on which job ends first (decision 2).
static uint32_t device_of(const struct queue *queue, uint32_t job) {
    return queue->params->device_count ? job % queue->params->device_count : 0;
}

// Spawns this program in a process group of its own, which Ctrl-C does not reach.
static int spawn(char *const *words, const char *log, pid_t *process) {
    const int to_log = O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY;
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    int error = posix_spawn_file_actions_init(&files);
    if (!error) error = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    if (!error) error = posix_spawn_file_actions_addopen(&files, INPUT, "/dev/null", O_RDONLY, 0);
    if (!error) error = posix_spawn_file_actions_addopen(&files, OUTPUT, log, to_log, 0666);
    if (!error) error = posix_spawn_file_actions_adddup2(&files, OUTPUT, ERRORS);
    if (!error) error = posix_spawn_file_actions_addclosefrom_np(&files, ERRORS + 1);
    if (!error) error = posix_spawn(process, "/proc/self/exe", &files, &attributes, words, environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return error;
}

static enum vw_status start_process(const struct vw_batch_row *row, char *const *words, pid_t *process) {
    char *log = vw_format_text("%s.log", row->folder), *folder = vw_path_folder(row->folder);
    enum vw_status status = log && folder ? vw_folder_create(folder) : VW_ERROR_MEMORY;
    int error = status ? 0 : spawn(words, log, process);
    if (error)
        status = vw_fail(VW_ERROR_IO, "%s: cannot start a process that writes there: %s; check the folder", log,
                         strerror(error));
    free(log);
    free(folder);
    return status;
}

static enum vw_status start(struct queue *queue, uint32_t job) {
    struct vw_batch_row *row = &queue->batch->rows.rows[job];
    const struct vw_batch_params *params = queue->params;
    char *out = vw_format_text("--out=%s", row->folder), *device = NULL, resume[] = "--resume";
    if (params->device_count) device = vw_format_text("--device=%s", params->devices[device_of(queue, job)]);
    char *more[] = {resume, out, device, NULL}, **words = vw_job_list_words(&params->jobs->jobs[job], more);
    bool made = out && words && (device || !params->device_count);
    enum vw_status status = made ? start_process(row, words, &queue->children[job].process) : VW_ERROR_MEMORY;
    if (!status) row->state = VW_JOB_RUNNING;
    queue->children[job].begun_s = vw_now_s();
    count_states(queue->batch);
    free(out);
    free(device);
    free(words);
    return status;
}

// Returns whether another process still writes into the job's folder, which is not created here.
static bool is_locked(const struct queue *queue, const char *folder) {
    struct vw_out_lock *lock = NULL;
    bool locked = vw_folder_exists(folder) && vw_out_lock_take(folder, &lock) == VW_ERROR_USAGE;
    vw_out_lock_release(&lock);
    return locked && vw_now_s() - queue->started_s < LOCKED_WAIT_S;
}

static bool is(const struct queue *queue, uint32_t job, enum vw_job_state state) {
    bool wanted = !queue->params->only || queue->params->only == job + 1;
    return wanted && queue->batch->rows.rows[job].state == state;
}

static enum vw_status start_waiting(struct queue *queue) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < queue->batch->rows.count; i++) {
        uint32_t beside = 0;
        if (!is(queue, i, VW_JOB_WAITING)) continue;
        for (uint32_t k = 0; k < queue->batch->rows.count; k++)
            beside += queue->children[k].process && device_of(queue, k) == device_of(queue, i);
        if (beside < queue->params->per_device && !is_locked(queue, queue->batch->rows.rows[i].folder))
            status = start(queue, i);
    }
    return status;
}

// ---- Ending -------------------------------------------------------------------------------------------------------

// Returns the last line of a job's log, owned by the caller; NULL if there is none.
static char *read_last_line(const char *path) {
    static const char own[] = "viewworth: ";
    void *text = NULL;
    size_t end = 0;
    if (vw_file_read(path, LOG_BYTES_MAX, &text, &end)) return NULL;
    char *log = text, *line;
    while (end && (log[end - 1] == '\n' || log[end - 1] == '\r')) log[--end] = 0;
    line = strrchr(log, '\n') ? strrchr(log, '\n') + 1 : log;
    vw_text_make_line(line);
    line = *line ? vw_copy_text(strncmp(line, own, strlen(own)) ? line : line + strlen(own)) : NULL;
    free(text);
    return line;
}

static char *describe_failure(const struct vw_batch_row *row) {
    if (row->exit_code > SIGNAL_CODE)
        return vw_format_text("signal %d (%s) ended it", row->exit_code - SIGNAL_CODE,
                              strsignal(row->exit_code - SIGNAL_CODE));
    char *path = vw_format_text("%s.log", row->folder), *line = path ? read_last_line(path) : NULL;
    free(path);
    return line ? line : vw_format_text("exit code %d without a message", row->exit_code);
}

static enum vw_status end(struct queue *queue, uint32_t job, int wait_status) {
    struct vw_batch_row *row = &queue->batch->rows.rows[job];
    double seconds = vw_now_s() - queue->children[job].begun_s;
    queue->children[job].process = 0;
    row->exit_code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : SIGNAL_CODE + WTERMSIG(wait_status);
    row->seconds = round(10 * (seconds + (row->seconds > 0 ? row->seconds : 0))) / 10; // NaN: none ended before
    row->state = !row->exit_code ? VW_JOB_DONE : queue->stopping ? VW_JOB_STOPPED : VW_JOB_FAILED;
    if (row->state == VW_JOB_FAILED) row->message = describe_failure(row);
    count_states(queue->batch);
    enum vw_status status = write_record(&queue->batch->jobs->jobs[job], row);
    if (!status && !queue->params->only) status = vw_batch_rows_write(queue->params->out, &queue->batch->rows);
    queue->params->progress(queue->params->context, queue->batch, row);
    return status;
}

static enum vw_status end_finished(struct queue *queue) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < queue->batch->rows.count; i++) {
        int wait_status = 0;
        pid_t process = queue->children[i].process;
        if (!process || waitpid(process, &wait_status, WNOHANG) != process) continue;
        enum vw_status ended = end(queue, i, wait_status);
        if (!status) status = ended;
    }
    return status;
}

// Sends a signal other than SIGINT, which a shell's background processes ignore from the start.
static void stop_all(struct queue *queue) {
    if (queue->stopping) return;
    queue->stopping = true;
    for (uint32_t i = 0; i < queue->batch->rows.count; i++)
        if (queue->children[i].process) kill(queue->children[i].process, SIGTERM);
}

// ---- The queue ----------------------------------------------------------------------------------------------------

static bool has(const struct queue *queue, enum vw_job_state state) {
    for (uint32_t i = 0; i < queue->batch->rows.count; i++)
        if (is(queue, i, state)) return true;
    return false;
}

// Stops all jobs and starts no more after a failure of its own, such as a full disk.
static enum vw_status run_queue(struct queue *queue) {
    char process[32];
    enum vw_status status = VW_OK;
    snprintf(process, sizeof process, "%ld", (long)getpid());
    setenv(VW_BATCH_PROCESS_VARIABLE, process, true); // for the jobs
    signal(SIGCHLD, SIG_DFL); // a parent may have ignored it; then no one would learn how a job ended
    while (queue->batch->running || (has(queue, VW_JOB_WAITING) && !queue->stopping)) {
        if (status || vw_interrupt_requested(&queue->params->interrupt)) stop_all(queue);
        enum vw_status ended = end_finished(queue);
        if (!status) status = ended;
        if (!status && !queue->stopping) status = start_waiting(queue);
        queue->params->progress(queue->params->context, queue->batch, NULL);
        nanosleep(&(struct timespec){.tv_nsec = LOOK_NS}, NULL);
    }
    if (!status && (has(queue, VW_JOB_WAITING) || has(queue, VW_JOB_STOPPED)))
        status = vw_fail(VW_ERROR_INTERRUPTED, "%s: stopped; the same command resumes it", queue->params->out);
    return status;
}

static enum vw_status run_jobs(const struct vw_batch_params *params, struct vw_batch *batch) {
    struct queue queue = {.params = params,
                          .batch = batch,
                          .started_s = vw_now_s(),
                          .children = vw_allocate(batch->rows.count, sizeof *queue.children)};
    uint32_t left = params->only ? 0 : batch->rows.count - batch->done;
    if (left) vw_log_info("batch    %u job%s; Ctrl-C keeps what is done", left, vw_plural(left));
    enum vw_status status = queue.children ? run_queue(&queue) : VW_ERROR_MEMORY;
    free(queue.children);
    return status;
}

// Looks again, since others run the other jobs, and locks OUT where all are done. Another one may merge already.
static enum vw_status look_after_one(const struct vw_batch_params *params, struct vw_batch *batch,
                                     struct vw_out_lock **lock) {
    if (batch->failed) return VW_OK;
    vw_batch_rows_free(&batch->rows);
    enum vw_status status = vw_batch_look(params->jobs, params->out, batch);
    if (!status && batch->done == batch->rows.count) (void)vw_out_lock_take(params->out, lock);
    return status;
}

static enum vw_status check_failed(const struct vw_batch_params *params, const struct vw_batch *batch) {
    const struct vw_batch_row *row = batch->rows.rows;
    if (!batch->failed) return VW_OK;
    while (row->state != VW_JOB_FAILED) row++;
    return vw_fail(VW_ERROR_IO, "%s: %u of %u jobs failed; the same command tries them again; the first is %s: %s",
                   params->out, batch->failed, params->only ? 1 : batch->rows.count, row->job,
                   row->message ? row->message : "out of memory");
}

enum vw_status vw_batch_make(const struct vw_batch_params *params, struct vw_batch *batch) {
    struct vw_out_lock *lock = NULL;
    enum vw_status status = vw_batch_look(params->jobs, params->out, batch);
    if (!status && params->only > batch->rows.count)
        status =
            vw_fail(VW_ERROR_USAGE, "--job %u: there are %u jobs; name one of them", params->only, batch->rows.count);
    if (!status) status = params->only ? vw_folder_create(params->out) : vw_out_lock_take(params->out, &lock);
    if (!status) status = run_jobs(params, batch);
    if (!status && params->only) status = look_after_one(params, batch, &lock);
    bool merges = lock != NULL;
    if (!status && merges) status = vw_batch_rows_merge(params->out, &batch->rows);
    vw_out_lock_release(&lock);
    if (!status && merges) vw_batch_rows_report(params->out, &batch->rows); // locks OUT
    return status ? status : check_failed(params, batch);
}

void vw_batch_free(struct vw_batch *batch) {
    vw_batch_rows_free(&batch->rows);
    *batch = (struct vw_batch){0};
}

// ---- Slurm ----------------------------------------------------------------------------------------------------------

enum { WORDS_MAX = 16 };

// A job runs in the folder where sbatch was called. See https://slurm.schedmd.com/sbatch.html.
static const char script[] =
    "#!/bin/bash\n"
    "# Made by viewworth batch --slurm, which makes it again.\n"
    "#SBATCH --job-name=viewworth --open-mode=append --requeue --signal=B:USR1@90\n"
    "\"$@\" --job \"$SLURM_ARRAY_TASK_ID\" &\n"
    "process=$!\n"
    "# Shortly before the time limit Slurm sends USR1: the job saves what it has, and is queued again.\n"
    "limit=\n"
    "trap 'limit=near; kill -TERM \"$process\"' USR1\n"
    "trap 'kill -TERM \"$process\"' TERM INT\n"
    "wait \"$process\"\n"
    "while kill -0 \"$process\" 2>/dev/null; do wait \"$process\"; done # a signal ends a wait\n"
    "wait \"$process\" # which tells its exit code once more\n"
    "code=$?\n"
    "[[ -n $limit && $code -ne 0 ]] && scontrol requeue \"$SLURM_JOB_ID\" && exit\n"
    "exit \"$code\"\n";

// Returns "--array=1,3-5", the numbers of the jobs that wait. Owned by the caller.
static enum vw_status write_array(const struct vw_batch *batch, char **array) {
    struct vw_text_stream text;
    size_t size_bytes = 0;
    const char *separator = "--array=";
    FILE *stream = vw_text_stream_open(&text);
    for (uint32_t i = 0; stream && i < batch->rows.count; i++) {
        if (batch->rows.rows[i].state == VW_JOB_DONE) continue;
        uint32_t first = i;
        while (i + 1 < batch->rows.count && batch->rows.rows[i + 1].state != VW_JOB_DONE) i++;
        fprintf(stream, "%s%" PRIu32, separator, first + 1);
        if (i > first) fprintf(stream, "-%" PRIu32, i + 1);
        separator = ",";
    }
    return vw_text_stream_close(&text, "the array", array, &size_bytes);
}

static enum vw_status run_sbatch(char *const *words) {
    pid_t process = 0;
    int wait_status = 0, error = posix_spawnp(&process, words[0], NULL, NULL, words, environ);
    if (error) return vw_fail(VW_ERROR_IO, "sbatch: cannot be started: %s; is it installed?", strerror(error));
    while (waitpid(process, &wait_status, 0) < 0 && errno == EINTR) continue;
    if (WIFEXITED(wait_status) && !WEXITSTATUS(wait_status)) return VW_OK;
    return vw_fail(VW_ERROR_IO, "sbatch: exit code %d; correct what it names, and submit again",
                   WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : -1);
}

enum vw_status vw_batch_submit(const struct vw_batch *batch, const char *out, const char *const *words) {
    char *path = vw_path_join(out, "slurm_job.sh"), *logs = vw_format_text("--output=%s/slurm-%%a.log", out);
    char *array = NULL, *all[WORDS_MAX + 5] = {(char *)"sbatch", NULL, logs, path};
    enum vw_status status = path && logs ? vw_folder_create(out) : VW_ERROR_MEMORY;
    if (!status) status = write_array(batch, &array);
    if (!status) status = vw_file_write(path, script, sizeof script - 1);
    all[1] = array;
    for (size_t i = 0; i < WORDS_MAX && words[i]; i++) all[4 + i] = (char *)words[i];
    if (!status) status = run_sbatch(all);
    free(array);
    free(path);
    free(logs);
    return status;
}

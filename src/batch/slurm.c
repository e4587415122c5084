#include <errno.h>
#include <inttypes.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "batch/batch.h"

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

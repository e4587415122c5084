#include "batch/slurm.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "batch/child.h"

enum { ANSWER_BYTES = 65536 };
#define JOB_LOG(number) "slurm-" number ".log"
#define MERGE_LOG JOB_LOG("merge")

// The absolute places that a job needs, wherever it begins; all owned.
struct places {
    char *folder, *jobs_path, *out, *program;
};

// ---- The scripts --------------------------------------------------------------------------------------------------

// Quotes any text as one word of a shell.
static void quote(FILE *stream, const char *text) {
    fputc('\'', stream);
    for (; *text; text++) {
        if (*text == '\'') fputs("'\\''", stream);
        else fputc(*text, stream);
    }
    fputc('\'', stream);
}

// Writes the numbers of the jobs that are not done, as "1,3-5".
static void write_array(FILE *stream, const struct vw_batch *batch) {
    const char *separator = "";
    for (uint32_t i = 0; i < batch->jobs->count; i++) {
        if (batch->results[i].state == VW_JOB_DONE) continue;
        uint32_t first = i;
        while (i + 1 < batch->jobs->count && batch->results[i + 1].state != VW_JOB_DONE) i++;
        fprintf(stream, "%s%" PRIu32, separator, first + 1);
        if (i > first) fprintf(stream, "-%" PRIu32, i + 1);
        separator = ",";
    }
}

static void write_head(FILE *stream, const char *name, const char *log) {
    fprintf(stream, "#!/bin/bash\n# Made by viewworth batch --slurm, which makes it again.\n");
    fprintf(stream, "#SBATCH --job-name=%s\n#SBATCH --output=%s\n#SBATCH --open-mode=append\n", name, log);
}

static void write_command(FILE *stream, const struct vw_slurm_params *params, const struct places *places) {
    fputs("cd ", stream);
    quote(stream, places->folder);
    fputs(" || exit 2\n", stream);
    quote(stream, places->program);
    fputs(" batch ", stream);
    quote(stream, places->jobs_path);
    fputs(" --out ", stream);
    quote(stream, places->out);
    if (!params->devices) return;
    fputs(" --devices ", stream);
    quote(stream, params->devices);
}

static void write_job(FILE *stream, const struct vw_slurm_params *params, const struct places *places) {
    write_head(stream, "viewworth", JOB_LOG("%a"));
    fputs("#SBATCH --requeue\n#SBATCH --signal=B:USR1@90\n#SBATCH --array=", stream);
    write_array(stream, params->batch);
    fputc('\n', stream);
    write_command(stream, params, places);
    fputs(" --job \"$SLURM_ARRAY_TASK_ID\" &\n"
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
          "exit \"$code\"\n",
          stream);
}

static void write_merge(FILE *stream, const struct vw_slurm_params *params, const struct places *places) {
    write_head(stream, "viewworth-merge", MERGE_LOG);
    write_command(stream, params, places);
    fputs(" --merge-only\n", stream);
}

typedef void write_script(FILE *stream, const struct vw_slurm_params *params, const struct places *places);

// Writes the script of the jobs OUT/NAME. Owned by the caller.
static enum vw_status make_script(const struct vw_slurm_params *params, const struct places *places, const char *name,
                                  write_script *write, char **path) {
    struct vw_text_stream text;
    char *script = NULL;
    size_t size_bytes = 0;
    FILE *stream = vw_text_stream_open(&text);
    if (!stream) return VW_ERROR_MEMORY;
    write(stream, params, places);
    enum vw_status status = vw_text_stream_close(&text, name, &script, &size_bytes);
    if (!status && !(*path = vw_path_join(places->out, name))) status = VW_ERROR_MEMORY;
    if (!status) status = vw_file_write(*path, script, size_bytes);
    free(script);
    return status;
}

// ---- Submitting ---------------------------------------------------------------------------------------------------

// Reads "NUMBER" or "NUMBER;CLUSTER"; messages of the cluster may precede it.
static enum vw_status read_number(char *answer, int code, char number[VW_SLURM_NUMBER_BYTES]) {
    size_t length = strlen(answer);
    while (length && answer[length - 1] == '\n') answer[--length] = 0;
    const char *line = strrchr(answer, '\n');
    line = line ? line + 1 : answer;
    size_t count = strspn(line, "0123456789");
    if (code || !count || count >= VW_SLURM_NUMBER_BYTES) {
        vw_text_make_line(answer);
        return vw_fail(VW_ERROR_IO, "sbatch: exit code %d: %.200s; correct what it names, and submit again", code,
                       answer);
    }
    memcpy(number, line, count);
    number[count] = 0;
    return VW_OK;
}

static enum vw_status submit(char *const *command, char number[VW_SLURM_NUMBER_BYTES]) {
    char *answer = vw_allocate(ANSWER_BYTES, 1);
    int code = 0;
    enum vw_status status = answer ? vw_child_read(command, answer, ANSWER_BYTES, &code) : VW_ERROR_MEMORY;
    if (!status) status = read_number(answer, code, number);
    free(answer);
    return status;
}

static enum vw_status submit_script(const struct places *places, char *script, const char *after,
                                    char number[VW_SLURM_NUMBER_BYTES]) {
    char *folder = vw_format_text("--chdir=%s", places->out), *dependency = NULL; // where the logs are
    if (*after) dependency = vw_format_text("--dependency=afterany:%s", after);
    enum vw_status status = folder && (dependency || !*after) ? VW_OK : VW_ERROR_MEMORY;
    char *with[] = {"sbatch", "--parsable", folder, dependency, script, NULL};
    char *without[] = {"sbatch", "--parsable", folder, script, NULL};
    if (!status) status = submit(dependency ? with : without, number);
    free(dependency);
    free(folder);
    return status;
}

// Submits the merge. If only this fails, the array is already submitted.
static enum vw_status submit_merge(const struct places *places, char *script, struct vw_slurm_numbers *numbers) {
    enum vw_status status = submit_script(places, script, numbers->array, numbers->merge);
    if (!status || !*numbers->array) return status;
    return vw_fail_context(status, "array %s is submitted, and wants batch --merge-only when it has ended",
                           numbers->array);
}

// Refuses links in place of logs, which Slurm would follow.
static enum vw_status check_logs(const struct vw_batch *batch, const char *out) {
    enum vw_status status = vw_file_check_inside(out, MERGE_LOG);
    for (uint32_t i = 0; !status && i < batch->jobs->count; i++) {
        char name[32];
        snprintf(name, sizeof name, JOB_LOG("%" PRIu32), i + 1);
        status = vw_file_check_inside(out, name);
    }
    return status;
}

static enum vw_status submit_all(const struct vw_slurm_params *params, const struct places *places,
                                 struct vw_slurm_numbers *numbers) {
    char *job = NULL, *merge = NULL;
    bool all_done = params->batch->done == params->batch->jobs->count;
    enum vw_status status = make_script(params, places, "slurm_merge.sh", write_merge, &merge);
    if (!status && !all_done) status = make_script(params, places, "slurm_job.sh", write_job, &job);
    if (!status && !all_done) status = submit_script(places, job, "", numbers->array);
    if (!status) status = submit_merge(places, merge, numbers);
    free(job);
    free(merge);
    return status;
}

static enum vw_status find_places(const struct vw_slurm_params *params, struct places *places) {
    *places = (struct places){.folder = realpath(".", NULL),
                              .jobs_path = realpath(params->jobs_path, NULL),
                              .out = realpath(params->out, NULL),
                              .program = realpath(params->program, NULL)};
    if (places->folder && places->jobs_path && places->out && places->program) return VW_OK;
    return vw_fail(VW_ERROR_IO, "--slurm: cannot find the path of this folder, of %s, of %s or of the program",
                   params->jobs_path, params->out);
}

enum vw_status vw_slurm_submit(const struct vw_slurm_params *params, struct vw_slurm_numbers *numbers) {
    struct places places = {0};
    *numbers = (struct vw_slurm_numbers){0};
    enum vw_status status = vw_folder_create(params->out);
    if (!status) status = find_places(params, &places);
    if (!status) status = check_logs(params->batch, places.out);
    if (!status) status = submit_all(params, &places, numbers);
    free(places.folder);
    free(places.jobs_path);
    free(places.out);
    free(places.program);
    return status;
}

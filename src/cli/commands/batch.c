#include "batch/batch.h"
#include "batch/slurm.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/word_list.h"
#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/batch_output.h"
#include "cli/parse_options.h"
#include "viewworth/gpu.h"

enum { DEVICES_MAX = 64 };

// ---- Jobs ---------------------------------------------------------------------------------------------------------

// Whether `value` would take the job's words, before any job begins. getopt moves words, so that it gets a copy.
static enum vw_status check_job(const struct vw_job *job) {
    static const struct vw_command value = {.name = "value", .operand = "SCENE", .options = VW_OPTIONS_OF_VALUE};
    struct vw_options options;
    char out[] = "--out=NAME", **words = vw_allocate(job->word_count + 2, sizeof *words);
    if (!words) return VW_ERROR_MEMORY;
    memcpy(words, job->words, job->word_count * sizeof *words);
    words[job->word_count] = out;
    enum vw_status status = vw_options_parse(&value, (int)job->word_count + 1, words, &options);
    if (!status) status = vw_options_check_lasting(&options);
    free(words);
    return status;
}

static enum vw_status load_jobs(const char *path, struct vw_jobs *jobs) {
    enum vw_status status = vw_jobs_load(path, jobs);
    for (uint32_t i = 0; !status && i < jobs->count; i++) {
        status = check_job(&jobs->jobs[i]);
        if (status) status = vw_fail_context(status, "%s: job %s", path, jobs->jobs[i].name);
    }
    return status;
}

// ---- Devices ------------------------------------------------------------------------------------------------------

struct devices {
    char *names[DEVICES_MAX]; // owned
    uint32_t count;
};

static enum vw_status add_device(struct devices *devices, char *name) {
    if (!name) return VW_ERROR_MEMORY;
    devices->names[devices->count++] = name;
    return VW_OK;
}

// The list is in order of preference: a CPU comes behind all GPUs, and is as good as none beside one.
static enum vw_status list_all(struct devices *devices) {
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_gpu_list(&infos, &count);
    for (uint32_t i = 0; !status && i < count && devices->count < DEVICES_MAX; i++) {
        bool is_cpu = infos[i].kind == VW_GPU_CPU;
        if (infos[i].unsupported_reason[0] || (is_cpu && devices->count)) continue;
        status = add_device(devices, vw_format_text("%u", infos[i].index));
        if (is_cpu) break;
    }
    free(infos);
    if (!status && !devices->count)
        status = vw_fail(VW_ERROR_NO_DEVICE, "--devices all: no device can be used; see viewworth devices");
    return status;
}

static enum vw_status read_list(const char *list, struct devices *devices) {
    enum vw_status status = VW_OK;
    for (struct vw_word word; !status && vw_word_list_next(&list, &word);) {
        if (!word.length || devices->count == DEVICES_MAX)
            return vw_fail(VW_ERROR_USAGE, "--devices takes all, or 1 to %d indices or names with commas between",
                           DEVICES_MAX);
        status = add_device(devices, vw_format_text("%.*s", (int)word.length, word.text));
    }
    return status;
}

// ---- The command --------------------------------------------------------------------------------------------------

static enum vw_status run_batch(const struct vw_options *options, const struct vw_jobs *jobs,
                                const struct devices *devices) {
    struct vw_batch_display display = {.quiet = options->quiet};
    struct vw_batch batch;
    enum vw_status status = vw_batch_make(&(struct vw_batch_params){.jobs = jobs,
                                                                    .out = options->out,
                                                                    .program = "/proc/self/exe",
                                                                    .devices = (const char *const *)devices->names,
                                                                    .device_count = devices->count,
                                                                    .per_device = options->per_device,
                                                                    .only = options->job,
                                                                    .merge_only = options->merge_only,
                                                                    .interrupt = vw_interrupt_watch(),
                                                                    .progress = vw_batch_show,
                                                                    .context = &display},
                                          &batch);
    vw_batch_show_end(&display);
    struct vw_saved_error why = vw_error_save();
    if (!status || batch.failed) {
        struct vw_summary_row *rows = vw_summary_of_batch(&batch);
        enum vw_status printed =
            vw_summary_print(rows, jobs->count, options->job ? NULL : &batch.merged, options->out, options->json);
        free(rows);
        if (status) vw_error_restore(&why);
        else status = printed;
    }
    vw_batch_free(&batch);
    return status;
}

static enum vw_status run_here(const struct vw_options *options, const struct vw_jobs *jobs) {
    struct devices devices = {0};
    enum vw_status status = VW_OK;
    if (options->devices)
        status = strcmp(options->devices, "all") ? read_list(options->devices, &devices) : list_all(&devices);
    if (!status) status = run_batch(options, jobs, &devices);
    for (uint32_t i = 0; i < devices.count; i++) free(devices.names[i]);
    return status;
}

static enum vw_status submit(const struct vw_options *options, const struct vw_jobs *jobs) {
    struct vw_batch batch;
    struct vw_slurm_numbers numbers;
    enum vw_status status = vw_batch_look(jobs, options->out, &batch);
    if (!status)
        status = vw_slurm_submit(&(struct vw_slurm_params){.batch = &batch,
                                                           .jobs_path = options->operand,
                                                           .out = options->out,
                                                           .program = "/proc/self/exe",
                                                           .devices = options->devices,
                                                           .partition = options->partition,
                                                           .time_limit = options->time_limit,
                                                           .gpus = options->gpus},
                                 &numbers);
    if (!status) status = vw_submitted_print(&batch, &numbers, options->out, options->json);
    vw_batch_free(&batch);
    return status;
}

static enum vw_status check_together(const struct vw_options *options) {
    if (!options->slurm && (options->partition || options->time_limit || options->gpus))
        return vw_fail(VW_ERROR_USAGE, "--partition, --gpus and --time-limit are of --slurm; add it");
    if (options->slurm && (options->job || options->merge_only || vw_options_have(options, "per-device")))
        return vw_fail(VW_ERROR_USAGE,
                       "--slurm decides where jobs run; leave out --job, --merge-only and --per-device");
    if (options->merge_only && options->job)
        return vw_fail(VW_ERROR_USAGE, "--merge-only runs no job; leave out --job");
    return VW_OK;
}

enum vw_status vw_command_batch(const struct vw_options *options) {
    struct vw_jobs jobs = {0};
    enum vw_status status = check_together(options);
    if (!status) status = load_jobs(options->operand, &jobs);
    if (!status) status = options->slurm ? submit(options, &jobs) : run_here(options, &jobs);
    vw_jobs_free(&jobs);
    return status;
}

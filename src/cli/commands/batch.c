#include "batch/batch.h"
#include "batch/child.h"
#include "batch/slurm.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/parse_options.h"
#include "viewworth/gpu.h"

// ---- Jobs ---------------------------------------------------------------------------------------------------------

// Checks the job's words before any job begins, and notes whether the job must run alone. getopt moves words, so it
// gets a copy.
static enum vw_status check_job(const struct vw_program *program, struct vw_job *job) {
    static const struct vw_command value = {.name = "value", .operand = "SCENE", .options = VW_OPTIONS_OF_VALUE};
    struct vw_options options;
    char out[] = "--out=NAME", **words = vw_allocate(job->word_count + 2, sizeof *words);
    if (!words) return VW_ERROR_MEMORY;
    memcpy(words, job->words, job->word_count * sizeof *words);
    words[job->word_count] = out;
    enum vw_status status = vw_options_parse(program, &value, (int)job->word_count + 1, words, &options);
    job->single = options.budget || options.accuracy || options.profile || options.worth || options.together;
    free(words);
    return status;
}

static enum vw_status load_jobs(const struct vw_options *options, struct vw_jobs *jobs) {
    const char *path = options->operand;
    enum vw_status status = vw_jobs_load(path, jobs);
    for (uint32_t i = 0; !status && i < jobs->count; i++) {
        status = check_job(options->program, &jobs->jobs[i]);
        if (status) status = vw_fail_context(status, "%s: job %s", path, jobs->jobs[i].name);
    }
    return status;
}

// ---- The command --------------------------------------------------------------------------------------------------

// Returns how many jobs a process trains at a time. Unless the user says so, it is several where the preferred device
// is a GPU, which gains by it. The process finds out how many its device can train.
static uint32_t choose_together(const struct vw_options *options) {
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    if (options->together || options->job) return options->together;
    if (vw_gpu_list(&infos, &count)) return 1; // the jobs say what is wrong
    bool gpu = count && infos[0].kind != VW_GPU_CPU;
    free(infos);
    return gpu ? VW_CHILD_JOBS_MAX : 1;
}

static enum vw_status run_batch(const struct vw_options *options, const struct vw_jobs *jobs,
                                const struct vw_device_list *devices) {
    struct vw_batch_display display = {.quiet = options->quiet};
    struct vw_batch batch;
    enum vw_status status = vw_batch_make(&(struct vw_batch_params){.jobs = jobs,
                                                                    .out = options->out,
                                                                    .program = "/proc/self/exe",
                                                                    .devices = devices->texts,
                                                                    .device_count = devices->count,
                                                                    .per_device = options->per_device,
                                                                    .together = choose_together(options),
                                                                    .together_given = options->together > 0,
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
    struct vw_device_list devices;
    enum vw_status status = vw_device_list_read(options, &devices);
    return status ? status : run_batch(options, jobs, &devices);
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
                                                           .devices = options->devices},
                                 &numbers);
    if (!status) status = vw_submitted_print(&batch, &numbers, options->out, options->json);
    vw_batch_free(&batch);
    return status;
}

static enum vw_status check_together(const struct vw_options *options) {
    if (options->slurm &&
        (options->job || options->merge_only || options->together || vw_options_have(options, "per-device")))
        return vw_fail(VW_ERROR_USAGE,
                       "--slurm decides where jobs run; leave out --job, --merge-only, --together and --per-device");
    if (options->merge_only && options->job)
        return vw_fail(VW_ERROR_USAGE, "--merge-only runs no job; leave out --job");
    return VW_OK;
}

enum vw_status vw_command_batch(const struct vw_options *options) {
    struct vw_jobs jobs = {0};
    enum vw_status status = check_together(options);
    if (!status) status = load_jobs(options, &jobs);
    if (!status) status = options->slurm ? submit(options, &jobs) : run_here(options, &jobs);
    vw_jobs_free(&jobs);
    return status;
}

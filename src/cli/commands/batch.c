#include "batch/batch.h"

#include <limits.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/program.h"

// ---- Jobs ---------------------------------------------------------------------------------------------------------

// Checks the job's words before any job begins.
static enum vw_status check_job(const struct vw_program *program, const struct vw_job *job) {
    static const struct vw_program_command value = {
        .name = "value", .operand = "SCENE", .options = VW_OPTIONS_OF_VALUE};
    struct vw_options options;
    char out[] = "--out=NAME", **words = vw_job_list_words(job, (char *[]){out, NULL});
    if (!words) return VW_ERROR_MEMORY;
    int count = (int)json_array_size(job->words) + 1; // without "viewworth"
    enum vw_status status = vw_options_parse(program, &value, count, words + 1, &options);
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

static enum vw_status run_here(const struct vw_options *options, const struct vw_jobs *jobs) {
    struct vw_batch_display display = {.quiet = options->quiet};
    struct vw_device_list devices;
    struct vw_batch batch = {0};
    enum vw_status status = vw_device_list_read(options, &devices);
    if (status) return status;
    status = vw_batch_make(&(struct vw_batch_params){.jobs = jobs,
                                                     .out = options->out,
                                                     .devices = devices.texts,
                                                     .device_count = devices.count,
                                                     .per_device = options->per_device,
                                                     .only = options->job,
                                                     .interrupt = vw_interrupt_watch(),
                                                     .progress = vw_batch_show,
                                                     .context = &display},
                           &batch);
    vw_batch_show_end(&display);
    struct vw_saved_error why = vw_error_save();
    enum vw_status printed =
        !status || batch.failed ? vw_batch_rows_print(&batch.rows, options->out, options->json) : VW_OK;
    if (status) vw_error_restore(&why);
    vw_batch_free(&batch);
    return status ? status : printed;
}

static enum vw_status submit(const struct vw_options *options, const struct vw_batch *batch) {
    char program[PATH_MAX] = "";
    if (readlink("/proc/self/exe", program, sizeof program - 1) < 0)
        return vw_fail(VW_ERROR_IO, "/proc/self/exe: cannot find the path of this program");
    const char *words[] = {program,          "batch",      options->operand,
                           "--out",          options->out, options->devices ? "--devices" : NULL,
                           options->devices, NULL};
    enum vw_status status = vw_batch_submit(batch, options->out, words);
    if (!status)
        vw_print("%u of %u jobs\nlogs     %s/slurm-*.log\n", batch->rows.count - batch->done, batch->rows.count,
                 options->out);
    return status;
}

// Submits what is not done. Where all is done, this command merges, as the last job of an array does.
static enum vw_status run_on_cluster(const struct vw_options *options, const struct vw_jobs *jobs) {
    struct vw_batch batch;
    if (options->job || options->json || vw_options_have(options, "per-device"))
        return vw_fail(VW_ERROR_USAGE, "--slurm leaves to sbatch where jobs run, and what is printed; leave out --job, "
                                       "--json and --per-device");
    enum vw_status status = vw_batch_look(jobs, options->out, &batch);
    bool all_done = batch.done == batch.rows.count;
    if (!status && !all_done) status = submit(options, &batch);
    vw_batch_free(&batch);
    return !status && all_done ? run_here(options, jobs) : status;
}

enum vw_status vw_command_batch(const struct vw_options *options) {
    struct vw_jobs jobs = {0};
    enum vw_status status = load_jobs(options, &jobs);
    if (!status) status = options->slurm ? run_on_cluster(options, &jobs) : run_here(options, &jobs);
    vw_jobs_free(&jobs);
    return status;
}

// Our training step and our validation, timed: steps with and without validation take turns, so that what else the
// machine does meets both alike. Without settings this is the reference workload: 500 rays x 32 samples, 8 levels x 2
// features x 2^14 (base 8, growth 1.45), MLPs 16-32-16 and 24-32-3, squared loss, dense Adam with beta1 0.9, spherical
// harmonics up to band 2, and a validation of 2048 rays. Prints one line of names and figures; times are medians per
// step and training, memory is the most there was; host_ms is the CPU time of the thread that records, draws and reads,
// pipelines_ms the time in which the driver compiled all pipelines. A driver that runs the device's work on CPUs does
// so in threads of its own (lavapipe starts one for each queue), so that it does not count. host_bound_percent is the
// share of submissions at which the device had nothing left to do: it waited for the host.
// --profile prints the time of every pass, and beside it that of one workgroup alone and of an empty pass.
//
// scripts/benchmark_gpu also lets it describe the device (--describe), hash the records of some steps (--bits), take
// the steps of one size batch by batch (batch=1) and force what a run chooses by the kind of device (grid_texel=0).
// --occupancy lists the dispatches of a step with validation, and which of them run beside each other.
#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "benchmark/step_setup.h"
#include "do_nothing.h"
#include "gpu/command_list.h"
#include "gpu/compute.h"
#include "support/synthetic_scene.h"
#include "support/trainer_fixture.h"
#include "train/shared_submissions.h"
#include "train/trainer.h"
#include "viewworth/train.h"

static const double WARM_UP_S = 0.5;

// ---- Measuring ------------------------------------------------------------------------------------------------------

struct timing {
    double wall_ms, cpu_ms; // per step
    double host_ms;         // the part of cpu_ms in the thread that records and reads
    double host_bound_percent;
};

static double cpu_s(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double peak_resident_mib(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024.0;
}

static enum vw_status open_trainer(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup,
                                   bool validate, struct vw_submissions *submissions, struct vw_trainer **trainer) {
    const struct vw_device_choices choices = step_setup_choose(setup, gpu);
    return test_trainer_try((struct vw_trainer_params){.gpu = gpu,
                                                       .scene = scene,
                                                       .config = &setup->config,
                                                       .validate = validate,
                                                       .choices = &choices,
                                                       .submissions = submissions,
                                                       .steps_per_submission = setup->batch},
                            trainer);
}

// Trainings of the same configuration that take their steps together.
struct group {
    struct vw_submissions *submissions;
    struct vw_trainer *trainers[VW_TRAINERS_TOGETHER_MAX];
    uint32_t count;
};

static enum vw_status open_group(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup,
                                 bool validate, struct group *group) {
    enum vw_status status = vw_submissions_create(gpu, &group->submissions);
    for (; group->count < setup->together && status == VW_OK; group->count++)
        status = open_trainer(gpu, scene, setup, validate, group->submissions, &group->trainers[group->count]);
    return status;
}

static void close_group(struct group *group) {
    for (uint32_t i = 0; i < group->count; i++) vw_trainer_destroy(&group->trainers[i]);
    vw_submissions_destroy(&group->submissions);
}

// Advances by one batch; `count`: its steps, of all trainings.
static enum vw_status advance(const struct group *group, uint32_t *count) {
    const struct vw_step_record *records;
    enum vw_status status = VW_OK;
    *count = 0;
    for (uint32_t i = 0; i < group->count && status == VW_OK; i++) {
        uint32_t steps = 0;
        status = vw_trainer_advance(group->trainers[i], &records, &steps);
        *count += steps;
    }
    return status;
}

// Advances by at least two batches; a GPU until its clocks have risen.
static enum vw_status warm_up(const struct vw_gpu *gpu, const struct group *group) {
    enum vw_status status = VW_OK;
    double end_s = vw_now_s() + (vw_gpu_get_info(gpu)->kind == VW_GPU_CPU ? 0.0 : WARM_UP_S);
    for (uint32_t batches = 0, count; (batches < 2 || vw_now_s() < end_s) && status == VW_OK; batches++)
        status = advance(group, &count);
    return status;
}

static double host_bound_percent(struct vw_submission_counts before, struct vw_submission_counts after) {
    return 100.0 * (double)(after.host_bound - before.host_bound) / (double)(after.submitted - before.submitted);
}

// Takes medians over `batches` batches.
static enum vw_status time_batches(const struct vw_gpu *gpu, const struct group *group, uint32_t batches,
                                   struct timing *timing) {
    uint32_t count;
    double *wall_ms = vw_allocate(batches, sizeof *wall_ms), *cpu_ms = vw_allocate(batches, sizeof *cpu_ms),
           *host_ms = vw_allocate(batches, sizeof *host_ms);
    bool made = wall_ms && cpu_ms && host_ms;
    enum vw_status status = made ? warm_up(gpu, group) : VW_ERROR_MEMORY;
    const struct vw_submission_counts before = vw_gpu_submission_counts(gpu);
    for (uint32_t i = 0; i < batches && status == VW_OK; i++) {
        double wall_s = vw_now_s(), all_s = cpu_s(CLOCK_PROCESS_CPUTIME_ID), host_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
        status = advance(group, &count);
        wall_ms[i] = 1e3 * (vw_now_s() - wall_s) / count;
        cpu_ms[i] = 1e3 * (cpu_s(CLOCK_PROCESS_CPUTIME_ID) - all_s) / count;
        host_ms[i] = 1e3 * (cpu_s(CLOCK_THREAD_CPUTIME_ID) - host_s) / count;
    }
    if (status == VW_OK)
        *timing = (struct timing){vw_median(wall_ms, batches), vw_median(cpu_ms, batches), vw_median(host_ms, batches),
                                  host_bound_percent(before, vw_gpu_submission_counts(gpu))};
    free(host_ms);
    free(wall_ms);
    free(cpu_ms);
    return status;
}

static enum vw_status time_steps(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup,
                                 bool validate, struct timing *timing, struct vw_trainer_stats *stats) {
    uint32_t batches = setup->steps / setup->batch / setup->rounds;
    struct group group = {0};
    enum vw_status status = open_group(gpu, scene, setup, validate, &group);
    if (status == VW_OK) status = time_batches(gpu, &group, batches ? batches : 1, timing);
    if (status == VW_OK) vw_trainer_get_stats(group.trainers[0], stats);
    close_group(&group);
    return status;
}

// ---- The report -----------------------------------------------------------------------------------------------------

static void print_figures(const struct timing *with, const struct timing *without, uint32_t rounds,
                          const struct vw_trainer_stats *stats, const struct vw_gpu *gpu) {
    enum {
        TRAIN,
        VALIDATE,
        TRAIN_CPU,
        VALIDATE_CPU,
        SCORING,
        SCORING_CPU,
        HOST,
        SCORING_HOST,
        BOUND,
        SCORING_BOUND,
        FIGURES
    };
    double figures[FIGURES][ROUNDS_MAX];
    for (uint32_t i = 0; i < rounds; i++) {
        figures[TRAIN][i] = without[i].wall_ms;
        figures[VALIDATE][i] = with[i].wall_ms - without[i].wall_ms;
        figures[TRAIN_CPU][i] = without[i].cpu_ms;
        figures[VALIDATE_CPU][i] = with[i].cpu_ms - without[i].cpu_ms;
        figures[SCORING][i] = with[i].wall_ms / without[i].wall_ms;
        figures[SCORING_CPU][i] = with[i].cpu_ms / without[i].cpu_ms;
        figures[HOST][i] = without[i].host_ms;
        figures[SCORING_HOST][i] = with[i].host_ms;
        figures[BOUND][i] = without[i].host_bound_percent;
        figures[SCORING_BOUND][i] = with[i].host_bound_percent;
    }
    static const char *const names[FIGURES] = {
        "train_ms",          "val_ms",  "train_cpu_ms",    "val_cpu_ms",         "scoring_ratio",
        "scoring_cpu_ratio", "host_ms", "scoring_host_ms", "host_bound_percent", "scoring_host_bound_percent"};
    for (int f = 0; f < FIGURES; f++) printf("%s %.4f ", names[f], vw_median(figures[f], rounds));
    printf("val_rays %" PRIu32 " device_mib %.2f resident_mib %.1f pipelines %" PRIu32 " pipelines_ms %.1f device %s\n",
           stats->val_rays, (double)stats->device_bytes / 1048576.0, peak_resident_mib(), vw_gpu_pipeline_count(gpu),
           1e3 * vw_gpu_pipeline_s(gpu), vw_gpu_get_info(gpu)->name);
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

static const struct vw_shader empty_shader = {"empty pass", do_nothing_code, sizeof do_nothing_code};

// Dispatches one workgroup of every pass of a step, and after each an empty pass; only empty ones where passes walk
// over lists that others leave them, as those of splats.
static enum vw_status run_alone(struct vw_submission *submission, const struct vw_command_list *list, uint32_t commands,
                                const struct vw_pass *empty, bool only_empty) {
    vw_submission_begin(submission);
    for (uint32_t i = 0; i < commands; i++) {
        const struct vw_command *command = &list->commands[i];
        if (command->pass && !only_empty)
            vw_submission_dispatch(submission, command->pass, list->pushes + command->push_offset_bytes,
                                   command->pass->push_bytes, 1);
        vw_submission_dispatch(submission, empty, NULL, 0, 1);
    }
    enum vw_status status = vw_submission_submit(submission);
    return status == VW_OK ? vw_submission_wait(submission) : status;
}

// The timers as they are; later ones follow them. Owned by the caller.
struct timers {
    struct vw_gpu_timer *list;
    uint32_t count;
};

static enum vw_status copy_timers(const struct vw_gpu *gpu, struct timers *copy) {
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &copy->count);
    copy->list = vw_allocate(copy->count, sizeof *timers);
    if (copy->list) memcpy(copy->list, timers, copy->count * sizeof *timers);
    return copy->list ? VW_OK : VW_ERROR_MEMORY;
}

// Times every pass of a trained group alone; `before`: the timers after a first round, in which the driver may compile.
static enum vw_status time_alone(struct vw_gpu *gpu, const struct group *group, const struct setup *setup,
                                 struct timers *before) {
    enum { REPEATS = 32 };
    const struct vw_command_list *list = vw_submission_list(group->submissions->submissions[1]);
    const uint32_t steps = setup->batch * setup->together, commands = (uint32_t)(list->count / steps);
    struct vw_submission *submission = NULL;
    struct vw_pass *empty = NULL;
    enum vw_status status =
        list->count % steps
            ? vw_fail(VW_ERROR_USAGE, "--profile: the steps of a submission differ; give another batch=")
            : vw_pass_create(gpu, &(struct vw_pass_params){.shader = &empty_shader, .role = "zero line"}, &empty);
    if (status == VW_OK) status = vw_submission_create(gpu, &submission);
    for (int i = 0; i <= REPEATS && status == VW_OK; i++) {
        status = run_alone(submission, list, commands, empty, setup->config.field == VW_FIELD_SPLATS);
        if (i == 0 && status == VW_OK) status = copy_timers(gpu, before);
    }
    vw_submission_destroy(&submission);
    vw_pass_destroy(&empty);
    return status;
}

// Returns what a timer has counted since.
static struct vw_gpu_timer since(const struct vw_gpu_timer *now, const struct vw_gpu_timer *before) {
    return (struct vw_gpu_timer){now->name, now->role, now->dispatches - before->dispatches,
                                 now->total_ms - before->total_ms};
}

static double mean_ms(const struct vw_gpu_timer *timer) { return timer->total_ms / (double)timer->dispatches; }

static void print_timer(const struct vw_gpu_timer *timer) {
    printf("  %-18s %-10s %8" PRIu64 " dispatches %10.1f ms %8.4f ms each", timer->name, timer->role ? timer->role : "",
           timer->dispatches, timer->total_ms, mean_ms(timer));
}

// Prints the passes of steps (`whole`) and then the empty pass. An empty pass shows what the barrier and the timestamps
// take, one workgroup how long the loops of an invocation are, whose trips wait for each other; memory is in caches
// then.
static void print_timers(const struct vw_gpu *gpu, const struct timers *whole, const struct timers *before) {
    uint32_t count;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < before->count; i++) {
        const struct vw_gpu_timer alone = since(&timers[i], &before->list[i]);
        print_timer(i < whole->count ? &whole->list[i] : &alone);
        if (i < whole->count && alone.dispatches) printf(" %8.4f ms one workgroup alone", mean_ms(&alone));
        printf("\n");
    }
}

static enum vw_status print_profile(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup) {
    struct timers whole = {0}, before = {0};
    struct group group = {0};
    enum vw_status status = copy_timers(gpu, &whole);
    if (status == VW_OK) status = open_group(gpu, scene, setup, true, &group);
    if (status == VW_OK) status = warm_up(gpu, &group);
    if (status == VW_OK) status = time_alone(gpu, &group, setup, &before);
    if (status == VW_OK) print_timers(gpu, &whole, &before);
    close_group(&group);
    free(whole.list);
    free(before.list);
    return status;
}

// ---- Bits -----------------------------------------------------------------------------------------------------------

static void hash_record(struct vw_hasher *hasher, const struct vw_step_record *record) {
    vw_hasher_add_integer(hasher, (int64_t)record->step);
    vw_hasher_add_integer(hasher, record->nonfinite);
    vw_hasher_add_integer(hasher, (int64_t)record->clamped_count);
    vw_hasher_add_real(hasher, record->train_loss);
    vw_hasher_add_real(hasher, record->val_psnr);
    for (uint32_t i = 0; i < record->view_count; i++) {
        vw_hasher_add_real(hasher, record->views[i].mse);
        vw_hasher_add_real(hasher, record->views[i].l1);
    }
}

static enum vw_status print_bits(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup) {
    struct vw_trainer *trainer = NULL;
    const struct vw_step_record *records;
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    uint32_t count = 1;
    double psnr = 0.0;
    vw_hasher_begin(&hasher);
    enum vw_status status = open_trainer(gpu, scene, setup, true, NULL, &trainer);
    if (status == VW_OK) vw_trainer_stop_after(trainer, setup->steps);
    while (status == VW_OK && count) {
        status = vw_trainer_advance(trainer, &records, &count);
        for (uint32_t i = 0; i < count && status == VW_OK; i++) hash_record(&hasher, &records[i]);
        if (status == VW_OK && count) psnr = records[count - 1].val_psnr;
    }
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, hex);
    if (status == VW_OK) printf("bits %.16s steps %" PRIu32 " val_psnr %.4f\n", hex, setup->steps, psnr);
    vw_trainer_destroy(&trainer);
    return status;
}

// ---- Occupancy ------------------------------------------------------------------------------------------------------

static void print_dispatch(const struct vw_command *command, uint32_t stage, int step) {
    static const char *const steps[] = {"the one before", "this", "the next"};
    const struct vw_pass *pass = command->pass;
    const struct vw_workgroups *groups = &command->groups; // unless it is a copy
    const uint64_t count = pass ? (uint64_t)groups->x * groups->y : 0;
    const char *whose = step < -1 || step > 1 ? "another" : steps[step + 1];
    printf("| %" PRIu32 " | %s | %s | %s | ", stage, pass ? pass->name : "copy", pass && pass->role ? pass->role : "",
           whose);
    if (!pass) printf("| | |\n");
    else if (groups->listed) printf("by the device | | |\n");
    else
        printf("%" PRIu64 " | %" PRIu64 " | %" PRIu64 " |\n", count, count * pass->workgroup_invocations,
               count * ((pass->workgroup_invocations + 31) / 32));
}

// Prints the stages from the one in which a step in the middle of a submission begins up to the one of the next step.
static void print_stages(const struct vw_command_list *list, uint32_t steps) {
    const uint32_t per_step = (uint32_t)(list->count / steps), first = steps / 2 * per_step;
    const uint32_t begin = list->commands[first].stage, end = list->commands[first + per_step].stage;
    printf(
        "| stage | pass | role | of step | workgroups | invocations | warps of 32 |\n|---|---|---|---|---|---|---|\n");
    for (uint32_t stage = begin; stage < end; stage++)
        for (uint32_t i = list->stages[stage].first; i != VW_NO_COMMAND; i = list->commands[i].next)
            print_dispatch(&list->commands[i], stage - begin, (int)(i / per_step) - (int)(steps / 2));
    printf("\ncommands %" PRIu32 " barriers %" PRIu32 " per step; %.2f in %" PRIu32 " steps of a submission\n",
           per_step, end - begin, (double)vw_command_list_barriers(list) / steps, steps);
}

// Prints what a step occupies in the second submission, since the steps of one overlap.
static enum vw_status print_occupancy(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup) {
    struct setup alone = *setup;
    struct group group = {0};
    uint32_t count;
    alone.together = 1;
    if (alone.batch < 4) alone.batch = 4;
    enum vw_status status = open_group(gpu, scene, &alone, true, &group);
    if (status == VW_OK) status = advance(&group, &count);
    const struct vw_command_list *list = status ? NULL : vw_submission_list(group.submissions->submissions[1]);
    if (list && list->count % alone.batch)
        status = vw_fail(VW_ERROR_USAGE, "--occupancy: the steps of a submission differ; give another batch=");
    else if (list) print_stages(list, alone.batch);
    close_group(&group);
    return status;
}

// ---- The device -----------------------------------------------------------------------------------------------------

static void print_limits(const struct vw_gpu_limits *l) {
    printf("| limit | value |\n|---|---|\n");
    printf("| storage binding, bytes | %" PRIu64 " |\n| buffer, bytes | %" PRIu64 " |\n", l->storage_binding_bytes,
           l->buffer_bytes);
    printf("| texel elements | %" PRIu32 " |\n| shared memory, bytes | %" PRIu32 " |\n", l->texel_elements,
           l->shared_memory_bytes);
    printf("| workgroup invocations | %" PRIu32 " |\n", l->workgroup_invocations);
    printf("| workgroups in x, y | %" PRIu32 ", %" PRIu32 " |\n", l->workgroup_count_x, l->workgroup_count_y);
    printf("| storage buffers, texel buffers of a stage | %" PRIu32 ", %" PRIu32 " |\n", l->storage_buffers,
           l->texel_buffers);
    printf("| 64-bit integers, their atomics | %s, %s |\n", l->int64 ? "yes" : "no", l->int64_atomics ? "yes" : "no");
    printf("| keeps NaN, timestamps | %s, %s |\n", l->keeps_nan ? "yes" : "no", l->timestamps ? "yes" : "no");
}

static void describe(struct vw_gpu *gpu, const struct setup *setup) {
    static const char *const scatter_names[] = {"64-bit atomics", "split atomics", "walk"};
    const struct vw_device_choices choices = step_setup_choose(setup, gpu);
    print_limits(vw_gpu_get_limits(gpu));
    printf("| chosen: chunk, slice, its parts | %" PRIu32 ", %" PRIu32 " samples, %" PRIu32 " |\n",
           choices.chunk_samples, choices.slice_samples, choices.slice_parts);
    printf("| chosen: lanes of a ray | %" PRIu32 " |\n", choices.ray_lanes);
    printf("| chosen: scatter | %s%s |\n", scatter_names[choices.scatter],
           choices.skip_zeros ? ", zeros left out" : "");
    printf("| chosen: pixels drawn on the device | %s |\n", choices.draws_pixels ? "yes" : "no");
    printf("| chosen: texel buffers for grid, rows | %s, %s |\n", choices.grid_texel ? "yes" : "no",
           choices.rows_texel ? "yes" : "no");
}

// ---- The program ----------------------------------------------------------------------------------------------------

static enum vw_status measure(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup) {
    struct timing with[ROUNDS_MAX], without[ROUNDS_MAX];
    struct vw_trainer_stats stats;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < setup->rounds && status == VW_OK; i++) {
        status = time_steps(gpu, scene, setup, false, &without[i], &stats);
        if (status == VW_OK) status = time_steps(gpu, scene, setup, true, &with[i], &stats);
    }
    if (status == VW_OK) print_figures(with, without, setup->rounds, &stats, gpu);
    return status == VW_OK && setup->profile ? print_profile(gpu, scene, setup) : status;
}

static enum vw_status run(const struct setup *setup) {
    struct vw_scene *scene = setup->real.path ? NULL : synthetic_scene(&setup->scene);
    struct vw_gpu *gpu = NULL;
    const struct vw_gpu_params params = {.timers = setup->profile};
    enum vw_status status = setup->real.path ? vw_scene_open(&setup->real, &scene) : VW_OK;
    if (status == VW_OK && setup->real.path) status = vw_scene_decode_all(scene);
    if (status == VW_OK) status = vw_gpu_open(&params, &gpu);
    if (status == VW_OK) gpu->chosen.limits.resubmits = setup->resubmits;
    if (status == VW_OK)
        status = setup->describe    ? (describe(gpu, setup), VW_OK)
                 : setup->bits      ? print_bits(gpu, scene, setup)
                 : setup->occupancy ? print_occupancy(gpu, scene, setup)
                                    : measure(gpu, scene, setup);
    vw_scene_close(&scene);
    enum vw_status closed = vw_gpu_close(&gpu);
    return status != VW_OK ? status : closed;
}

int main(int argc, char **argv) {
    struct setup setup = {0};
    if (!step_setup_read(argc, argv, &setup)) return step_setup_print_usage(), 2;
    enum vw_status status = run(&setup);
    if (status != VW_OK) fprintf(stderr, "benchmark_step: %s\n", vw_error_message());
    return vw_exit_code(status);
}

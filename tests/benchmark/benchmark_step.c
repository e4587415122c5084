// Our training step and 2048-ray validation at the yardstick's workload (tests/benchmark/native_step.c): 500 rays x 32 samples, 8 levels x
// 2 features x 2^14 (base 8, growth 1.45), MLPs 16-32-16 and 24-32-3, squared loss, dense Adam with beta1 0.9, spherical harmonics up to
// band 2. Prints medians in ms, like the native program. Usage: benchmark_step [steps] [validation rays] [--profile]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "support/synthetic_scene.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/train.h"

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double process_cpu_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct timing {
    double wall_ms, cpu_ms; // per step, medians over batches
};

enum { STEPS_PER_BATCH = 8, BATCHES_MAX = 256, ROUNDS = 5 };

// Runs `batches` batches after one for warming up.
static enum vw_status time_steps(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *config, bool validate,
                                 uint32_t batches, struct timing *timing) {
    double wall_ms[BATCHES_MAX], cpu_ms[BATCHES_MAX];
    const struct vw_step_record *records;
    uint32_t count;
    struct vw_trainer *trainer = NULL;
    struct vw_trainer_params params = {
        .gpu = gpu, .scene = scene, .config = config, .validate = validate, .steps_per_batch = STEPS_PER_BATCH};
    enum vw_status status = vw_trainer_create(&params, &trainer);
    if (status == VW_OK) status = vw_trainer_advance(trainer, &records, &count);
    if (status == VW_OK) status = vw_trainer_advance(trainer, &records, &count);
    for (uint32_t i = 0; i < batches && status == VW_OK; i++) {
        double wall_s = vw_now_s(), cpu_s = process_cpu_s();
        status = vw_trainer_advance(trainer, &records, &count);
        wall_ms[i] = 1e3 * (vw_now_s() - wall_s) / count;
        cpu_ms[i] = 1e3 * (process_cpu_s() - cpu_s) / count;
    }
    vw_trainer_destroy(&trainer);
    if (status != VW_OK) return status;
    qsort(wall_ms, batches, sizeof(double), ascending);
    qsort(cpu_ms, batches, sizeof(double), ascending);
    *timing = (struct timing){wall_ms[batches / 2], cpu_ms[batches / 2]};
    return VW_OK;
}

static void print_medians(const struct timing with[ROUNDS], const struct timing without[ROUNDS], uint32_t val_rays, const char *device) {
    double figures[4][ROUNDS]; // training and validation, wall and CPU
    for (int i = 0; i < ROUNDS; i++) {
        figures[0][i] = without[i].wall_ms;
        figures[1][i] = with[i].wall_ms - without[i].wall_ms;
        figures[2][i] = without[i].cpu_ms;
        figures[3][i] = with[i].cpu_ms - without[i].cpu_ms;
    }
    for (int f = 0; f < 4; f++) qsort(figures[f], ROUNDS, sizeof(double), ascending);
    printf("train_ms %.2f val_ms %.2f val_rays %u train_cpu_ms %.2f val_cpu_ms %.2f device %s\n", figures[0][ROUNDS / 2],
           figures[1][ROUNDS / 2], val_rays, figures[2][ROUNDS / 2], figures[3][ROUNDS / 2], device);
}

static void print_timers(const struct vw_gpu *gpu) {
    uint32_t count;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < count; i++)
        printf("  %-18s %8llu dispatches %10.1f ms %8.3f ms each\n", timers[i].name, (unsigned long long)timers[i].dispatches,
               timers[i].total_ms, timers[i].total_ms / (double)timers[i].dispatches);
}

static enum vw_status run(uint32_t steps, uint32_t val_rays, bool profile) {
    struct vw_config config = vw_config_default;
    config.epochs = 1000000;
    config.rays = 500;
    config.samples = 32;
    config.val_rays = val_rays;
    config.loss = VW_LOSS_L2;
    config.optimizer = VW_OPTIMIZER_DENSE_ADAM;
    config.beta1 = 0.9;
    config.levels = 8, config.features = 2, config.log2_table = 14, config.base_resolution = 8, config.growth = 1.45, config.width = 32;
    struct vw_scene *scene =
        synthetic_scene(&(struct synthetic_scene_params){.train_views = 16, .val_views = 4, .width_px = 160, .height_px = 120});
    struct vw_gpu *gpu = NULL;
    struct timing with[ROUNDS] = {0}, without[ROUNDS] = {0};
    uint32_t batches = steps / STEPS_PER_BATCH / ROUNDS ? steps / STEPS_PER_BATCH / ROUNDS : 1;
    if (batches > BATCHES_MAX) batches = BATCHES_MAX;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.timers = profile}, &gpu);
    // In turn, so that what else the machine does meets both alike.
    for (int i = 0; i < ROUNDS && status == VW_OK; i++) {
        status = time_steps(gpu, scene, &config, false, batches, &without[i]);
        if (status == VW_OK) status = time_steps(gpu, scene, &config, true, batches, &with[i]);
    }
    if (status == VW_OK) print_medians(with, without, val_rays, vw_gpu_get_info(gpu)->name);
    if (status == VW_OK && profile) print_timers(gpu);
    vw_scene_close(&scene);
    enum vw_status closed = vw_gpu_close(&gpu);
    return status != VW_OK ? status : closed;
}

int main(int argc, char **argv) {
    bool profile = argc > 1 && !strcmp(argv[argc - 1], "--profile");
    argc -= profile;
    int steps = argc > 1 ? atoi(argv[1]) : 160, val_rays = argc > 2 ? atoi(argv[2]) : 2048;
    if (steps < 1 || val_rays < 1) return fprintf(stderr, "usage: benchmark_step [steps] [validation rays] [--profile]\n"), 2;
    enum vw_status status = run((uint32_t)steps, (uint32_t)val_rays, profile);
    if (status != VW_OK) fprintf(stderr, "benchmark_step: %s\n", vw_error_message());
    return vw_exit_code(status);
}

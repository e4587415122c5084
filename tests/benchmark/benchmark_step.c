// Our training step and our validation, timed: steps with and without validation take turns, so that what else the
// machine does meets both alike. Without settings this is the yardstick's workload (tests/benchmark/native_step.c): 500
// rays x 32 samples, 8 levels x 2 features x 2^14 (base 8, growth 1.45), MLPs 16-32-16 and 24-32-3, squared loss, dense
// Adam with beta1 0.9, spherical harmonics up to band 2, and a validation of 2048 rays. Prints one line of names and
// figures; times are medians per step, memory is the most there was.
#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "support/open_trainer.h"
#include "support/synthetic_scene.h"
#include "base/clock.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "viewworth/train.h"

static const char USAGE[] =
    "usage: benchmark_step [STEPS] [VALIDATION RAYS] [--run-defaults] [--float16] [--profile] [NAME=NUMBER]...\n"
    "names: steps rounds photos width_px height_px rays samples val_rays levels log2_table width\n";

struct setup {
    struct vw_config config;
    struct synthetic_scene_params scene;
    uint32_t steps, rounds; // steps are spread over the rounds, each with trainers of its own
    bool profile;           // also prints the time of every pass
};

enum { STEPS_PER_BATCH = 8, ROUNDS_MAX = 64 };

// ---- Settings -------------------------------------------------------------------------------------------------------

static void choose_yardstick(struct setup *setup) {
    struct vw_config *config = &setup->config;
    *config = vw_config_default;
    config->epochs = 1000000;
    config->rays = 500, config->samples = 32, config->val_rays = 2048;
    config->loss = VW_LOSS_L2;
    config->optimizer = VW_OPTIMIZER_DENSE_ADAM;
    config->beta1 = 0.9;
    config->levels = 8, config->features = 2, config->log2_table = 14, config->base_resolution = 8,
    config->growth = 1.45;
    config->width = 32;
    setup->scene =
        (struct synthetic_scene_params){.train_views = 16, .val_views = 4, .width_px = 160, .height_px = 120};
    setup->steps = 160;
    setup->rounds = 5;
}

// What a run does unless told otherwise.
static void choose_run_defaults(struct setup *setup) {
    setup->config = vw_config_default;
    setup->config.epochs = 1000000;
}

static bool set_number(struct setup *setup, const char *name, size_t name_length, const char *text) {
    const struct {
        const char *name;
        uint32_t *value;
    } settings[] = {
        {"steps", &setup->steps},
        {"rounds", &setup->rounds},
        {"photos", &setup->scene.train_views},
        {"width_px", &setup->scene.width_px},
        {"height_px", &setup->scene.height_px},
        {"rays", &setup->config.rays},
        {"samples", &setup->config.samples},
        {"val_rays", &setup->config.val_rays},
        {"levels", &setup->config.levels},
        {"log2_table", &setup->config.log2_table},
        {"width", &setup->config.width},
    };
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    if (end == text || *end || number < 1 || number > 100000000) return false;
    for (size_t i = 0; i < VW_ARRAY_COUNT(settings); i++) {
        if (strlen(settings[i].name) != name_length || strncmp(settings[i].name, name, name_length)) continue;
        *settings[i].value = (uint32_t)number;
        return true;
    }
    return false;
}

static bool read_arguments(int argc, char **argv, struct setup *setup) {
    static const char *const bare[] = {"steps", "val_rays"}; // what numbers without a name are, in order
    size_t bare_count = 0;
    bool good = true;
    for (int i = 1; i < argc && good; i++) {
        const char *equals = strchr(argv[i], '=');
        if (!strcmp(argv[i], "--profile")) setup->profile = true;
        else if (!strcmp(argv[i], "--run-defaults")) choose_run_defaults(setup);
        else if (!strcmp(argv[i], "--float16")) setup->config.table_precision = VW_TABLE_FLOAT16;
        else if (equals) good = set_number(setup, argv[i], (size_t)(equals - argv[i]), equals + 1);
        else if (bare_count < VW_ARRAY_COUNT(bare)) {
            good = set_number(setup, bare[bare_count], strlen(bare[bare_count]), argv[i]);
            bare_count++;
        } else good = false;
    }
    return good && setup->rounds <= ROUNDS_MAX;
}

// ---- Measuring ------------------------------------------------------------------------------------------------------

struct timing {
    double wall_ms, cpu_ms; // per step
};

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, uint32_t count) {
    qsort(values, count, sizeof *values, ascending);
    return values[count / 2];
}

static double process_cpu_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double peak_resident_mib(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024.0;
}

// Medians over `batches` batches, after two for warming up.
static enum vw_status time_batches(struct vw_trainer *trainer, uint32_t batches, struct timing *timing) {
    const struct vw_step_record *records;
    uint32_t count;
    double *wall_ms = vw_allocate(batches, sizeof *wall_ms), *cpu_ms = vw_allocate(batches, sizeof *cpu_ms);
    enum vw_status status = wall_ms && cpu_ms ? vw_trainer_advance(trainer, &records, &count) : VW_ERROR_MEMORY;
    if (status == VW_OK) status = vw_trainer_advance(trainer, &records, &count);
    for (uint32_t i = 0; i < batches && status == VW_OK; i++) {
        double wall_s = vw_now_s(), cpu_s = process_cpu_s();
        status = vw_trainer_advance(trainer, &records, &count);
        wall_ms[i] = 1e3 * (vw_now_s() - wall_s) / count;
        cpu_ms[i] = 1e3 * (process_cpu_s() - cpu_s) / count;
    }
    if (status == VW_OK) *timing = (struct timing){median(wall_ms, batches), median(cpu_ms, batches)};
    free(wall_ms);
    free(cpu_ms);
    return status;
}

static enum vw_status time_steps(struct vw_gpu *gpu, const struct vw_scene *scene, const struct setup *setup,
                                 bool validate, struct timing *timing, struct vw_trainer_stats *stats) {
    uint32_t batches = setup->steps / STEPS_PER_BATCH / setup->rounds;
    struct vw_trainer *trainer = NULL;
    struct vw_trainer_params params = {
        .gpu = gpu, .scene = scene, .config = &setup->config, .validate = validate, .steps_per_batch = STEPS_PER_BATCH};
    enum vw_status status = test_trainer_open(params, &trainer);
    if (status == VW_OK) status = time_batches(trainer, batches ? batches : 1, timing);
    if (status == VW_OK) vw_trainer_get_stats(trainer, stats);
    vw_trainer_destroy(&trainer);
    return status;
}

// ---- The report -----------------------------------------------------------------------------------------------------

static void print_figures(const struct timing *with, const struct timing *without, uint32_t rounds,
                          const struct vw_trainer_stats *stats, const char *device) {
    enum { TRAIN, VALIDATE, TRAIN_CPU, VALIDATE_CPU, SCORING, SCORING_CPU, FIGURES };
    double figures[FIGURES][ROUNDS_MAX];
    for (uint32_t i = 0; i < rounds; i++) {
        figures[TRAIN][i] = without[i].wall_ms;
        figures[VALIDATE][i] = with[i].wall_ms - without[i].wall_ms;
        figures[TRAIN_CPU][i] = without[i].cpu_ms;
        figures[VALIDATE_CPU][i] = with[i].cpu_ms - without[i].cpu_ms;
        figures[SCORING][i] = with[i].wall_ms / without[i].wall_ms;
        figures[SCORING_CPU][i] = with[i].cpu_ms / without[i].cpu_ms;
    }
    static const char *const names[FIGURES] = {"train_ms",   "val_ms",        "train_cpu_ms",
                                               "val_cpu_ms", "scoring_ratio", "scoring_cpu_ratio"};
    for (int f = 0; f < FIGURES; f++) printf("%s %.3f ", names[f], median(figures[f], rounds));
    printf("val_rays %" PRIu32 " device_mib %.2f resident_mib %.1f device %s\n", stats->val_rays,
           (double)stats->device_bytes / 1048576.0, peak_resident_mib(), device);
}

static void print_timers(const struct vw_gpu *gpu) {
    uint32_t count;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < count; i++)
        printf("  %-18s %8llu dispatches %10.1f ms %8.3f ms each\n", timers[i].name,
               (unsigned long long)timers[i].dispatches, timers[i].total_ms,
               timers[i].total_ms / (double)timers[i].dispatches);
}

static enum vw_status run(const struct setup *setup) {
    struct vw_scene *scene = synthetic_scene(&setup->scene);
    struct vw_gpu *gpu = NULL;
    struct timing with[ROUNDS_MAX], without[ROUNDS_MAX];
    struct vw_trainer_stats stats;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.timers = setup->profile}, &gpu);
    for (uint32_t i = 0; i < setup->rounds && status == VW_OK; i++) {
        status = time_steps(gpu, scene, setup, false, &without[i], &stats);
        if (status == VW_OK) status = time_steps(gpu, scene, setup, true, &with[i], &stats);
    }
    if (status == VW_OK) print_figures(with, without, setup->rounds, &stats, vw_gpu_get_info(gpu)->name);
    if (status == VW_OK && setup->profile) print_timers(gpu);
    vw_scene_close(&scene);
    enum vw_status closed = vw_gpu_close(&gpu);
    return status != VW_OK ? status : closed;
}

int main(int argc, char **argv) {
    struct setup setup = {0};
    choose_yardstick(&setup);
    if (!read_arguments(argc, argv, &setup)) return fputs(USAGE, stderr), 2;
    enum vw_status status = run(&setup);
    if (status != VW_OK) fprintf(stderr, "benchmark_step: %s\n", vw_error_message());
    return vw_exit_code(status);
}

// What scores from gradients cost, and how they agree with credit and lasting credit: for runs of value that folders
// hold, as Markdown tables. CPU seconds of all threads, divided by those of a training like the run's without and with
// validation of every step. Methods of one pass are timed together.
//
//     benchmark_gradient_methods OUT...
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "lab/methods/gradient_scores.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"
#include "viewworth/ledger.h"

enum { PASSES = 3, CREDITS = 2 };
static const enum vw_gradient_method first_of_pass[PASSES + 1] = {VW_GRADIENT_IN_RUN_FIRST, VW_GRADIENT_TRACIN,
                                                                  VW_GRADIENT_INFLUENCE, VW_GRADIENT_METHODS};
static const char *const credits[CREDITS] = {"dv_psnr", "lasting_psnr"};

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static enum vw_status time_training(const struct vw_recorded_run *run, bool validate, double *seconds) {
    const struct vw_config config = vw_config_without_probes(&run->config);
    const struct vw_trainer_params params = {.gpu = run->gpu,
                                             .scene = run->scene,
                                             .config = &config,
                                             .effects = run->effects,
                                             .effect_count = run->effect_count,
                                             .validate = validate};
    struct vw_trainer *trainer = NULL;
    const struct vw_step_record *records;
    uint32_t count = 1;
    double started = cpu_seconds();
    enum vw_status status = vw_trainer_create(&params, &trainer);
    while (!status && count) status = vw_trainer_advance(trainer, &records, &count);
    vw_trainer_destroy(&trainer);
    *seconds = cpu_seconds() - started;
    return status;
}

// Prints Spearman's correlation with a score of the ledger; nothing where it has none.
static enum vw_status print_agreement(const struct vw_recorded_run *run, const char *method, const double *scores,
                                      uint32_t photos) {
    struct vw_ledger_score *rows = NULL;
    uint32_t count = 0, found = 0;
    double *own = vw_allocate(photos, sizeof *own), correlation = NAN;
    enum vw_status status = own ? vw_ledger_get_scores(run->ledger, &rows, &count) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) // by image_id, as photos are
        if (!strcmp(rows[i].method, method) && found < photos) own[found++] = rows[i].value;
    if (!status && found == photos) status = vw_spearman(scores, own, photos, &correlation);
    printf(" %.2f |", correlation);
    free(rows);
    free(own);
    return status;
}

static enum vw_status measure(const struct vw_recorded_run *run, uint32_t photos) {
    double plain = 0, validated = 0, *scores[VW_GRADIENT_METHODS] = {0};
    enum vw_status status = time_training(run, false, &plain);
    if (!status) status = time_training(run, true, &validated);
    printf("\n%s: %u photos, %u epochs; a training takes %.2f CPU s, validated %.2f\n\n", run->out, photos,
           run->config.epochs, plain, validated);
    puts("| method | CPU s | in trainings | in validated ones | rho with dv_psnr | with lasting_psnr |");
    puts("|---|---|---|---|---|---|");
    for (uint32_t pass = 0; pass < PASSES && !status; pass++) {
        const struct vw_gradient_scores_params params = {.gpu = run->gpu, .scene = run->scene, .out = run->out};
        double started = cpu_seconds();
        memset(scores, 0, sizeof scores);
        for (uint32_t m = first_of_pass[pass]; m < first_of_pass[pass + 1] && !status; m++)
            status = (scores[m] = vw_allocate(photos, sizeof *scores[m])) ? VW_OK : VW_ERROR_MEMORY;
        if (!status) status = vw_gradient_scores_make(&params, scores, NULL);
        double seconds = cpu_seconds() - started;
        for (uint32_t m = first_of_pass[pass]; m < first_of_pass[pass + 1]; m++) {
            if (!status)
                printf("| %s | %.2f | %.2f | %.2f |", vw_gradient_methods[m].name, seconds, seconds / plain,
                       seconds / validated);
            for (uint32_t i = 0; i < CREDITS && !status; i++)
                status = print_agreement(run, credits[i], scores[m], photos);
            putchar('\n');
            free(scores[m]);
        }
    }
    return status;
}

static enum vw_status measure_folder(const char *out) {
    struct vw_recorded_run run;
    uint32_t *views = NULL, photos = 0;
    enum vw_status status = vw_recorded_open(out, &run);
    if (!status) status = vw_recorded_open_scene(&run, NULL);
    if (!status) status = vw_scene_list_views(run.scene, VW_SPLIT_TRAIN, &views, &photos);
    if (!status) status = measure(&run, photos);
    free(views);
    vw_recorded_close(&run);
    return status;
}

int main(int count, char **folders) {
    for (int i = 1; i < count; i++)
        if (measure_folder(folders[i])) {
            fprintf(stderr, "benchmark_gradient_methods: %s\n", vw_error_message());
            return EXIT_FAILURE;
        }
    return EXIT_SUCCESS;
}

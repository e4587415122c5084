#include "viewworth/value.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "cli/json_output.h"
#include "cli/training_run.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"

enum { SHOWN_AT_EACH_END = 5 };
static const char shown_method[] = "dv_psnr";

// The scores of one method, best first.
struct ranking {
    const struct vw_ledger_score **scores; // owned array
    uint32_t count;
};

static int compare_scores(const void *left, const void *right) {
    const struct vw_ledger_score *a = *(const struct vw_ledger_score *const *)left, *b = *(const struct vw_ledger_score *const *)right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

static enum vw_status rank(const struct vw_ledger_score *scores, uint32_t score_count, struct ranking *ranking) {
    ranking->scores = vw_allocate(score_count, sizeof *ranking->scores);
    if (!ranking->scores) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, shown_method) == 0) ranking->scores[ranking->count++] = &scores[i];
    qsort(ranking->scores, ranking->count, sizeof *ranking->scores, compare_scores);
    return VW_OK;
}

// How many photos to show at each end, so that none is shown at both unless it is the only one.
static uint32_t count_shown(const struct ranking *ranking) {
    uint32_t half = ranking->count > 1 ? ranking->count / 2 : ranking->count;
    return half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END;
}

static void print_photo(const struct vw_scene *scene, const struct vw_ledger_score *score) {
    const struct vw_view *view = &scene->views[score->image_id];
    char standard_error[32] = "?"; // of a single visit
    if (isfinite(score->standard_error)) snprintf(standard_error, sizeof standard_error, "%.4f", score->standard_error);
    printf("  %+9.4f ± %s %s  %s", score->value, standard_error, score->unit, view->name);
    if (view->truth) printf(" (%s)", view->truth);
    putchar('\n');
}

static void print_ranking(const struct vw_scene *scene, const struct ranking *ranking) {
    uint32_t shown = count_shown(ranking);
    if (!shown) return;
    printf("most valuable photos (%s, positive = helps, ± standard error)\n", shown_method);
    for (uint32_t i = 0; i < shown; i++) print_photo(scene, ranking->scores[i]);
    printf("least valuable photos\n");
    for (uint32_t i = 0; i < shown; i++) print_photo(scene, ranking->scores[ranking->count - 1 - i]);
}

static void print_text(const struct vw_training_run *run, const struct ranking *ranking) {
    print_ranking(run->scene, ranking);
    printf("validation PSNR  %.2f dB before training, %.2f dB after %" PRIu64 " steps\n", run->first_val_psnr_db, run->last_val_psnr_db,
           run->done_steps);
    printf("ledger   %s\nscores   %s\nfield    %s\n", run->ledger_path, run->scores_path, run->field_path);
}

static json_t *photo_to_json(const struct vw_scene *scene, const struct vw_ledger_score *score) {
    const struct vw_view *view = &scene->views[score->image_id];
    return json_pack("{s:s, s:s, s:s?, s:s, s:o, s:s, s:o, s:I}", "name", view->name, "provider", view->provider, "truth", view->truth,
                     "method", score->method, "value", vw_json_real(score->value), "unit", score->unit, "stderr",
                     vw_json_real(score->standard_error), "visits", (json_int_t)score->visits);
}

static json_t *photos_to_json(const struct vw_scene *scene, const struct ranking *ranking, bool from_best) {
    json_t *array = json_array();
    for (uint32_t i = 0; array && i < count_shown(ranking); i++) {
        json_t *photo = photo_to_json(scene, ranking->scores[from_best ? i : ranking->count - 1 - i]);
        if (json_array_append_new(array, photo)) {
            json_decref(array);
            array = NULL;
        }
    }
    return array;
}

static enum vw_status print_json(const struct vw_training_run *run, const struct ranking *ranking) {
    json_t *root = vw_training_to_json(run);
    json_t *values =
        json_pack("{s:s, s:o, s:o, s:o, s:o}", "scores", run->scores_path, "val_psnr_start_db", vw_json_real(run->first_val_psnr_db),
                  "val_psnr_end_db", vw_json_real(run->last_val_psnr_db), "most_valuable", photos_to_json(run->scene, ranking, true),
                  "least_valuable", photos_to_json(run->scene, ranking, false));
    bool failed = !root || json_object_update(root, values);
    json_decref(values);
    if (!failed) return vw_json_print(root);
    json_decref(root);
    return vw_json_print(NULL);
}

static enum vw_status score_ledger(struct vw_training_run *run, const struct vw_ledger_image **images, uint32_t *image_count,
                                   struct vw_ledger_score **scores, uint32_t *score_count) {
    struct vw_step_record *records = NULL;
    uint64_t record_count = 0;
    enum vw_status status = vw_ledger_get_images(run->ledger, images, image_count);
    if (!status) status = vw_ledger_get_steps(run->ledger, &records, &record_count);
    if (!status)
        status = vw_value_score(records, record_count, run->options->config.burn_in_epochs, *images, *image_count, scores, score_count);
    free(records);
    return status;
}

// Scores what the ledger holds, keeps the scores in it, and writes and prints the outputs.
static enum vw_status conclude(struct vw_training_run *run) {
    const struct vw_ledger_image *images = NULL;
    struct vw_ledger_score *scores = NULL;
    struct ranking ranking = {0};
    uint32_t image_count = 0, score_count = 0;
    enum vw_status status = score_ledger(run, &images, &image_count, &scores, &score_count);
    if (!status) status = vw_training_finish(run, scores, score_count, images, image_count);
    if (!status) status = rank(scores, score_count, &ranking);
    if (!status && run->options->json) status = print_json(run, &ranking);
    else if (!status) print_text(run, &ranking);
    free(ranking.scores);
    free(scores);
    return status;
}

enum vw_status vw_command_value(const struct vw_options *options) {
    const struct vw_config *config = &options->config;
    if (config->epochs <= config->burn_in_epochs)
        vw_log_warning("--epochs %u leaves no epoch after --burn-in %u: steps are recorded, but there will be no scores", config->epochs,
                       config->burn_in_epochs);
    struct vw_training_run run;
    enum vw_status status = vw_training_open(options, true, &run);
    if (!status) status = vw_training_take_steps(&run);
    if (!status) status = conclude(&run);
    vw_training_close(&run);
    return status;
}

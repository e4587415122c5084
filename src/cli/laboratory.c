#include "cli/laboratory.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/interrupt.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/psnr.h"

// A view is measured on all its pixels where the views of its split have no more than so many in all, or on an even share of so many.
enum { PIXELS_OF_SPLIT = 1 << 13, PIXELS_OF_VIEW_MIN = 1 << 10, WHOLE_VIEWS = 0 };
static const double PROGRESS_S = 20;

static uint32_t epochs_of(const struct vw_laboratory *laboratory, const struct vw_trial *trial) {
    return trial->epochs ? trial->epochs : laboratory->options->config.epochs;
}

static enum vw_status create_trainer(struct vw_laboratory *laboratory, const struct vw_trial *trial, struct vw_trainer **trainer) {
    struct vw_config config = vw_config_without_probes(&laboratory->options->config); // they need validation, which trials go without
    config.seed = trial->seed;
    config.epochs = epochs_of(laboratory, trial);
    config.val_rays = vw_config_default.val_rays;
    config.burn_in_epochs = vw_config_default.burn_in_epochs;
    const struct vw_trainer_params params = {.gpu = laboratory->stage.gpu,
                                             .scene = laboratory->stage.scene,
                                             .config = &config,
                                             .effects = laboratory->stage.effects,
                                             .effect_count = laboratory->stage.effect_count};
    return vw_trainer_create(&params, trainer);
}

// What all trials share is in the run_id of one of them.
static enum vw_status name_base(struct vw_laboratory *laboratory) {
    struct vw_trainer *trainer = NULL;
    uint8_t run_id[VW_HASH_BYTES];
    enum vw_status status = create_trainer(laboratory, &(struct vw_trial){.seed = 0}, &trainer);
    if (!status) status = vw_trainer_run_id(trainer, run_id);
    vw_trainer_destroy(&trainer);
    if (status) return status;
    vw_hash_to_hex(run_id, laboratory->base_id);
    vw_hash_to_hex(laboratory->stage.scene->hash, laboratory->scene_hash);
    return VW_OK;
}

static enum vw_status open_trials(struct vw_laboratory *laboratory) {
    char *path = vw_path_join(laboratory->options->out, "trials.db");
    enum vw_status status = path ? vw_trials_open(path, &laboratory->trials) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_laboratory_open(const struct vw_options *options, struct vw_laboratory *laboratory) {
    laboratory->options = options;
    enum vw_status status = vw_stage_open(options, &laboratory->stage);
    if (!status) status = vw_stage_decide_effects(options, &laboratory->stage);
    if (!status) status = vw_scene_list_views(laboratory->stage.scene, VW_SPLIT_TRAIN, &laboratory->train_views, &laboratory->train_count);
    if (!status) status = name_base(laboratory);
    if (!status) status = open_trials(laboratory);
    return status;
}

void vw_laboratory_close(struct vw_laboratory *laboratory) {
    vw_trials_close(&laboratory->trials);
    vw_stage_close(&laboratory->stage);
    free(laboratory->train_views);
}

const char **vw_laboratory_list_truths(const struct vw_laboratory *laboratory, bool *known) {
    const char **truths = vw_allocate(laboratory->train_count, sizeof *truths);
    *known = false;
    for (uint32_t i = 0; truths && i < laboratory->train_count; i++) {
        const char *truth = laboratory->stage.scene->views[laboratory->train_views[i]].truth;
        truths[i] = truth ? truth : "clean";
        *known |= truth != NULL;
    }
    return truths;
}

// Photos are named, as in a run's subset_hash, so that an id does not depend on where they stand in the scene.
void vw_laboratory_name(const struct vw_laboratory *laboratory, const struct vw_trial *trial, char id[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth trial 1");
    vw_hasher_add_text(&hasher, laboratory->base_id);
    vw_hasher_add_integer(&hasher, epochs_of(laboratory, trial));
    vw_hasher_add_integer(&hasher, laboratory->whole_views ? WHOLE_VIEWS : PIXELS_OF_SPLIT);
    vw_hasher_add_integer(&hasher, (int64_t)trial->seed);
    for (uint32_t i = 0; i < trial->view_count; i++) vw_hasher_add_text(&hasher, laboratory->stage.scene->views[trial->views[i]].name);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, id);
}

// Leaves the split train to the views of the trial, or (NULL) to all that may be trained on.
static void choose_views(struct vw_laboratory *laboratory, const struct vw_trial *trial) {
    struct vw_scene *scene = laboratory->stage.scene;
    for (uint32_t i = 0; i < laboratory->train_count; i++)
        scene->views[laboratory->train_views[i]].split = trial ? VW_SPLIT_EXCLUDED : VW_SPLIT_TRAIN;
    for (uint32_t i = 0; trial && i < trial->view_count; i++) scene->views[trial->views[i]].split = VW_SPLIT_TRAIN;
    scene->split_count[VW_SPLIT_EXCLUDED] += scene->split_count[VW_SPLIT_TRAIN];
    scene->split_count[VW_SPLIT_TRAIN] = trial ? trial->view_count : laboratory->train_count;
    scene->split_count[VW_SPLIT_EXCLUDED] -= scene->split_count[VW_SPLIT_TRAIN];
}

static enum vw_status train(struct vw_trainer *trainer) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 1;
    enum vw_status status = VW_OK;
    while (!status && count > 0) status = vw_trainer_advance(trainer, &records, &count);
    return status;
}

// What was measured of views, one by one.
struct measured_views {
    uint32_t *views, count; // scene indices
    struct vw_view_error *errors;
    double *ssims; // NaN of a view that has none
};

static enum vw_status list_measured_views(const struct vw_scene *scene, struct measured_views *measured) {
    *measured = (struct measured_views){.views = vw_allocate(scene->view_count, sizeof *measured->views),
                                        .errors = vw_allocate(scene->view_count, sizeof *measured->errors),
                                        .ssims = vw_allocate(scene->view_count, sizeof *measured->ssims)};
    if (!measured->views || !measured->errors || !measured->ssims) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split != VW_SPLIT_VAL && scene->views[v].split != VW_SPLIT_TEST) continue;
        measured->ssims[measured->count] = NAN;
        measured->views[measured->count++] = v;
    }
    return VW_OK;
}

// The means over the measured views of a split.
static void conclude_split(const struct vw_scene *scene, enum vw_split split, const struct measured_views *measured, double *psnr_db,
                           double *ssim, double *l1) {
    uint32_t of_split = scene->split_count[split], with_ssim = 0;
    double ssim_sum = 0;
    *psnr_db = *l1 = of_split ? 0 : NAN;
    for (uint32_t i = 0; i < measured->count; i++) {
        if (scene->views[measured->views[i]].split != split) continue;
        *psnr_db += vw_psnr_db(measured->errors[i].mse) / of_split;
        *l1 += measured->errors[i].l1 / of_split;
        if (isnan(measured->ssims[i])) continue;
        ssim_sum += measured->ssims[i];
        with_ssim++;
    }
    *ssim = with_ssim ? ssim_sum / with_ssim : NAN;
}

static enum vw_status measure_shares(struct vw_trainer *trainer, const struct vw_scene *scene, struct measured_views *measured) {
    uint32_t larger = scene->split_count[VW_SPLIT_VAL];
    if (larger < scene->split_count[VW_SPLIT_TEST]) larger = scene->split_count[VW_SPLIT_TEST];
    uint32_t pixels = PIXELS_OF_SPLIT / (larger ? larger : 1);
    if (pixels < PIXELS_OF_VIEW_MIN) pixels = PIXELS_OF_VIEW_MIN;
    return vw_trainer_measure_views(trainer, measured->views, measured->count, pixels, measured->errors);
}

// Both splits at once: of shares of views, setting up is most of the cost.
static enum vw_status measure(const struct vw_laboratory *laboratory, struct vw_trainer *trainer, const char *id,
                              struct vw_outcome *outcome) {
    const struct vw_scene *scene = laboratory->stage.scene;
    struct measured_views measured;
    enum vw_status status = list_measured_views(scene, &measured);
    if (!status && laboratory->whole_views)
        status = vw_whole_views_measure(trainer, measured.views, measured.count, &laboratory->kept, id, measured.errors, measured.ssims);
    else if (!status) status = measure_shares(trainer, scene, &measured);
    if (!status) {
        conclude_split(scene, VW_SPLIT_VAL, &measured, &outcome->val_psnr, &outcome->val_ssim, &outcome->val_l1);
        conclude_split(scene, VW_SPLIT_TEST, &measured, &outcome->test_psnr, &outcome->test_ssim, &outcome->test_l1);
    }
    free(measured.views);
    free(measured.errors);
    free(measured.ssims);
    return status;
}

static enum vw_status train_and_measure(struct vw_laboratory *laboratory, const struct vw_trial *trial, const char *id,
                                        struct vw_outcome *outcome) {
    struct vw_trainer *trainer = NULL;
    double started_s = vw_cpu_s();
    enum vw_status status = create_trainer(laboratory, trial, &trainer);
    if (!status) status = train(trainer);
    if (!status) status = measure(laboratory, trainer, id, outcome);
    vw_trainer_destroy(&trainer);
    outcome->seconds = vw_cpu_s() - started_s;
    return status;
}

static enum vw_status make(struct vw_laboratory *laboratory, const struct vw_trial *trial, const char *id, struct vw_outcome *outcome) {
    if (vw_interrupt_requested())
        return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; %s keeps the trials that ended; the same command goes on",
                       laboratory->options->out);
    choose_views(laboratory, trial);
    enum vw_status status = train_and_measure(laboratory, trial, id, outcome);
    choose_views(laboratory, NULL);
    struct vw_trial made = *trial;
    made.epochs = epochs_of(laboratory, trial);
    if (!status) status = vw_trials_add(laboratory->trials, id, laboratory->scene_hash, &made, outcome);
    if (status) return status;
    laboratory->made++;
    return VW_OK;
}

// Every so often, and at the end, what is done and what is left.
static void say_progress(struct vw_laboratory *laboratory) {
    double now_s = vw_now_s();
    uint64_t done = laboratory->made + laboratory->recalled;
    if (laboratory->made == 1) laboratory->started_s = laboratory->said_s = now_s;
    if (now_s - laboratory->said_s < PROGRESS_S && done < laboratory->planned) return;
    laboratory->said_s = now_s;
    double each_s = laboratory->made > 1 ? (now_s - laboratory->started_s) / (double)(laboratory->made - 1) : NAN;
    uint64_t left = laboratory->planned > done ? laboratory->planned - done : 0;
    vw_log_info("trials   %" PRIu64 " of %" PRIu64 ", %.2g s each, about %.0f min left", done, laboratory->planned, each_s,
                ceil(each_s * (double)left / 60));
}

enum vw_status vw_laboratory_try(void *context, const struct vw_trial *trial, struct vw_outcome *outcome) {
    struct vw_laboratory *laboratory = context;
    char id[VW_HASH_HEX_BYTES];
    bool found = false;
    vw_laboratory_name(laboratory, trial, id);
    enum vw_status status = vw_trials_find(laboratory->trials, id, &found, outcome);
    if (status) return status;
    found = found && vw_kept_views_exist(&laboratory->kept, id);
    if (!found) status = make(laboratory, trial, id, outcome);
    else laboratory->recalled++;
    if (!status && !found) say_progress(laboratory);
    return status;
}

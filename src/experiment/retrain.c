#include "experiment/retrain.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "base/text.h"
#include "run/plan/plan.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static const double REPORT_S = 20; // between two lines of the log

static uint32_t epochs_of(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining) {
    return retraining->epochs ? retraining->epochs : retrainer->params.config->epochs;
}

static bool gains(const struct vw_retrain_params *retraining) {
    return retraining->photo_count > 0 && retraining->photos_of == VW_RETRAIN_PHOTOS_GAINS;
}

// Returns the views of which the retraining saves a picture.
static struct vw_saved_views saved_by(const struct vw_retrainer *retrainer,
                                      const struct vw_retrain_params *retraining) {
    struct vw_saved_views saved = retrainer->saved_views;
    if (saved.seed != retraining->seed) saved.count = 0;
    return saved;
}

static uint32_t list_left_out(struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining) {
    uint32_t count = 0, kept = 0;
    for (uint32_t i = 0; i < retrainer->train_count; i++)
        if (kept < retraining->view_count && retraining->views[kept] == retrainer->train_views[i]) kept++;
        else retrainer->left_out[count++] = retrainer->train_views[i];
    return count;
}

// Fills the params of a trainer: on all photos of which it keeps the retraining's, on these alone, or on all if it
// names none. The params borrow from `config`, which it fills, too.
static struct vw_trainer_params params_of(struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                                          uint32_t device, struct vw_config *config) {
    const struct vw_session *session = retrainer->params.session;
    bool some = retraining->view_count > 0, alone = some && retrainer->params.equal == VW_EQUAL_EPOCHS;
    *config = *retrainer->params.config;
    config->seed = retraining->seed;
    vw_config_set_epochs(config, epochs_of(retrainer, retraining));
    // Retrainings validate at their end alone: what validation during a run is set to must not change their ids.
    if (!gains(retraining)) config->val_rays = vw_config_default.val_rays;
    config->burn_in_epochs = vw_config_default.burn_in_epochs;
    return (struct vw_trainer_params){.gpu = session->devices[device].gpu,
                                      .scene = session->scene,
                                      .config = config,
                                      .effects = session->effects,
                                      .effect_count = session->effect_count,
                                      .train_views = alone ? retraining->views : retrainer->train_views,
                                      .train_view_count = alone ? retraining->view_count : retrainer->train_count,
                                      .left_out_views = retrainer->left_out,
                                      .left_out_count = some && !alone ? list_left_out(retrainer, retraining) : 0,
                                      .validate = gains(retraining),
                                      .submissions = session->devices[device].submissions};
}

static enum vw_status create_trainer(struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                                     uint32_t device, struct vw_trainer **trainer) {
    struct vw_config config;
    const struct vw_trainer_params params = params_of(retrainer, retraining, device, &config);
    return vw_trainer_create(&params, trainer);
}

// Creates the trainer of one retraining: its run_id covers all that they share.
static enum vw_status try_base(struct vw_retrainer *retrainer) {
    struct vw_trainer *trainer = NULL;
    uint8_t run_id[VW_HASH_BYTES];
    enum vw_status status = create_trainer(retrainer, &(struct vw_retrain_params){.seed = 0}, 0, &trainer);
    if (!status) status = vw_trainer_run_id(trainer, run_id);
    vw_trainer_destroy(&trainer);
    if (status) return status;
    vw_hash_to_hex(run_id, retrainer->base_id);
    vw_hash_to_hex(retrainer->params.session->scene->hash, retrainer->scene_hash);
    return VW_OK;
}

static enum vw_status open_retrainings(struct vw_retrainer *retrainer) {
    const char *out = retrainer->params.out;
    if (!out) return vw_retraining_store_open(NULL, &retrainer->retrainings);
    char *path = vw_path_join(out, "retrainings.db");
    enum vw_status status = path ? vw_retraining_store_open(path, &retrainer->retrainings) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_retrainer_open(const struct vw_retrainer_params *params, struct vw_retrainer *retrainer) {
    retrainer->params = *params;
    enum vw_status status = vw_session_decide_effects(params->config, params->session);
    if (!status)
        status = vw_scene_list_views(params->session->scene, VW_SPLIT_TRAIN, &retrainer->train_views,
                                     &retrainer->train_count);
    retrainer->left_out = vw_allocate(retrainer->train_count, sizeof *retrainer->left_out);
    if (!status && !retrainer->left_out) status = VW_ERROR_MEMORY;
    if (!status) status = try_base(retrainer);
    if (!status) status = open_retrainings(retrainer);
    return status;
}

void vw_retrainer_close(struct vw_retrainer *retrainer) {
    vw_retraining_store_close(&retrainer->retrainings);
    free(retrainer->train_views);
    free(retrainer->left_out);
}

// Hashes the names of the photos, as a run's subset_hash does: an id does not depend on the order of the scene file.
void vw_retrainer_name(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                       char id[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth retraining 2");
    vw_hasher_add_text(&hasher, retrainer->base_id);
    vw_hasher_add_integer(&hasher, epochs_of(retrainer, retraining));
    vw_hasher_add_integer(&hasher, retrainer->params.whole_views ? 0 : VW_PIXELS_OF_SPLIT);
    vw_hasher_add_integer(&hasher, retrainer->params.equal);
    vw_hasher_add_integer(&hasher, retrainer->params.averaged_epochs);
    vw_hasher_add_integer(&hasher, (int64_t)retraining->seed);
    for (uint32_t i = 0; i < retraining->view_count; i++)
        vw_hasher_add_text(&hasher, retrainer->params.session->scene->views[retraining->views[i]].name);
    // Rows of train photos are others than those of an equal retraining that is measured at the end.
    if (gains(retraining)) {
        vw_hasher_add_text(&hasher, "gains");
        vw_hasher_add_integer(&hasher, retrainer->params.config->val_rays);
    }
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, id);
}

struct making {
    struct vw_trainer *trainer; // NULL: it is not made now
    const struct vw_retrain_params *retraining;
    struct vw_retrain_result *result;
    char id[VW_HASH_HEX_BYTES];
    uint32_t ends, measured;       // ends of epochs to measure, and of these, those that were
    struct vw_retrain_view *views; // owned; means over these ends, then the gains
    uint32_t view_count;
    double val_psnr; // after the last step, of gains; NaN: no step had a value yet
};

enum vw_status vw_retrainer_announce(struct vw_retrainer *retrainer, const struct vw_retrain_params *retrainings,
                                     uint32_t count) {
    struct vw_estimate estimate = {0};
    struct vw_retrain_result recorded;
    struct vw_config config;
    uint32_t left = 0;
    char(*ids)[VW_HASH_HEX_BYTES] = vw_allocate(count, sizeof *ids), about[VW_ABOUT_BYTES];
    enum vw_status status = ids ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++) {
        bool found = false;
        vw_retrainer_name(retrainer, &retrainings[i], ids[i]);
        status = vw_retraining_store_find(retrainer->retrainings, ids[i], &found, &recorded);
        for (uint32_t j = 0; j < i && !found; j++) found = !strcmp(ids[j], ids[i]);
        left += !found;
    }
    free(ids);
    if (status || !left) return status;
    const struct vw_trainer_params params = params_of(retrainer, retrainings, 0, &config);
    status = vw_estimate_take_steps(&params, &estimate);
    if (status) estimate.seconds_per_step = NAN; // the training itself fails, after those before it
    vw_text_about(left * estimate.seconds_per_step * (double)estimate.steps / retrainer->params.session->device_count,
                  about);
    vw_log_info("%u training%s%s; Ctrl-C keeps what is done", left, vw_plural(left), about);
    return VW_OK;
}

// Logs now and then, and at the end, what is done and what is left.
static void report_progress(struct vw_retrainer *retrainer) {
    double now_s = vw_now_s();
    uint64_t done = retrainer->made + retrainer->recalled;
    if (retrainer->made == 1) retrainer->started_s = retrainer->reported_s = now_s;
    if (now_s - retrainer->reported_s < REPORT_S && done < retrainer->planned) return;
    retrainer->reported_s = now_s;
    uint64_t left = retrainer->planned > done ? retrainer->planned - done : 0;
    char each[VW_DURATION_BYTES] = "unknown", rest[VW_DURATION_BYTES] = "unknown";
    if (retrainer->made > 1) {
        double each_s = (now_s - retrainer->started_s) / (double)(retrainer->made - 1);
        vw_text_duration(each_s, each);
        vw_text_duration(each_s * (double)left, rest);
    }
    vw_log_info("retrainings   %" PRIu64 " of %" PRIu64 ", %s each, about %s left", done, retrainer->planned, each,
                rest);
}

// ---- Several at a time ----

// The retrainings of a call.
struct work {
    struct vw_retrainer *retrainer;
    const struct vw_retrain_params *retrainings;
    struct vw_retrain_result *results;
    struct making *makings; // owned; by retraining
    uint32_t count;
};

static bool is_being_made(const struct work *work, const char *id) {
    bool made = false;
    for (uint32_t i = 0; i < work->count && !made; i++)
        made = work->makings[i].trainer && !strcmp(work->makings[i].id, id);
    return made;
}

// Holds the trainer at the end of the epoch that is measured next: the last of them is the end of the training.
static void release(struct making *making) {
    uint64_t epoch = vw_trainer_epoch_end(making->trainer, 1), left = making->ends - 1 - making->measured;
    uint64_t total = making->retraining->view_count > 0 ? vw_trainer_total_steps(making->trainer) : 0;
    vw_trainer_stop_after(making->trainer, total - left * epoch);
}

// Finds the recorded result, if it lacks nothing.
static enum vw_status recall(struct vw_retrainer *retrainer, const struct making *making, bool *found) {
    const struct vw_retrain_params *retraining = making->retraining;
    const struct vw_saved_views saved = saved_by(retrainer, retraining);
    struct vw_retrain_result recorded;
    *found = false;
    enum vw_status status = vw_retraining_store_find(retrainer->retrainings, making->id, found, &recorded);
    *found = !status && *found && vw_saved_views_exist(&saved, making->id);
    if (*found && retraining->photo_count > 0)
        status = vw_retraining_store_recall_views(retrainer->retrainings, making->id, retraining->photos,
                                                  retraining->photo_count, found);
    if (!status && *found) *making->result = recorded;
    return status;
}

static enum vw_status fail_interrupted(const char *out) {
    if (!out) return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; no retraining made again has differed so far");
    return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; %s keeps the finished retrainings; the same command resumes",
                   out);
}

static enum vw_status create(struct vw_retrainer *retrainer, struct making *making, uint32_t device) {
    const struct vw_retrain_params *retraining = making->retraining;
    uint32_t epochs = epochs_of(retrainer, retraining), averaged = retrainer->params.averaged_epochs;
    if (vw_interrupt_requested(&retrainer->params.interrupt)) return fail_interrupted(retrainer->params.out);
    making->ends = retraining->view_count > 0 && averaged > 1 ? averaged : 1;
    if (making->ends > epochs) making->ends = epochs;
    making->val_psnr = NAN;
    *making->result = (struct vw_retrain_result){0};
    for (uint32_t i = 0; i < retraining->photo_count; i++) retraining->photos[i].psnr_db = 0;
    enum vw_status status = create_trainer(retrainer, retraining, device, &making->trainer);
    if (!status) release(making);
    return status;
}

// Begins a retraining, or recalls it. One that equals another that is being made waits for that one.
static enum vw_status begin(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct work *work = context;
    struct making *making = &work->makings[seat->place];
    bool recalled = false;
    making->retraining = &work->retrainings[seat->place];
    making->result = &work->results[seat->place];
    vw_retrainer_name(work->retrainer, making->retraining, making->id);
    *answer = VW_POOL_WAITS;
    if (is_being_made(work, making->id)) return VW_OK;
    enum vw_status status = recall(work->retrainer, making, &recalled);
    work->retrainer->recalled += recalled;
    *answer = recalled ? VW_POOL_NO_SEAT : VW_POOL_SEATED;
    return status || recalled ? status : create(work->retrainer, making, seat->device);
}

static enum vw_status add_views(struct making *making, const struct vw_measured_views *measured) {
    const struct vw_retrain_params *retraining = making->retraining;
    if (!making->views) making->views = vw_allocate(measured->count + retraining->photo_count, sizeof *making->views);
    if (!making->views) return VW_ERROR_MEMORY;
    making->view_count = measured->count;
    for (uint32_t i = 0; i < measured->count; i++) {
        making->views[i].image_id = measured->views[i];
        making->views[i].psnr_db += vw_psnr_db(measured->errors[i].mse) / making->ends;
    }
    return VW_OK;
}

// Sums up what steps gain. A step without a value gains nothing: the next one that has a value takes what it did.
static void add_gains(struct making *making, const struct vw_step_record *records, uint32_t count) {
    const struct vw_retrain_params *retraining = making->retraining;
    for (uint32_t i = 0; gains(retraining) && i < count; i++) {
        if (!isfinite(records[i].val_psnr)) continue;
        for (uint32_t photo = 0; photo < retraining->photo_count; photo++)
            if (retraining->photos[photo].image_id == records[i].view)
                retraining->photos[photo].psnr_db += records[i].val_psnr - making->val_psnr;
        making->val_psnr = records[i].val_psnr;
    }
}

// Fills the photos that were asked for, and makes rows of gains.
static void take_photos(struct making *making) {
    const struct vw_retrain_params *retraining = making->retraining;
    for (uint32_t i = 0; i < retraining->photo_count; i++)
        if (gains(retraining)) making->views[making->view_count++] = retraining->photos[i];
        else retraining->photos[i] = making->views[making->view_count - retraining->photo_count + i];
}

static enum vw_status take_measures(const struct vw_retrainer *retrainer, struct making *making) {
    struct vw_retrain_result measured, *mean = making->result;
    struct vw_measured_views views;
    const struct vw_saved_views saved = saved_by(retrainer, making->retraining);
    enum vw_status status =
        vw_measured_views_make(making->trainer, retrainer->params.session->scene, making->retraining,
                               retrainer->params.whole_views ? &saved : NULL, making->id, &views, &measured);
    if (!status) status = add_views(making, &views);
    vw_measured_views_free(&views);
    if (status) return status;
    mean->val_psnr += measured.val_psnr / making->ends;
    mean->val_ssim += measured.val_ssim / making->ends;
    mean->val_l1 += measured.val_l1 / making->ends;
    mean->test_psnr += measured.test_psnr / making->ends;
    mean->test_ssim += measured.test_ssim / making->ends;
    mean->test_l1 += measured.test_l1 / making->ends;
    making->measured++;
    return VW_OK;
}

// Takes one submission of steps, and measures where the trainer is held.
static enum vw_status advance(void *context, const struct vw_pool_seat *seat, bool *ended) {
    struct work *work = context;
    struct making *making = &work->makings[seat->place];
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_trainer_advance(making->trainer, &records, &count);
    if (!status && count > 0) add_gains(making, records, count);
    if (status || count > 0) return status;
    status = take_measures(work->retrainer, making);
    *ended = making->measured == making->ends;
    if (!status && !*ended) release(making);
    return status;
}

static enum vw_status record(struct vw_retrainer *retrainer, struct making *making) {
    struct vw_retrain_params made = *making->retraining;
    made.epochs = epochs_of(retrainer, making->retraining);
    take_photos(making);
    enum vw_status status = vw_retraining_store_add(retrainer->retrainings, making->id, retrainer->scene_hash, &made,
                                                    making->result, making->views, making->view_count);
    if (status) return status;
    retrainer->made++;
    report_progress(retrainer);
    return VW_OK;
}

static enum vw_status end(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    struct work *work = context;
    struct making *making = &work->makings[seat->place];
    making->result->seconds = seat->cpu_s;
    if (!status) status = record(work->retrainer, making);
    vw_trainer_destroy(&making->trainer);
    free(making->views);
    return status;
}

enum vw_status vw_retrain(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                          struct vw_retrain_result *results) {
    struct vw_retrainer *retrainer = context;
    struct work work = {.retrainer = retrainer,
                        .retrainings = retrainings,
                        .results = results,
                        .makings = vw_allocate(count, sizeof *work.makings),
                        .count = count};
    const struct vw_training_pool pool = {.devices = retrainer->params.session->devices,
                                          .device_count = retrainer->params.session->device_count,
                                          .together = retrainer->params.together,
                                          .begin = begin,
                                          .advance = advance,
                                          .end = end,
                                          .context = &work};
    enum vw_status status = work.makings ? vw_training_pool_run(&pool, count) : VW_ERROR_MEMORY;
    free(work.makings);
    return status;
}

enum vw_status vw_retrain_announced(struct vw_retrainer *retrainer, const struct vw_retrain_params *retrainings,
                                    uint32_t count, struct vw_retrain_result *results) {
    retrainer->planned = count;
    enum vw_status status = vw_retrainer_announce(retrainer, retrainings, count);
    return status ? status : vw_retrain(retrainer, retrainings, count, results);
}

enum vw_status vw_retrainer_find_views(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                                       struct vw_retrain_view *views, uint32_t view_count) {
    char id[VW_HASH_HEX_BYTES];
    vw_retrainer_name(retrainer, retraining, id);
    return vw_retraining_store_find_views(retrainer->retrainings, id, views, view_count);
}

// ---- Comparing with recorded ones ----

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static bool same_result(const struct vw_retrain_result *a, const struct vw_retrain_result *b) {
    return same(a->val_psnr, b->val_psnr) && same(a->val_ssim, b->val_ssim) && same(a->val_l1, b->val_l1) &&
           same(a->test_psnr, b->test_psnr) && same(a->test_ssim, b->test_ssim) && same(a->test_l1, b->test_l1);
}

// Compares what a retraining reaches on single validation and test photos.
static enum vw_status compare_views(const struct vw_retrainer *retrainer, struct vw_retraining_store *recorded,
                                    const char *id, bool *equal) {
    const struct vw_scene *scene = retrainer->params.session->scene;
    enum vw_status status = VW_OK;
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        if (scene->views[v].split != VW_SPLIT_VAL && scene->views[v].split != VW_SPLIT_TEST) continue;
        struct vw_retrain_view made = {.image_id = v}, its = {.image_id = v};
        status = vw_retraining_store_find_views(retrainer->retrainings, id, &made, 1);
        if (!status) status = vw_retraining_store_find_views(recorded, id, &its, 1);
        *equal &= same(made.psnr_db, its.psnr_db);
    }
    return status;
}

enum vw_status vw_retrainer_compare(const struct vw_retrainer *retrainer, struct vw_retraining_store *recorded,
                                    const struct vw_retrain_params *retraining,
                                    const struct vw_retrain_result *result) {
    struct vw_retrain_result its = {0};
    char id[VW_HASH_HEX_BYTES];
    bool found = false;
    vw_retrainer_name(retrainer, retraining, id);
    enum vw_status status = vw_retraining_store_find(recorded, id, &found, &its);
    if (status || !found) return status;
    bool equal = same_result(result, &its);
    if (equal) status = compare_views(retrainer, recorded, id, &equal);
    if (status || equal) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "retrainings.db: retraining %s, made again, has a validation PSNR of %.9g dB or photos that are not "
                   "the recorded ones (%.9g dB): this program did not make it on this device",
                   id, result->val_psnr, its.val_psnr);
}

// ---- Retraining the photos of a recorded run ----

enum vw_status vw_session_open_recorded(struct vw_recorded_run *recorded, const struct vw_device_choice *devices,
                                        struct vw_session *session) {
    enum vw_status status = vw_recorded_open_scene(recorded, devices->first ? devices->first : recorded->row.device);
    if (!status) status = vw_recorded_check_images(recorded);
    if (status) return status;
    session->devices[0].gpu = recorded->gpu;
    session->device_count = 1;
    session->scene = recorded->scene;
    session->effect_count = recorded->effect_count;
    memcpy(session->effects, recorded->effects, sizeof session->effects);
    status = vw_submissions_create(recorded->gpu, &session->devices[0].submissions);
    return status ? status : vw_session_open_others(devices, false, session);
}

void vw_session_close_recorded(struct vw_session *session) {
    session->scene = NULL;
    session->devices[0].gpu = NULL;
    vw_session_close(session);
}

struct vw_config vw_config_of_retrainings(const struct vw_recorded_run *recorded, const struct vw_value_input *steps) {
    struct vw_config config = recorded->config;
    // A budget may have ended the run before all of its epochs.
    uint32_t last = steps->record_count ? steps->records[steps->record_count - 1].epoch : 0;
    if (last < config.epochs) config.epochs = last + 1;
    config.vary = VW_VARY_ALL; // seeds of a run of `reproduce --vary` change less
    config.base_seed = 0;
    return config;
}

uint64_t vw_first_seed_after(uint64_t own) { return own < (uint64_t)INT64_MAX - UINT32_MAX ? own + 1 : 0; }

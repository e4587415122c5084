#include "experiment/worth.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "experiment/retrain.h"
#include "run/imported/imported_run.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/run_outputs.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

// ---- Subsets --------------------------------------------------------------------------------------------------------

// ---- Subsets -------------------------------------------------------------------------------------------------------

// Leaves out the subset of all: the retrainings on all photos are others.
static void drop_all(struct vw_subsets *subsets) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < subsets->count; i++) {
        uint32_t size = vw_subset_size(subsets, i);
        if (size == subsets->photo_count) continue;
        memmove(subsets->places + subsets->offsets[kept], subsets->places + subsets->offsets[i],
                size * sizeof *subsets->places);
        subsets->offsets[kept + 1] = subsets->offsets[kept] + size;
        kept++;
    }
    subsets->count = kept;
}

static enum vw_status draw(struct vw_worth_subsets *drawn) {
    const struct vw_worth_subsets_params *params = &drawn->params;
    uint32_t needed = params->count - (params->count + VW_WORTH_REPEAT_EVERY - 1) / VW_WORTH_REPEAT_EVERY;
    enum vw_status status = vw_subsets_draw(
        &(struct vw_subsets_params){
            .photo_count = params->photo_count, .random_sizes = needed + 1, .seed_count = 1, .key = params->key},
        &drawn->subsets);
    if (!status) drop_all(&drawn->subsets);
    if (!status && drawn->subsets.count < needed)
        status = vw_fail(VW_ERROR_INPUT,
                         "--retrainings %" PRIu32 ": %" PRIu32 " photos have only %" PRIu32
                         " subsets of 40 to 100 %%; ask for fewer retrainings",
                         params->count, params->photo_count, drawn->subsets.count);
    return status;
}

enum vw_status vw_worth_subsets_draw(const struct vw_worth_subsets_params *params, struct vw_worth_subsets *drawn) {
    *drawn = (struct vw_worth_subsets){.params = *params};
    if (params->photo_count < 2) return vw_fail(VW_ERROR_INPUT, "worth needs at least 2 photos to train on");
    return draw(drawn);
}

// ---- Retrainings ---------------------------------------------------------------------------------------------------

static bool has_player(const struct vw_subsets *subsets, uint32_t subset, uint32_t player) {
    for (uint32_t i = subsets->offsets[subset]; i < subsets->offsets[subset + 1]; i++)
        if (subsets->places[i] == player) return true;
    return false;
}

static void list_photos(const struct vw_worth_subsets *drawn, uint32_t number, uint32_t *ids,
                        struct vw_ledger_retraining *retraining) {
    const struct vw_worth_subsets_params *params = &drawn->params;
    uint32_t count = 0;
    for (uint32_t i = 0; i < params->photo_count; i++)
        if (vw_worth_is_of_all(number) || has_player(&drawn->subsets, vw_worth_place(number), i))
            ids[count++] = params->photos[i];
    *retraining = (struct vw_ledger_retraining){.seed = params->first_seed + number,
                                                .epochs = params->epochs,
                                                .image_ids = ids,
                                                .image_count = count,
                                                .val_psnr = NAN};
}

enum vw_status vw_worth_retrainings_list(const struct vw_worth_subsets *drawn, uint32_t count,
                                         struct vw_ledger_retraining **retrainings) {
    size_t photos = drawn->params.photo_count;
    struct vw_ledger_retraining *made = vw_allocate(count, sizeof *made + photos * sizeof(uint32_t));
    if (!made) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(made + count);
    for (uint32_t i = 0; i < count; i++) list_photos(drawn, i, ids + i * photos, &made[i]);
    *retrainings = made;
    return VW_OK;
}

static void describe(const struct vw_ledger_retraining *retrainings, uint32_t count,
                     struct vw_retrain_params *trained) {
    for (uint32_t i = 0; i < count; i++)
        trained[i] = (struct vw_retrain_params){
            .views = retrainings[i].image_ids, .view_count = retrainings[i].image_count, .seed = retrainings[i].seed};
}

enum vw_status vw_worth_retrainings_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                          vw_retrain_function *retrain, void *context) {
    struct vw_retrain_params *trained = vw_allocate(count - first, sizeof *trained);
    struct vw_retrain_result *results = vw_allocate(count - first, sizeof *results);
    enum vw_status status = trained && results ? VW_OK : VW_ERROR_MEMORY;
    if (!status) describe(retrainings + first, count - first, trained);
    if (!status) status = retrain(context, trained, count - first, results);
    for (uint32_t i = first; !status && i < count; i++)
        retrainings[i].val_psnr = isfinite(results[i - first].val_psnr) ? results[i - first].val_psnr : NAN;
    free(trained);
    free(results);
    return status;
}

// ---- Worth ----------------------------------------------------------------------------------------------------------

// With until_confidence, whether it is reached is asked after so many retrainings; the ledger gets them in such groups.
enum { GROUP = 8 };

struct work {
    const struct vw_worth_run_params *params;
    struct vw_worth_run *result;
    struct vw_config config; // config of the retrainings
    struct vw_out_lock *lock;
    struct vw_ledger *ledger;  // the run's, opened to append; NULL while nothing is to be written
    struct vw_session session; // device and scene are the run's
    struct vw_retrainer retrainer;
    uint64_t payout_cents; // to be divided; 0: none
    struct vw_worth_subsets drawn;
};

// ---- Retraining ----------------------------------------------------------------------------------------------------

static bool is_same(const struct vw_ledger_retraining *a, const struct vw_ledger_retraining *b) {
    return a->seed == b->seed && a->epochs == b->epochs && a->image_count == b->image_count &&
           !memcmp(a->image_ids, b->image_ids, a->image_count * sizeof *a->image_ids);
}

static uint32_t count_recorded(const struct work *work) { return work->result->scoring.retraining_count; }

// Lists the first `count` retrainings, of which those of the ledger have outcomes.
static enum vw_status list_retrainings(const struct work *work, uint32_t count, struct vw_ledger_retraining **rows) {
    const struct vw_scoring *scoring = &work->result->scoring;
    struct vw_ledger_retraining *made = NULL;
    enum vw_status status = vw_worth_retrainings_list(&work->drawn, count, &made);
    for (uint32_t i = 0; !status && i < scoring->retraining_count; i++) {
        made[i].val_psnr = scoring->retrainings[i].val_psnr;
        if (!is_same(&made[i], &scoring->retrainings[i]))
            status = vw_fail(VW_ERROR_MISMATCH,
                             "%s: retraining %" PRIu32 " is not the one that this version makes; value the scene again",
                             work->result->recorded.ledger_path, i);
    }
    if (status) free(made);
    else *rows = made;
    return status;
}

static enum vw_status write_scores(struct work *work) {
    struct vw_worth_run *result = work->result;
    if (!result->scores_path) result->scores_path = vw_path_join(result->recorded.out, "scores.csv");
    if (!result->scores_path) return VW_ERROR_MEMORY;
    return vw_run_scores_write(result->recorded.out, &result->scoring, work->payout_cents > 0);
}

static enum vw_status record(struct work *work, uint32_t first) {
    struct vw_scoring *scoring = &work->result->scoring;
    enum vw_status status = write_scores(work);
    if (!status)
        status = vw_ledger_add_retrainings(work->ledger, scoring->retrainings + first,
                                           scoring->retraining_count - first, scoring->scores, scoring->score_count);
    return status;
}

// Makes those that are missing of so many.
static enum vw_status add_group(struct work *work, uint32_t count) {
    struct vw_scoring *scoring = &work->result->scoring;
    struct vw_ledger_retraining *rows = NULL;
    uint32_t first = scoring->retraining_count;
    enum vw_status status = list_retrainings(work, count, &rows);
    if (!status) status = vw_worth_retrainings_train(rows, first, count, vw_retrain, &work->retrainer);
    if (!status) status = vw_scoring_set_retrainings(scoring, rows, count);
    else free(rows);
    return status ? status : record(work, first);
}

static enum vw_status summarise(struct work *work, bool *reached) {
    const struct vw_worth_input input = vw_scoring_worth_input(&work->result->scoring);
    enum vw_status status = vw_worth_summarise(&input, &work->result->summary);
    const struct vw_worth_summary *summary = &work->result->summary;
    *reached = summary->claim_count && work->params->until_confidence > 0 &&
               summary->claims[0].accuracy.ci_low >= work->params->until_confidence;
    return status;
}

static uint32_t count_missing(const struct work *work) {
    uint32_t recorded = count_recorded(work);
    return work->params->retrainings > recorded ? work->params->retrainings - recorded : 0;
}

// Tells the price of all that are missing.
static enum vw_status announce(struct work *work) {
    uint32_t first = count_recorded(work), count = count_missing(work);
    struct vw_ledger_retraining *rows = NULL;
    struct vw_retrain_params *trained = vw_allocate(count, sizeof *trained);
    enum vw_status status = trained ? list_retrainings(work, first + count, &rows) : VW_ERROR_MEMORY;
    if (!status) describe(rows + first, count, trained);
    if (!status) status = vw_retrainer_announce(&work->retrainer, trained, count);
    free(rows);
    free(trained);
    return status;
}

// Asks for the accuracy at the same numbers of retrainings, wherever it began.
static enum vw_status retrain(struct work *work) {
    uint32_t most = work->params->retrainings, made;
    bool reached = false;
    enum vw_status status = VW_OK;
    work->retrainer.planned = count_missing(work);
    if (work->params->until_confidence > 0) status = summarise(work, &reached);
    if (!status && !reached) status = announce(work);
    while (!status && !reached && (made = count_recorded(work)) < most) {
        uint32_t next = (made / GROUP + 1) * GROUP;
        status = add_group(work, next < most ? next : most);
        if (!status && work->params->until_confidence > 0) status = summarise(work, &reached);
    }
    return status;
}

// ---- Outputs -------------------------------------------------------------------------------------------------------

static enum vw_status write_outputs(struct work *work) {
    struct vw_recorded_run *recorded = &work->result->recorded;
    struct vw_run_outputs_params params = {
        .out = work->params->out,
        .scene = recorded->scene,
        .scene_options_json = recorded->row.scene_options_json,
        .gpu = recorded->gpu,
        .ledger = work->ledger,
        .scoring = &work->result->scoring,
        .config = &recorded->config,
        .effects = recorded->effects,
        .effect_count = recorded->effect_count,
        .payout_cents = work->payout_cents,
        .report = {.device = work->params->devices.first, .options = work->params->report}};
    enum vw_status status = vw_scoring_compare(&work->result->scoring, work->ledger, recorded->ledger_path);
    if (!status) status = write_scores(work);
    if (!status) status = vw_recorded_load_field(recorded, &params.trainer);
    if (!status) status = vw_run_outputs_make(&params, &work->result->outputs);
    if (!status) status = vw_checksums_write(params.out, params.ledger);
    vw_ledger_chain_head(work->ledger, work->result->head); // a payout changes it
    vw_trainer_destroy(&params.trainer);
    return status;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static enum vw_status check_run(struct work *work) {
    const struct vw_recorded_run *recorded = &work->result->recorded;
    if (vw_is_imported(&recorded->row))
        return vw_fail(VW_ERROR_USAGE, "%s: was imported: it has no scene to train on again", recorded->ledger_path);
    if (strcmp(recorded->row.status, "finished") != 0)
        return vw_fail(VW_ERROR_USAGE, "%s: the run is %s, not finished; finish it by viewworth value --resume",
                       recorded->ledger_path, recorded->row.status);
    if (!work->result->scoring.score_count)
        return vw_fail(VW_ERROR_USAGE, "%s: the run has no scores; value the scene by viewworth value",
                       recorded->ledger_path);
    return vw_attribution_read_payout(work->params->payout, &recorded->config, &work->payout_cents);
}

static enum vw_status open_run(struct work *work) {
    struct vw_worth_run *result = work->result;
    enum vw_status status = vw_recorded_open_unverified(work->params->out, &result->recorded);
    if (!status) status = vw_scoring_make(result->recorded.ledger, &result->recorded.config, &result->scoring);
    if (!status) status = check_run(work);
    if (status) return status;
    vw_ledger_chain_head(result->recorded.ledger, result->head);
    work->config = vw_config_of_retrainings(&result->recorded, &result->scoring.input);
    return VW_OK;
}

static enum vw_status draw_subsets(struct work *work) {
    const struct vw_retrainer *retrainer = &work->retrainer;
    const struct vw_worth_subsets_params params = {.photos = retrainer->train_views,
                                                   .photo_count = retrainer->train_count,
                                                   .count = count_recorded(work) + count_missing(work),
                                                   .key = work->config.seed + 1,
                                                   .first_seed = vw_first_seed_after(work->config.seed),
                                                   .epochs = work->config.epochs};
    return vw_worth_subsets_draw(&params, &work->drawn);
}

static enum vw_status open_session(struct work *work) {
    struct vw_recorded_run *recorded = &work->result->recorded;
    enum vw_status status = vw_ledger_open_to_append(recorded->ledger_path, &work->ledger);
    if (!status) status = vw_session_open_recorded(recorded, &work->params->devices, &work->session);
    if (status) return status; // the report needs the field in the end
    return vw_checksums_check_field(work->params->out, recorded->row.field_sha256);
}

// Opens the retrainer of the run's folder, or with NULL one that recalls nothing.
static enum vw_status open_retrainer(struct work *work, const char *out) {
    const struct vw_retrainer_params params = {.session = &work->session,
                                               .config = &work->config,
                                               .out = out,
                                               .together = work->params->together,
                                               .equal = VW_EQUAL_STEPS,
                                               .averaged_epochs = VW_TRUTH_EPOCHS,
                                               .interrupt = work->params->interrupt};
    enum vw_status status = vw_retrainer_open(&params, &work->retrainer);
    return status ? status : draw_subsets(work);
}

// Returns whether a kill left retrainings without their report, or without the list that is written after it.
static bool lacks_outputs(const struct work *work) {
    const char *out = work->params->out;
    return work->params->retrainings &&
           (!vw_file_exists_inside(out, "report.html") || !vw_file_exists_inside(out, VW_CHECKSUMS_FILE));
}

static enum vw_status make(struct work *work) {
    struct vw_worth_run *result = work->result;
    bool reached;
    enum vw_status status = vw_worth_run_check(work->params);
    if (!status) status = vw_out_lock_take(work->params->out, &work->lock);
    if (!status) status = open_run(work);
    if (status) return status;
    bool trains = count_missing(work) > 0;
    bool pays = work->payout_cents > 0;
    bool writes = trains || pays || lacks_outputs(work);
    status = writes ? open_session(work) : vw_recorded_warn_unverified(&result->recorded, false);
    if (!status && pays) status = vw_attribution_check_scene(result->recorded.scene);
    if (!status && trains) status = open_retrainer(work, work->params->out);
    if (!status && trains)
        status = vw_file_remove(work->params->out, VW_CHECKSUMS_FILE); // retrainings change the chain head
    if (!status && trains) status = retrain(work);
    if (!status && writes) status = write_outputs(work);
    if (!status) status = summarise(work, &reached);
    if (!count_recorded(work))
        result->prior = vw_worth_first_prior(result->scoring.scores, result->scoring.score_count);
    return status;
}

enum vw_status vw_worth_run_check(const struct vw_worth_run_params *params) {
    uint64_t cents;
    if (params->until_confidence < 0 || !(params->until_confidence < 1))
        return vw_fail(VW_ERROR_USAGE, "--until-confidence: must lie from 0 to below 1");
    return vw_attribution_read_payout(params->payout, NULL, &cents);
}

static void close_work(struct work *work) {
    vw_subsets_free(&work->drawn.subsets);
    vw_retrainer_close(&work->retrainer);
    vw_session_close_recorded(&work->session);
    vw_ledger_close(&work->ledger);
    vw_out_lock_release(&work->lock);
}

enum vw_status vw_worth_run_make(const struct vw_worth_run_params *params, struct vw_worth_run *result) {
    struct work work = {.params = params, .result = result};
    *result = (struct vw_worth_run){0};
    enum vw_status status = make(&work);
    close_work(&work);
    return status;
}

// ---- Repeating -----------------------------------------------------------------------------------------------------

// Compares an outcome with that of the ledger, which has none that is not finite.
static enum vw_status compare_outcome(const struct work *work, uint32_t place, double val_psnr) {
    const struct vw_ledger_retraining *recorded = &work->result->scoring.retrainings[place];
    double made = isfinite(val_psnr) ? val_psnr : NAN;
    if (made == recorded->val_psnr || (isnan(made) && isnan(recorded->val_psnr))) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: retraining %" PRIu32
                   ", made again, has a validation PSNR of %.9g dB, not the recorded %.9g dB: "
                   "this program did not make it on this device",
                   work->result->recorded.ledger_path, place, made, recorded->val_psnr);
}

static enum vw_status compare_all(const struct work *work, const struct vw_retrain_params *trained,
                                  const struct vw_retrain_result *results, uint32_t count) {
    const char *out = work->params->out;
    struct vw_retraining_store *store = NULL;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < count; i++) status = compare_outcome(work, i, results[i].val_psnr);
    if (status || !vw_file_exists_inside(out, VW_RETRAININGS_FILE)) return status;
    char *path = vw_path_join(out, VW_RETRAININGS_FILE);
    status = path ? vw_retraining_store_open_to_read(path, &store) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++)
        status = vw_retrainer_compare(&work->retrainer, store, &trained[i], &results[i]);
    vw_retraining_store_close(&store);
    free(path);
    return status;
}

static enum vw_status make_again(struct work *work, uint32_t count) {
    const struct vw_scoring *scoring = &work->result->scoring;
    struct vw_ledger_retraining *rows = NULL;
    struct vw_retrain_params *trained = vw_allocate(count, sizeof *trained);
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status =
        trained && results ? list_retrainings(work, scoring->retraining_count, &rows) : VW_ERROR_MEMORY;
    if (!status) describe(rows, count, trained);
    if (!status) status = vw_retrain_announced(&work->retrainer, trained, count, results);
    if (!status) status = compare_all(work, trained, results, count);
    free(rows);
    free(trained);
    free(results);
    return status;
}

static enum vw_status repeat(struct work *work, uint32_t most, uint32_t *repeated) {
    struct vw_worth_run *result = work->result;
    enum vw_status status = open_run(work);
    uint32_t count = result->scoring.retraining_count < most ? result->scoring.retraining_count : most;
    if (status || !count) return status;
    status = vw_session_open_recorded(&result->recorded, &work->params->devices, &work->session);
    if (!status) status = open_retrainer(work, NULL);
    if (!status) status = make_again(work, count);
    if (!status) *repeated = count;
    return status;
}

enum vw_status vw_worth_repeat(const struct vw_worth_run_params *params, uint32_t most, uint32_t *repeated) {
    struct vw_worth_run result = {0};
    struct work work = {.params = params, .result = &result};
    *repeated = 0;
    enum vw_status status = repeat(&work, most, repeated);
    close_work(&work);
    vw_worth_run_free(&result);
    return status;
}

void vw_worth_run_free(struct vw_worth_run *result) {
    vw_run_outputs_free(&result->outputs);
    vw_scoring_free(&result->scoring);
    free(result->scores_path);
    vw_recorded_close(&result->recorded);
}

#include "experiment/worth.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "experiment/retrain.h"
#include "experiment/retrain_run.h"
#include "report/page.h"
#include "run/out_folder.h"
#include "run/imported.h"
#include "run/out_lock.h"
#include "run/outputs/report_folder.h"
#include "run/sign.h"
#include "train/submissions.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

// With until_accuracy, whether it is reached is asked after so many retrainings; the ledger gets them in such groups.
enum { GROUP = 8 };

struct work {
    const struct vw_worth_run_params *params;
    struct vw_worth_run *result;
    struct vw_config config; // of the retrainings
    struct vw_out_lock *lock;
    struct vw_session session; // device and scene are the run's
    struct vw_retrainer retrainer;
    const char *providers[VW_WORTH_PROVIDERS_MAX + 1];
    uint32_t provider_count;                   // at most VW_WORTH_PROVIDERS_MAX + 1, which is too many
    struct vw_subsets of_photos, of_providers; // in the order of the retrainings
};

// ---- The plan: which photos, by the number of a retraining ---------------------------------------------------------

static const char *provider_of(const struct work *work, uint32_t image_id) {
    const char *provider = work->result->scoring.input.images[image_id].provider;
    return provider ? provider : "";
}

static uint32_t find_provider(const struct work *work, const char *provider) {
    uint32_t place = 0;
    while (place < work->provider_count && strcmp(work->providers[place], provider) != 0) place++;
    return place;
}

static void list_providers(struct work *work) {
    for (uint32_t i = 0; i < work->retrainer.train_count; i++) {
        const char *provider = provider_of(work, work->retrainer.train_views[i]);
        if (find_provider(work, provider) == work->provider_count && work->provider_count <= VW_WORTH_PROVIDERS_MAX)
            work->providers[work->provider_count++] = provider;
    }
}

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

// Draws the subsets that `count` retrainings need. Other runs of the scene draw others. Few providers have few subsets,
// which come again with other seeds.
static enum vw_status plan(struct work *work, uint32_t count) {
    uint32_t needed[3] = {0}, place;
    list_providers(work);
    for (uint32_t i = 0; i < count; i++) needed[vw_worth_kind_of(i, work->provider_count, &place)]++;
    struct vw_subsets_params params = {.photo_count = work->retrainer.train_count,
                                       .random_sizes = needed[VW_WORTH_PHOTOS] + 1,
                                       .seed_count = 1,
                                       .key = work->config.seed + 1};
    enum vw_status status = vw_subsets_draw(&params, &work->of_photos);
    if (!status) drop_all(&work->of_photos);
    if (!status && work->of_photos.count < needed[VW_WORTH_PHOTOS])
        status = vw_fail(VW_ERROR_INPUT,
                         "--retrainings %" PRIu32 ": %" PRIu32 " photos have only %" PRIu32
                         " subsets of 40 to 100 %%; ask for fewer retrainings",
                         count, params.photo_count, work->of_photos.count);
    params.photo_count = work->provider_count;
    params.random_sizes = needed[VW_WORTH_PROVIDERS] + 1;
    if (!status && needed[VW_WORTH_PROVIDERS]) status = vw_subsets_draw(&params, &work->of_providers);
    if (!status && needed[VW_WORTH_PROVIDERS]) drop_all(&work->of_providers);
    return status;
}

static bool has_player(const struct vw_subsets *subsets, uint32_t subset, uint32_t player) {
    for (uint32_t i = subsets->offsets[subset]; i < subsets->offsets[subset + 1]; i++)
        if (subsets->places[i] == player) return true;
    return false;
}

// Fills ids with the photos of a retraining.
static void list_photos(const struct work *work, uint32_t number, uint32_t *ids,
                        struct vw_ledger_retraining *retraining) {
    uint32_t place, count = 0;
    enum vw_worth_kind kind = vw_worth_kind_of(number, work->provider_count, &place);
    if (kind == VW_WORTH_PROVIDERS) place %= work->of_providers.count;
    for (uint32_t i = 0; i < work->retrainer.train_count; i++) {
        uint32_t id = work->retrainer.train_views[i], provider = find_provider(work, provider_of(work, id));
        if (kind == VW_WORTH_ALL || (kind == VW_WORTH_PHOTOS && has_player(&work->of_photos, place, i)) ||
            (kind == VW_WORTH_PROVIDERS && has_player(&work->of_providers, place, provider)))
            ids[count++] = id;
    }
    *retraining = (struct vw_ledger_retraining){.whole_providers = kind == VW_WORTH_PROVIDERS,
                                                .seed = vw_first_seed_after(work->config.seed, number + 1) + number,
                                                .epochs = work->config.epochs,
                                                .image_ids = ids,
                                                .image_count = count,
                                                .val_psnr = NAN};
}

static bool is_same(const struct vw_ledger_retraining *a, const struct vw_ledger_retraining *b) {
    return a->whole_providers == b->whole_providers && a->seed == b->seed && a->epochs == b->epochs &&
           a->image_count == b->image_count &&
           !memcmp(a->image_ids, b->image_ids, a->image_count * sizeof *a->image_ids);
}

// One block with rows and ids, as the ledger gives them: those of the ledger, whose outcomes are known, and the next.
static enum vw_status list_retrainings(const struct work *work, uint32_t count, struct vw_ledger_retraining **rows) {
    const struct vw_scoring *scoring = &work->result->scoring;
    size_t photos = work->retrainer.train_count;
    struct vw_ledger_retraining *made =
        vw_allocate(count, sizeof **rows + (photos + 1) * sizeof(uint32_t)); // 1: for the alignment
    if (!made) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(made + count);
    for (uint32_t i = 0; i < count; i++) {
        list_photos(work, i, ids + i * photos, &made[i]);
        if (i >= scoring->retraining_count) continue;
        made[i].val_psnr = scoring->retrainings[i].val_psnr;
        if (is_same(&made[i], &scoring->retrainings[i])) continue;
        free(made);
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: retraining %" PRIu32 " is not the one that this version makes; value the scene again",
                       work->result->recorded.ledger_path, i);
    }
    *rows = made;
    return VW_OK;
}

// ---- Retraining ----------------------------------------------------------------------------------------------------

static enum vw_status train(struct work *work, struct vw_ledger_retraining *rows, uint32_t first, uint32_t count) {
    struct vw_retrain_params *retrainings = vw_allocate(count - first, sizeof *retrainings);
    struct vw_retrain_result *results = vw_allocate(count - first, sizeof *results);
    enum vw_status status = retrainings && results ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = first; !status && i < count; i++)
        retrainings[i - first] = (struct vw_retrain_params){
            .views = rows[i].image_ids, .view_count = rows[i].image_count, .seed = rows[i].seed};
    if (!status) status = vw_retrain(&work->retrainer, retrainings, count - first, results);
    for (uint32_t i = first; !status && i < count; i++)
        rows[i].val_psnr = isfinite(results[i - first].val_psnr) ? results[i - first].val_psnr : NAN;
    free(retrainings);
    free(results);
    return status;
}

// What the ledger says next must not lie beside files of what it said before.
static enum vw_status record(struct work *work, uint32_t first) {
    struct vw_recorded_run *recorded = &work->result->recorded;
    struct vw_scoring *scoring = &work->result->scoring;
    struct vw_ledger *ledger = NULL;
    enum vw_status status = vw_run_remove_outdated_scores(recorded->out);
    if (!status) status = vw_ledger_open_to_append(recorded->ledger_path, &ledger);
    if (!status)
        status = vw_ledger_add_retrainings(ledger, scoring->retrainings + first, scoring->retraining_count - first,
                                           scoring->scores, scoring->score_count);
    if (!status) vw_ledger_chain_head(ledger, work->result->head);
    vw_ledger_close(&ledger);
    return status;
}

static enum vw_status add_group(struct work *work, uint32_t count) {
    struct vw_scoring *scoring = &work->result->scoring;
    struct vw_ledger_retraining *rows = NULL;
    uint32_t first = scoring->retraining_count;
    enum vw_status status = list_retrainings(work, count, &rows);
    if (!status) status = train(work, rows, first, count);
    if (!status) status = vw_scoring_set_retrainings(scoring, rows, count);
    else free(rows);
    return status ? status : record(work, first);
}

static enum vw_status summarise(struct work *work, bool *reached) {
    const struct vw_worth_input input = vw_scoring_worth_input(&work->result->scoring);
    enum vw_status status = vw_worth_summarise(&input, &work->result->summary);
    const struct vw_worth_summary *summary = &work->result->summary;
    *reached = summary->claim_count && work->params->until_accuracy > 0 &&
               summary->claims[0].accuracy.ci_low >= work->params->until_accuracy;
    return status;
}

// Asks for the accuracy at the same numbers of retrainings, wherever it began.
static enum vw_status retrain(struct work *work) {
    const struct vw_scoring *scoring = &work->result->scoring;
    uint32_t most = work->params->retrainings;
    bool reached = false;
    enum vw_status status = VW_OK;
    work->retrainer.planned = most - scoring->retraining_count;
    if (work->params->until_accuracy > 0) status = summarise(work, &reached);
    while (!status && !reached && scoring->retraining_count < most) {
        uint32_t next = (scoring->retraining_count / GROUP + 1) * GROUP;
        status = add_group(work, next < most ? next : most);
        if (!status && work->params->until_accuracy > 0) status = summarise(work, &reached);
    }
    return status;
}

// ---- Outputs -------------------------------------------------------------------------------------------------------

static enum vw_status write_tables(struct work *work) {
    struct vw_worth_run *result = work->result;
    const struct vw_recorded_run *recorded = &result->recorded;
    const struct vw_scoring *scoring = &result->scoring;
    uint64_t cents = 0;
    enum vw_status status =
        work->params->payout ? vw_attribution_read_payout(work->params->payout, &recorded->config, &cents) : VW_OK;
    if (!status && cents) status = vw_attribution_check_scene(recorded->scene);
    if (!status) status = vw_run_remove_outdated_scores(recorded->out);
    result->scores_path = vw_path_join(recorded->out, "scores.csv");
    if (!status && !result->scores_path) status = VW_ERROR_MEMORY;
    if (!status)
        status = vw_report_write_csv(result->scores_path, scoring->scores, scoring->score_count, scoring->input.images,
                                     scoring->input.image_count);
    if (!status) status = vw_attribution_make(recorded->scene, scoring, recorded->out, cents, &result->attribution);
    return status;
}

static enum vw_status write_outputs(struct work *work) {
    const struct vw_worth_run_params *params = work->params;
    const struct vw_report_params report = {.device = params->device, .no_thumbnails = params->no_thumbnails};
    enum vw_status status = write_tables(work);
    if (status) return status;
    work->result->report_path = vw_report_folder_finish(params->out, &report, NULL);
    return params->sign_key_path ? vw_run_sign(params->out, params->sign_key_path, NULL) : VW_OK;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static enum vw_status check_run(const struct work *work) {
    const struct vw_recorded_run *recorded = &work->result->recorded;
    if (vw_is_imported(&recorded->row))
        return vw_fail(VW_ERROR_USAGE, "%s: was imported: it has no scene to train on again", recorded->ledger_path);
    if (strcmp(recorded->row.status, "finished") != 0)
        return vw_fail(VW_ERROR_USAGE, "%s: the run is not finished but %s; finish it by viewworth value --resume",
                       recorded->ledger_path, recorded->row.status);
    if (!work->result->scoring.score_count)
        return vw_fail(VW_ERROR_USAGE, "%s: the run has no scores; value the scene by viewworth value",
                       recorded->ledger_path);
    if (work->params->until_accuracy < 0 || !(work->params->until_accuracy < 1))
        return vw_fail(VW_ERROR_USAGE, "--until-accuracy: must lie from 0 to below 1");
    return VW_OK;
}

static enum vw_status open_run(struct work *work) {
    struct vw_worth_run *result = work->result;
    enum vw_status status = vw_recorded_open(work->params->out, &result->recorded);
    if (!status) status = vw_scoring_make(result->recorded.ledger, &result->recorded.config, &result->scoring);
    if (!status) status = check_run(work);
    if (status) return status;
    vw_ledger_chain_head(result->recorded.ledger, result->head);
    work->config = vw_config_of_retrainings(&result->recorded, &result->scoring.input);
    return VW_OK;
}

static enum vw_status open_retrainer(struct work *work) {
    const struct vw_retrainer_params params = {.session = &work->session,
                                               .config = &work->config,
                                               .out = work->params->out,
                                               .together = work->params->together,
                                               .equal = VW_EQUAL_STEPS,
                                               .averaged_epochs = VW_TRUTH_EPOCHS,
                                               .interrupt = work->params->interrupt};
    enum vw_status status = vw_session_open_recorded(&work->result->recorded, work->params->device, &work->session);
    if (!status) status = vw_retrainer_open(&params, &work->retrainer);
    return status ? status : plan(work, work->params->retrainings);
}

static enum vw_status make(struct work *work) {
    struct vw_worth_run *result = work->result;
    bool reached;
    enum vw_status status = vw_out_lock_take(work->params->out, &work->lock);
    if (!status) status = open_run(work);
    if (status) return status;
    bool trains = result->scoring.retraining_count < work->params->retrainings;
    bool writes = trains || work->params->payout || work->params->sign_key_path;
    if (trains) status = open_retrainer(work);
    else if (writes) status = vw_session_open_recorded(&result->recorded, work->params->device, &work->session);
    if (!status && trains) status = retrain(work);
    if (!status && writes) status = write_outputs(work);
    if (!status) status = summarise(work, &reached);
    if (!result->scoring.retraining_count)
        result->prior = vw_worth_first_prior(result->scoring.scores, result->scoring.score_count);
    return status;
}

enum vw_status vw_worth_run_make(const struct vw_worth_run_params *params, struct vw_worth_run *result) {
    struct work work = {.params = params, .result = result};
    *result = (struct vw_worth_run){0};
    enum vw_status status = make(&work);
    vw_subsets_free(&work.of_photos);
    vw_subsets_free(&work.of_providers);
    vw_retrainer_close(&work.retrainer);
    vw_submissions_destroy(&work.session.submissions);
    vw_out_lock_release(&work.lock);
    return status;
}

void vw_worth_run_free(struct vw_worth_run *result) {
    vw_attribution_free(&result->attribution);
    vw_scoring_free(&result->scoring);
    free(result->scores_path);
    free(result->report_path);
    vw_recorded_close(&result->recorded);
}

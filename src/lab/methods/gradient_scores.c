#include "lab/methods/gradient_scores.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "lab/gradients/gradient_methods.h"
#include "lab/methods/gradient_store.h"
#include "run/recorded/recorded_run.h"

struct work {
    const struct vw_gradient_scores_params *params;
    struct vw_recorded_run recorded;
    struct vw_step_record *records; // owned
    uint64_t record_count;
    uint32_t *photos, photo_count; // owned
    struct vw_gradient_params gradients;
    struct vw_gradient_store store; // scores of all methods
};

// ---- The methods ----------------------------------------------------------------------------------------------------

static void add(double *score, double credit) {
    if (isfinite(credit)) *score += credit; // as dv_psnr, which leaves out steps that are not finite
}

// Sums over the epochs after burn-in, as dv_psnr does.
static void sum_credits(const struct work *work, const struct vw_in_run_credit *credits) {
    double *first = work->store.scores[VW_GRADIENT_IN_RUN_FIRST],
           *second = work->store.scores[VW_GRADIENT_IN_RUN_SECOND];
    for (uint32_t i = 0; i < work->photo_count; i++) {
        first[i] = second[i] = 0.0;
        for (uint64_t step = 1; step < work->record_count; step++) {
            const struct vw_step_record *record = &work->records[step];
            if (record->view != work->photos[i] || record->epoch < work->recorded.config.burn_in_epochs) continue;
            add(&first[i], credits[step - 1].first_order);
            add(&second[i], credits[step - 1].second_order);
        }
    }
}

static enum vw_status score_in_run(struct work *work) {
    struct vw_in_run_credit *credits = vw_allocate(work->record_count, sizeof *credits);
    if (!credits) return VW_ERROR_MEMORY;
    enum vw_status status = vw_in_run_credits(&work->gradients, credits);
    if (!status) sum_credits(work, credits);
    free(credits);
    return status;
}

static enum vw_status score_tracin(struct work *work) {
    struct vw_tracin_score *found = vw_allocate(work->photo_count, sizeof *found);
    if (!found) return VW_ERROR_MEMORY;
    enum vw_status status = vw_tracin_scores(&work->gradients, VW_TRACIN_CHECKPOINTS, found);
    for (uint32_t i = 0; !status && i < work->photo_count; i++) {
        work->store.scores[VW_GRADIENT_TRACIN][i] = found[i].plain;
        work->store.scores[VW_GRADIENT_TRACIN_ADAM][i] = found[i].preconditioned;
    }
    free(found);
    return status;
}

static enum vw_status score_influence(struct work *work) {
    struct vw_influence_result result;
    return vw_influence_scores(&work->gradients, &(struct vw_influence_settings){0},
                               work->store.scores[VW_GRADIENT_INFLUENCE], &result);
}

// Passes over the run. Each scores the methods `first` to `end` - 1.
static const struct {
    enum vw_gradient_method first, end;
    enum vw_status (*score)(struct work *work);
} passes[] = {
    {VW_GRADIENT_IN_RUN_FIRST, VW_GRADIENT_TRACIN, score_in_run},
    {VW_GRADIENT_TRACIN, VW_GRADIENT_INFLUENCE, score_tracin},
    {VW_GRADIENT_INFLUENCE, VW_GRADIENT_METHODS, score_influence},
};

static enum vw_status score(struct work *work, double *const scores[VW_GRADIENT_METHODS]) {
    enum vw_status status = VW_OK;
    for (size_t p = 0; p < VW_ARRAY_COUNT(passes) && !status; p++) {
        bool missing = false;
        for (uint32_t m = passes[p].first; m < passes[p].end; m++) missing |= scores[m] && !work->store.known[m];
        if (!missing) continue;
        double started_s = vw_cpu_s();
        status = passes[p].score(work);
        for (uint32_t m = passes[p].first; m < passes[p].end && !status; m++) {
            work->store.known[m] = true;
            work->store.seconds[m] = vw_cpu_s() - started_s;
        }
        if (!status) status = vw_gradient_store_save(&work->store);
    }
    return status;
}

// ---- The run --------------------------------------------------------------------------------------------------------

static enum vw_status open_run(struct work *work) {
    const struct vw_scene *scene = work->params->scene;
    char hash[VW_HASH_HEX_BYTES];
    enum vw_status status = vw_recorded_open(work->params->out, &work->recorded);
    if (!status) status = vw_recorded_check_replay(&work->recorded);
    if (status) return status;
    vw_hash_to_hex(scene->hash, hash);
    if (strcmp(hash, work->recorded.row.scene_hash) != 0)
        return vw_fail(VW_ERROR_USAGE, "%s: is a run of another scene; give its scene, or another --out",
                       work->recorded.ledger_path);
    if (work->params->epochs && work->params->epochs != work->recorded.config.epochs)
        return vw_fail(VW_ERROR_USAGE, "%s: is a run of %u epochs, not %u; give --epochs %u, or another --out",
                       work->recorded.ledger_path, work->recorded.config.epochs, work->params->epochs,
                       work->recorded.config.epochs);
    status = vw_ledger_get_steps(work->recorded.ledger, &work->records, &work->record_count);
    return status ? status : vw_scene_list_views(scene, VW_SPLIT_TRAIN, &work->photos, &work->photo_count);
}

static enum vw_status score_run(struct work *work, double *const scores[VW_GRADIENT_METHODS]) {
    const struct vw_gradient_scores_params *params = work->params;
    const struct vw_trainer_params training = {.gpu = params->gpu,
                                               .scene = params->scene,
                                               .config = &work->recorded.config,
                                               .effects = work->recorded.effects,
                                               .effect_count = work->recorded.effect_count,
                                               .validate = true};
    struct vw_recorded_steps steps = {work->recorded.ledger_path, work->records, work->record_count};
    work->gradients = (struct vw_gradient_params){.training = &training,
                                                  .replayed = vw_recorded_steps_compare,
                                                  .context = &steps,
                                                  .interrupt = params->interrupt};
    work->store = (struct vw_gradient_store){.path = params->store,
                                             .run_id = work->recorded.row.run_id,
                                             .steps = work->record_count - 1,
                                             .photos = work->photos,
                                             .photo_count = work->photo_count};
    enum vw_status status = vw_gradient_store_open(&work->store);
    return status ? status : score(work, scores);
}

enum vw_status vw_gradient_scores_make(const struct vw_gradient_scores_params *params,
                                       double *const scores[VW_GRADIENT_METHODS], double seconds[VW_GRADIENT_METHODS]) {
    struct work work = {.params = params};
    enum vw_status status = open_run(&work);
    if (!status) status = score_run(&work, scores);
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS && !status; m++) {
        if (scores[m]) memcpy(scores[m], work.store.scores[m], work.photo_count * sizeof *scores[m]);
        if (seconds) seconds[m] = work.store.seconds[m];
    }
    vw_gradient_store_free(&work.store);
    free(work.records);
    free(work.photos);
    vw_recorded_close(&work.recorded);
    return status;
}

#include "lab/probes/probe_run.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "lab/probes/probe_plan.h"
#include "run/imported/imported_run.h"
#include "run/out_folder.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"

struct work {
    const struct vw_probe_params *params;
    struct vw_probing *made;
    struct vw_recorded_run run;
    struct vw_step_record *records; // owned
    uint64_t record_count;
    struct vw_ledger_score *scores; // owned
    struct vw_probed_run probed;
    struct vw_trainer *trainer;
    struct vw_prober prober;
    struct vw_probe_plan plan;
    struct vw_probe *probes; // owned; by step and index when all are taken
    size_t capacity, count;
};

// ---- The run --------------------------------------------------------------------------------------------------------

static enum vw_status refuse(const struct work *work, const char *why) {
    return vw_fail(VW_ERROR_USAGE, "%s: %s; value the scene by viewworth value", work->run.ledger_path, why);
}

static enum vw_status open_run(struct work *work) {
    const char *device = work->params->device;
    enum vw_status status = vw_recorded_open_unverified(work->params->out, &work->run);
    if (status) return status;
    if (vw_is_imported(&work->run.row)) return refuse(work, "was imported, and its steps cannot be repeated");
    status = vw_ledger_get_steps(work->run.ledger, &work->records, &work->record_count);
    if (!status && (!work->record_count || !(work->records[0].validated || work->records[0].nonfinite)))
        return refuse(work, "needs validation after every step, and has none");
    if (!status) status = vw_ledger_verify(work->run.ledger);
    if (!status) status = vw_ledger_get_scores(work->run.ledger, &work->scores, &work->probed.score_count);
    if (!status) status = vw_ledger_get_images(work->run.ledger, &work->probed.images, &work->probed.image_count);
    if (!status) status = vw_recorded_open_scene(&work->run, device ? device : work->run.row.device);
    return status ? status : vw_recorded_check_images(&work->run);
}

static enum vw_status open_trainer(struct work *work) {
    const struct vw_trainer_params params = {.gpu = work->run.gpu,
                                             .scene = work->run.scene,
                                             .config = &work->run.config,
                                             .effects = work->run.effects,
                                             .effect_count = work->run.effect_count,
                                             .validate = true};
    enum vw_status status = vw_trainer_create(&params, &work->trainer);
    if (!status) status = vw_prober_create(work->trainer, &work->prober);
    if (status) return status;
    struct vw_photo_order *order = work->prober.parts->photo_order;
    uint32_t epochs = (uint32_t)((work->record_count - 1) / order->train_count),
             burn_in = work->run.config.burn_in_epochs, counted = epochs > burn_in ? epochs - burn_in : 0;
    work->plan = (struct vw_probe_plan){order, burn_in, epochs, work->params->same_state, work->params->lengthened};
    if (work->plan.lengthened > 0 && work->run.config.beta1 > 0)
        return refuse(work, "has momentum, with which steps belong to several photos, so that --lengthen says nothing");
    if (work->plan.states > counted)
        return vw_fail(
            VW_ERROR_USAGE,
            "--same-state %u: at most one state per epoch after --burn-in, which are %u; value the scene with "
            "more --epochs",
            work->plan.states, counted);
    return VW_OK;
}

// ---- Probing --------------------------------------------------------------------------------------------------------

// Takes the steps up to this one and compares them with the recorded ones.
static enum vw_status go_to(const struct work *work, uint64_t step) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 1, view_count = 0;
    const uint32_t *views = vw_trainer_validation_views(work->trainer, &view_count);
    enum vw_status status = VW_OK;
    vw_trainer_stop_after(work->trainer, step);
    while (!status && count) {
        status = vw_trainer_advance(work->trainer, &records, &count);
        if (!status && count) status = vw_ledger_compare(work->run.ledger, records, count, views);
    }
    return status;
}

static enum vw_status probe_state(struct work *work, uint64_t step) {
    size_t most = work->count + vw_probes_of_state_most(&work->plan);
    enum vw_status status = vw_grow((void **)&work->probes, &work->capacity, most, sizeof *work->probes);
    if (status) return status;
    struct vw_probe *own = work->probes + work->count;
    uint32_t count = vw_probes_list(&work->plan, step, own);
    if (!count) return VW_OK;
    status = go_to(work, step);
    double started_s = vw_now_s();
    for (uint32_t i = 0, some = 0; i < count && !status; i += some) {
        some = own[i].kind >= VW_PROBE_LONGER ? 1 : count - i; // a training each
        if (vw_interrupt_requested(&work->params->interrupt))
            return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; repeat the command to recompute the probes");
        status = vw_prober_take(&work->prober, step + 1, own + i, some);
    }
    work->made->seconds += vw_now_s() - started_s;
    work->count += count;
    if (!status && own->kind == VW_PROBE_SAME_STATE) {
        work->made->states++;
        work->made->same_state_steps += work->plan.order->train_count * VW_SAME_STATE_DRAWS;
    }
    return status;
}

static int compare_probes(const void *left, const void *right) {
    const struct vw_probe *a = left, *b = right;
    if (a->step != b->step) return a->step < b->step ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

static enum vw_status probe_states(struct work *work) {
    enum vw_status status = VW_OK;
    double started_s = vw_now_s();
    for (uint64_t step = 0; step < work->record_count && !status; step++) status = probe_state(work, step);
    if (!status) status = go_to(work, work->record_count - 1);
    work->made->share = work->made->seconds / (vw_now_s() - started_s);
    work->made->steps = work->record_count - 1;
    if (!status && work->count) qsort(work->probes, work->count, sizeof *work->probes, compare_probes);
    return status;
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

static void print_probes(FILE *stream, const void *context) {
    const struct vw_probed_run *run = context;
    fputs("step,probe,kind,name,val_psnr,val_psnr_pooled,val_l1\n", stream);
    for (uint32_t i = 0; i < run->probe_count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        fprintf(stream, "%" PRIu64, probe->step);
        vw_csv_print(stream, ",u,t,t,r,r,r\n", probe->index, vw_probe_kind_names[probe->kind],
                     run->images[probe->view].name, probe->val_psnr, probe->val_psnr_pooled, probe->val_l1);
    }
}

struct score_table {
    const struct vw_probed_run *run;
    struct vw_probe_score *scores;
    uint32_t count;
};

static void print_scores(FILE *stream, const void *context) {
    const struct score_table *table = context;
    fputs("name,method,value,unit,stderr,visits,resampling_stderr\n", stream);
    for (uint32_t i = 0; i < table->count; i++) {
        const struct vw_probe_score *score = &table->scores[i];
        vw_csv_print(stream, "t,t,r,t,r,u,r\n", table->run->images[score->image_id].name, score->method, score->value,
                     score->unit, score->standard_error, score->visits, score->resampling_stderr);
    }
}

static enum vw_status write_tables(const struct work *work) {
    struct vw_out_lock *lock = NULL;
    struct score_table table = {.run = &work->probed};
    struct vw_probing *made = work->made;
    made->probes_path = vw_path_join(work->params->out, "probes.csv");
    made->scores_path = vw_path_join(work->params->out, "probe_scores.csv");
    if (!made->probes_path || !made->scores_path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_probe_scores_make(&work->probed, &table.scores, &table.count);
    if (!status) status = vw_out_lock_take(work->params->out, &lock);
    if (!status) status = vw_csv_write_file(made->probes_path, print_probes, &work->probed);
    if (!status) status = vw_csv_write_file(made->scores_path, print_scores, &table);
    vw_out_lock_release(&lock);
    free(table.scores);
    return status;
}

enum vw_status vw_probe_run(const struct vw_probe_params *params, struct vw_probing *probing) {
    struct work work = {.params = params, .made = probing};
    *probing = (struct vw_probing){0};
    enum vw_status status = open_run(&work);
    if (!status) status = open_trainer(&work);
    if (!status) status = probe_states(&work);
    work.probed.records = work.records;
    work.probed.scores = work.scores;
    work.probed.probes = work.probes;
    work.probed.probe_count = (uint32_t)work.count;
    if (!status) vw_noise_floor_find(&work.probed, &probing->noise);
    if (!status) status = write_tables(&work);
    vw_prober_destroy(&work.prober);
    vw_trainer_destroy(&work.trainer);
    free(work.probes);
    free(work.records);
    free(work.scores);
    vw_recorded_close(&work.run);
    return status;
}

void vw_probing_free(struct vw_probing *probing) {
    free(probing->probes_path);
    free(probing->scores_path);
}

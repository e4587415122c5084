#include "lab/reproduction.h"
#include "lab/methods/paper_methods.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "experiment/experiment.h"
#include "lab/methods/paper_methods.h"
#include "run/out_folder.h"
#include "run/outputs/report_folder.h"
#include "run/scoring.h"
#include "viewworth/ledger.h"

enum { STOP_EPOCHS = 5, STOPS_MAX = 20 };

// The runs of all seeds as their ledgers have them.
struct seed_runs {
    uint32_t count;
    struct vw_ledger **ledgers;    // owned, and each of them
    struct vw_value_input *inputs; // also owned
};

// Finds the runs of a pair: (0,1), (0,2), ..., (1,2), ... for pair 0, 1, ...
static void find_pair(const struct vw_reproduction *reproduction, uint32_t pair, uint32_t *a, uint32_t *b) {
    uint32_t count = reproduction->params->seeds;
    for (*a = 0; pair >= count - 1 - *a; ++*a) pair -= count - 1 - *a;
    *b = *a + 1 + pair;
}

// ---- From the ledgers ----

static enum vw_status read_runs(const struct vw_experiment_params *params, bool paper_methods, struct seed_runs *runs) {
    *runs = (struct seed_runs){.count = params->seeds,
                               .ledgers = vw_allocate(params->seeds, sizeof *runs->ledgers),
                               .inputs = vw_allocate(params->seeds, sizeof *runs->inputs)};
    enum vw_status status = runs->ledgers && runs->inputs ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < runs->count && !status; i++) {
        status = vw_seed_run_open(params->out, params->config->seed + i, &runs->ledgers[i]);
        if (!status) status = vw_scoring_load(runs->ledgers[i], params->config, &runs->inputs[i]);
        runs->inputs[i].further = vw_paper_methods;
        runs->inputs[i].further_count = paper_methods ? vw_paper_method_count : 0;
    }
    return status;
}

static void free_runs(struct seed_runs *runs) {
    for (uint32_t i = 0; i < runs->count; i++) {
        if (runs->inputs) vw_scoring_unload(&runs->inputs[i]);
        if (runs->ledgers) vw_ledger_close(&runs->ledgers[i]);
    }
    free(runs->inputs);
    free(runs->ledgers);
}

static enum vw_status make_stop(const struct vw_reproduction *reproduction, const struct seed_runs *runs,
                                uint32_t epochs, struct vw_reproduction_stop *stop) {
    stop->epochs = epochs;
    enum vw_status status = vw_score_tables_make(runs->inputs, runs->count, epochs, &stop->tables);
    if (!status && epochs == reproduction->params->config->epochs) // methods are of whole trainings
        status = vw_reproduced_methods_add(&reproduction->methods, runs->inputs[0].images, &stop->tables);
    if (status) return status;
    stop->training_rays = (uint64_t)epochs * stop->tables.photo_count * reproduction->params->config->rays;
    stop->pairs = vw_allocate(stop->tables.count, sizeof *stop->pairs);
    if (!stop->pairs) return VW_ERROR_MEMORY;
    uint32_t pair_count = 0;
    for (uint32_t i = 0; i < stop->tables.count && !status; i++)
        status = vw_full_agreement_of_pairs(&stop->tables, &stop->tables.tables[i], &stop->pairs[i], &pair_count);
    return status;
}

// Returns the epochs that all runs have; some runs may have more than params->config->epochs.
static uint32_t common_epochs(const struct vw_experiment_params *params, const struct seed_runs *runs) {
    uint32_t epochs = params->config->epochs;
    for (uint32_t i = 0; i < runs->count; i++) {
        const struct vw_value_input *run = &runs->inputs[i];
        uint32_t held = run->record_count ? run->records[run->record_count - 1].epoch + 1 : 0;
        epochs = held < epochs ? held : epochs;
    }
    return epochs;
}

static enum vw_status make_stops(const struct seed_runs *runs, struct vw_reproduction *reproduction) {
    const struct vw_experiment_params *params = reproduction->params;
    uint32_t last = common_epochs(params, runs), burn_in = params->config->burn_in_epochs;
    if (last <= burn_in)
        return vw_fail(VW_ERROR_INPUT, "%s: a run ends within burn-in and has no scores; resume it", params->out);
    uint32_t stride = STOP_EPOCHS * ((last - 1) / (STOP_EPOCHS * STOPS_MAX) + 1);
    reproduction->stops = vw_allocate(STOPS_MAX, sizeof *reproduction->stops);
    if (!reproduction->stops) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    for (uint64_t epochs = stride; epochs < (uint64_t)last + stride && !status; epochs += stride) {
        uint32_t until = epochs < last ? (uint32_t)epochs : last;
        if (until > burn_in)
            status = make_stop(reproduction, runs, until, &reproduction->stops[reproduction->stop_count++]);
    }
    return status;
}

// ---- Tables ----

struct tables {
    const struct vw_reproduction *reproduction;
    const struct seed_runs *runs;
};

static void print_pair(FILE *stream, const struct vw_reproduction *reproduction, uint32_t pair) {
    uint32_t a, b;
    find_pair(reproduction, pair, &a, &b);
    uint64_t first = reproduction->params->config->seed;
    fprintf(stream, "%" PRIu64 ",%" PRIu64 ",", first + a, first + b);
}

static void print_measures(FILE *stream, const struct vw_reproduction *reproduction,
                           const struct vw_reproduction_stop *stop, uint32_t method, uint32_t pair) {
    const struct vw_full_agreement *agreement = &stop->pairs[method][pair];
    for (enum vw_agreement_measure measure = 0; measure < VW_AGREEMENT_COUNT; measure++) {
        bool clean = measure == VW_AGREEMENT_CLEAN_PEARSON || measure == VW_AGREEMENT_CLEAN_SPEARMAN;
        fprintf(stream, "%s,%u,%" PRIu64 ",", stop->tables.tables[method].method, stop->epochs, stop->training_rays);
        print_pair(stream, reproduction, pair);
        fprintf(stream, "%u,%s,", clean ? agreement->clean : agreement->photos, vw_agreement_name(measure));
        vw_csv_write_real(stream, agreement->values[measure]);
        fputc('\n', stream);
    }
}

static void print_agreement(FILE *stream, const void *context) {
    const struct vw_reproduction *reproduction = ((const struct tables *)context)->reproduction;
    fputs("method,epochs,training_rays,seed_a,seed_b,photos,measure,value\n", stream);
    for (uint32_t i = 0; i < reproduction->stop_count; i++)
        for (uint32_t method = 0; method < reproduction->stops[i].tables.count; method++)
            for (uint32_t pair = 0; pair < reproduction->pair_count; pair++)
                print_measures(stream, reproduction, &reproduction->stops[i], method, pair);
}

static void print_points(FILE *stream, const struct tables *context, const struct vw_score_tables *tables,
                         const struct vw_score_table *table, uint32_t pair) {
    uint32_t a, b;
    find_pair(context->reproduction, pair, &a, &b);
    for (uint32_t i = 0; i < tables->photo_count; i++) {
        vw_csv_write_text(stream, context->runs->inputs[0].images[tables->photos[i]].name);
        fprintf(stream, ",%s,", table->method);
        print_pair(stream, context->reproduction, pair);
        vw_csv_write_real(stream, table->values[(size_t)a * tables->photo_count + i]);
        fputc(',', stream);
        vw_csv_write_real(stream, table->values[(size_t)b * tables->photo_count + i]);
        fputs(!tables->clean ? ",\n" : tables->clean[i] ? ",0\n" : ",1\n", stream);
    }
}

static void print_scatter(FILE *stream, const void *context) {
    const struct tables *scatter = context;
    const struct vw_reproduction *reproduction = scatter->reproduction;
    const struct vw_score_tables *tables = &reproduction->stops[reproduction->stop_count - 1].tables;
    fputs("name,method,seed_a,seed_b,value_a,value_b,corrupted\n", stream);
    for (uint32_t method = 0; method < tables->count; method++)
        for (uint32_t pair = 0; pair < reproduction->pair_count; pair++)
            print_points(stream, scatter, tables, &tables->tables[method], pair);
}

static enum vw_status write_tables(const struct seed_runs *runs, struct vw_reproduction *reproduction) {
    const char *out = reproduction->params->out;
    const struct tables tables = {reproduction, runs};
    reproduction->agreement_path = vw_path_join(out, "reproduce.csv");
    reproduction->scatter_path = vw_path_join(out, "scatter.csv");
    if (!reproduction->agreement_path || !reproduction->scatter_path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_csv_write_file(reproduction->agreement_path, print_agreement, &tables);
    if (!status) status = vw_csv_write_file(reproduction->scatter_path, print_scatter, &tables);
    return status;
}

// ---- All of it ----

// Makes the runs and the methods. Retrainings of methods vary what the runs vary.
static enum vw_status make_runs(const struct vw_experiment_params *params, const struct vw_method_params *evaluated,
                                struct vw_reproduced_methods *methods) {
    struct vw_session session = {0};
    struct vw_config config = *params->config;
    struct vw_experiment_params varied = *params;
    if (config.vary != VW_VARY_ALL && config.vary != VW_VARY_ALL_VALIDATION) config.base_seed = config.seed;
    varied.config = &config;
    enum vw_status status = vw_seed_runs_make(&varied, &session);
    if (!status) status = vw_reproduced_methods_make(&varied, evaluated, &session, methods);
    vw_session_close(&session);
    return status;
}

static enum vw_status compare_runs(struct vw_reproduction *reproduction) {
    struct seed_runs runs;
    enum vw_status status = read_runs(reproduction->params, reproduction->evaluated->paper_methods, &runs);
    if (!status) status = make_stops(&runs, reproduction);
    if (!status) status = write_tables(&runs, reproduction);
    if (!status && reproduction->params->lasting.wanted)
        status =
            vw_lasting_seeds_make(reproduction->params->out, &reproduction->stops[reproduction->stop_count - 1].tables,
                                  runs.inputs, &reproduction->lasting);
    free_runs(&runs);
    return status;
}

enum vw_status vw_reproduction_make(const struct vw_experiment_params *params, const struct vw_method_params *evaluated,
                                    struct vw_reproduction *reproduction) {
    *reproduction = (struct vw_reproduction){
        .params = params, .evaluated = evaluated, .pair_count = params->seeds * (params->seeds - 1) / 2};
    struct vw_out_lock *lock = NULL;
    uint32_t seeds = evaluated->methods ? vw_method_scorers_seed_count(params) : params->seeds;
    enum vw_status status = vw_experiment_check(params, seeds, true);
    if (!status) status = vw_method_scorers_check(evaluated);
    if (!status) status = vw_out_lock_take(params->out, &lock);
    if (!status) status = make_runs(params, evaluated, &reproduction->methods);
    if (!status) status = compare_runs(reproduction);
    const struct vw_report_params report = {.device = params->devices.first, .options = params->report};
    if (!status) reproduction->report_path = vw_report_folder_finish(params->out, &report, NULL, NULL);
    vw_out_lock_release(&lock);
    return status;
}

static void free_stop(struct vw_reproduction_stop *stop) {
    for (uint32_t i = 0; stop->pairs && i < stop->tables.count; i++) free(stop->pairs[i]);
    free(stop->pairs);
    vw_score_tables_free(&stop->tables);
}

void vw_reproduction_free(struct vw_reproduction *reproduction) {
    for (uint32_t i = 0; i < reproduction->stop_count; i++) free_stop(&reproduction->stops[i]);
    free(reproduction->stops);
    vw_lasting_seeds_free(&reproduction->lasting);
    vw_reproduced_methods_free(&reproduction->methods);
    free(reproduction->agreement_path);
    free(reproduction->scatter_path);
    free(reproduction->report_path);
}

#include "experiment/reproduction.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/seed_runs.h"
#include "base/csv.h"
#include "base/memory.h"

enum { STOP_EPOCHS = 5, STOPS_MAX = 20 };

uint64_t vw_reproduction_seed(const struct vw_reproduction *reproduction, uint32_t run) {
    return reproduction->options->config.seed + run;
}

void vw_reproduction_pair(const struct vw_reproduction *reproduction, uint32_t pair, uint32_t *a, uint32_t *b) {
    for (*a = 0; pair >= reproduction->run_count - 1 - *a; ++*a) pair -= reproduction->run_count - 1 - *a;
    *b = *a + 1 + pair;
}

// ---- From the ledgers
// -------------------------------------------------------------------------------------------------

static enum vw_status read_runs(struct vw_reproduction *reproduction) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < reproduction->run_count && !status; i++) {
        status = vw_seed_run_open(reproduction->options->out, vw_reproduction_seed(reproduction, i),
                                  &reproduction->ledgers[i]);
        if (!status)
            status =
                vw_scoring_make(reproduction->ledgers[i], &reproduction->options->config, &reproduction->scorings[i]);
        reproduction->runs[i] = reproduction->scorings[i].input;
    }
    return status;
}

static enum vw_status make_stop(const struct vw_reproduction *reproduction, uint32_t epochs,
                                struct vw_reproduction_stop *stop) {
    stop->epochs = epochs;
    enum vw_status status = vw_score_tables_make(reproduction->runs, reproduction->run_count, epochs, &stop->tables);
    if (status) return status;
    stop->training_rays = (uint64_t)epochs * stop->tables.photo_count * reproduction->options->config.rays;
    stop->pairs = vw_allocate(stop->tables.count, sizeof *stop->pairs);
    if (!stop->pairs) return VW_ERROR_MEMORY;
    uint32_t pair_count = 0;
    for (uint32_t i = 0; i < stop->tables.count && !status; i++)
        status = vw_agreement_of_pairs(&stop->tables, &stop->tables.tables[i], &stop->pairs[i], &pair_count);
    return status;
}

// As far as all runs go: some may hold more than is asked for.
static uint32_t common_epochs(const struct vw_reproduction *reproduction) {
    uint32_t epochs = reproduction->options->config.epochs;
    for (uint32_t i = 0; i < reproduction->run_count; i++) {
        const struct vw_value_input *run = &reproduction->runs[i];
        uint32_t held = run->record_count ? run->records[run->record_count - 1].epoch + 1 : 0;
        epochs = held < epochs ? held : epochs;
    }
    return epochs;
}

static enum vw_status make_stops(struct vw_reproduction *reproduction) {
    uint32_t last = common_epochs(reproduction), burn_in = reproduction->options->config.burn_in_epochs;
    if (last <= burn_in)
        return vw_fail(VW_ERROR_INPUT, "%s: a run ends within burn-in, without scores", reproduction->options->out);
    uint32_t stride = STOP_EPOCHS * ((last - 1) / (STOP_EPOCHS * STOPS_MAX) + 1);
    reproduction->stops = vw_allocate(STOPS_MAX, sizeof *reproduction->stops);
    if (!reproduction->stops) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    for (uint64_t epochs = stride; epochs < (uint64_t)last + stride && !status; epochs += stride) {
        uint32_t until = epochs < last ? (uint32_t)epochs : last;
        if (until > burn_in) status = make_stop(reproduction, until, &reproduction->stops[reproduction->stop_count++]);
    }
    return status;
}

enum vw_status vw_reproduction_make(const struct vw_options *options, struct vw_reproduction *reproduction) {
    uint32_t count = options->seeds;
    *reproduction =
        (struct vw_reproduction){.options = options, .run_count = count, .pair_count = count * (count - 1) / 2};
    reproduction->ledgers = vw_allocate(count, sizeof *reproduction->ledgers);
    reproduction->scorings = vw_allocate(count, sizeof *reproduction->scorings);
    reproduction->runs = vw_allocate(count, sizeof *reproduction->runs);
    if (!reproduction->ledgers || !reproduction->scorings || !reproduction->runs) return VW_ERROR_MEMORY;
    enum vw_status status = read_runs(reproduction);
    return status ? status : make_stops(reproduction);
}

static void free_stop(struct vw_reproduction_stop *stop) {
    for (uint32_t i = 0; stop->pairs && i < stop->tables.count; i++) free(stop->pairs[i]);
    free(stop->pairs);
    vw_score_tables_free(&stop->tables);
}

void vw_reproduction_free(struct vw_reproduction *reproduction) {
    for (uint32_t i = 0; i < reproduction->stop_count; i++) free_stop(&reproduction->stops[i]);
    for (uint32_t i = 0; i < reproduction->run_count; i++) {
        if (reproduction->scorings) vw_scoring_free(&reproduction->scorings[i]);
        if (reproduction->ledgers) vw_ledger_close(&reproduction->ledgers[i]);
    }
    free(reproduction->stops);
    free(reproduction->runs);
    free(reproduction->scorings);
    free(reproduction->ledgers);
}

// ---- Tables
// -----------------------------------------------------------------------------------------------------------

static void print_pair(FILE *stream, const struct vw_reproduction *reproduction, uint32_t pair) {
    uint32_t a, b;
    vw_reproduction_pair(reproduction, pair, &a, &b);
    fprintf(stream, "%" PRIu64 ",%" PRIu64 ",", vw_reproduction_seed(reproduction, a),
            vw_reproduction_seed(reproduction, b));
}

static void print_measures(FILE *stream, const struct vw_reproduction *reproduction,
                           const struct vw_reproduction_stop *stop, uint32_t method, uint32_t pair) {
    const struct vw_agreement *agreement = &stop->pairs[method][pair];
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
    const struct vw_reproduction *reproduction = context;
    fputs("method,epochs,training_rays,seed_a,seed_b,photos,measure,value\n", stream);
    for (uint32_t i = 0; i < reproduction->stop_count; i++)
        for (uint32_t method = 0; method < reproduction->stops[i].tables.count; method++)
            for (uint32_t pair = 0; pair < reproduction->pair_count; pair++)
                print_measures(stream, reproduction, &reproduction->stops[i], method, pair);
}

static void print_points(FILE *stream, const struct vw_reproduction *reproduction, const struct vw_score_tables *tables,
                         const struct vw_score_table *table, uint32_t pair) {
    uint32_t a, b;
    vw_reproduction_pair(reproduction, pair, &a, &b);
    for (uint32_t i = 0; i < tables->photo_count; i++) {
        vw_csv_write_text(stream, reproduction->runs[0].images[tables->photos[i]].name);
        fprintf(stream, ",%s,", table->method);
        print_pair(stream, reproduction, pair);
        vw_csv_write_real(stream, table->values[(size_t)a * tables->photo_count + i]);
        fputc(',', stream);
        vw_csv_write_real(stream, table->values[(size_t)b * tables->photo_count + i]);
        fputs(!tables->clean ? ",\n" : tables->clean[i] ? ",0\n" : ",1\n", stream);
    }
}

static void print_scatter(FILE *stream, const void *context) {
    const struct vw_reproduction *reproduction = context;
    const struct vw_score_tables *tables = &reproduction->stops[reproduction->stop_count - 1].tables;
    fputs("name,method,seed_a,seed_b,value_a,value_b,corrupted\n", stream);
    for (uint32_t method = 0; method < tables->count; method++)
        for (uint32_t pair = 0; pair < reproduction->pair_count; pair++)
            print_points(stream, reproduction, tables, &tables->tables[method], pair);
}

enum vw_status vw_reproduction_write_agreement(const struct vw_reproduction *reproduction, const char *path) {
    return vw_csv_write_file(path, print_agreement, reproduction);
}

enum vw_status vw_reproduction_write_scatter(const struct vw_reproduction *reproduction, const char *path) {
    return vw_csv_write_file(path, print_scatter, reproduction);
}

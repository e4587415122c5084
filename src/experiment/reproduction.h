// What several seeds' runs say together, on its way from their ledgers to tables: what reproduce prints and writes.
#ifndef VIEWWORTH_REPRODUCTION_H
#define VIEWWORTH_REPRODUCTION_H

#include <stdint.h>

#include "cli/options.h"
#include "run/scoring.h"
#include "value/evaluation/agreement.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// The agreement of all methods after some epochs.
struct vw_reproduction_stop {
    uint32_t epochs;
    uint64_t training_rays; // that a run had used by then: epochs x photos x rays
    struct vw_score_tables tables;
    struct vw_agreement **pairs; // owned, and each of them: by table, the pairs (0,1), (0,2), ..., (1,2), ...
};

struct vw_reproduction {
    const struct vw_options *options;
    uint32_t run_count, pair_count;
    struct vw_ledger **ledgers;  // owned, and each of them
    struct vw_scoring *scorings; // likewise
    struct vw_value_input *runs; // owned; as the scorings have them, which own what they point to
    struct vw_reproduction_stop
        *stops; // owned: every 5 epochs (more where these were over 20), the last with all that are asked for
    uint32_t stop_count;
};

// Reads the runs that vw_seed_runs_make() made for options->seeds seeds, as far as all of them go and
// options->config.epochs. Free it also after a failure.
enum vw_status vw_reproduction_make(const struct vw_options *options, struct vw_reproduction *reproduction);
void vw_reproduction_free(struct vw_reproduction *reproduction);

uint64_t vw_reproduction_seed(const struct vw_reproduction *reproduction, uint32_t run);
// The runs of a pair, by its place among the pairs.
void vw_reproduction_pair(const struct vw_reproduction *reproduction, uint32_t pair, uint32_t *a, uint32_t *b);

// OUT/reproduce.csv: header method,epochs,training_rays,seed_a,seed_b,photos,measure,value; a row per method, stop,
// pair and measure (vw_agreement_name), `photos` those that it compares; an empty value where it says nothing.
enum vw_status vw_reproduction_write_agreement(const struct vw_reproduction *reproduction, const char *path);
// OUT/scatter.csv: header name,method,seed_a,seed_b,value_a,value_b,corrupted; a row per method, pair and train photo
// after all epochs; `corrupted` is 1 or 0, empty where truth is unknown.
enum vw_status vw_reproduction_write_scatter(const struct vw_reproduction *reproduction, const char *path);
// On stdout; the JSON has all methods by epochs, the last entry after all. `report_path` is NULL where there is no
// report.
void vw_reproduction_print_text(const struct vw_reproduction *reproduction, const char *agreement_path,
                                const char *scatter_path, const char *report_path);
enum vw_status vw_reproduction_print_json(const struct vw_reproduction *reproduction, const char *agreement_path,
                                          const char *scatter_path, const char *report_path);

#endif

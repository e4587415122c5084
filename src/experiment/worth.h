// Worth of a finished run's photos: retrainings on subsets of them (value/worth.h says which), from which scores are
// computed. The ledger keeps the retrainings, so that the same command resumes and more can be added.
#ifndef VIEWWORTH_EXPERIMENT_WORTH_H
#define VIEWWORTH_EXPERIMENT_WORTH_H

#include "base/hash.h"
#include "base/interrupt.h"
#include "ledger/retraining.h"
#include "run/outputs/run_outputs.h"
#include "run/recorded/recorded_run.h"
#include "run/scoring.h"
#include "run/session.h"
#include "value/evaluation/outcomes.h"
#include "value/worth.h"
#include "viewworth/report.h"

// ---- Subsets --------------------------------------------------------------------------------------------------------

// The photos and seeds of the retrainings of worth. They follow from the number of each retraining alone, so that more
// can be added later.

struct vw_worth_subsets_params {
    const uint32_t *photos; // image_ids that may be trained on, ascending; borrowed until they are freed
    uint32_t photo_count;
    uint32_t count;      // retrainings at most
    uint64_t key;        // other keys draw other subsets; not 0, which is of benchmarks
    uint64_t first_seed; // seed of the first retraining; those after it count up
    uint32_t epochs;
};

struct vw_worth_subsets {
    struct vw_worth_subsets_params params;
    struct vw_subsets subsets; // in the order of the retrainings
};

// Draws the subsets. VW_ERROR_INPUT when the photos have fewer subsets. Free its `subsets` also after a failure.
enum vw_status vw_worth_subsets_draw(const struct vw_worth_subsets_params *params, struct vw_worth_subsets *drawn);

// Lists the first `count` retrainings without outcomes: one array, owned by the caller (free), as
// vw_ledger_get_retrainings.
enum vw_status vw_worth_retrainings_list(const struct vw_worth_subsets *drawn, uint32_t count,
                                         struct vw_ledger_retraining **retrainings);
// Makes retrainings first ... count - 1 and fills their outcomes.
enum vw_status vw_worth_retrainings_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                          vw_retrain_function *retrain, void *context);

// ---- Worth ----------------------------------------------------------------------------------------------------------

struct vw_worth_run_params {
    const char *out;                 // folder of a finished run
    struct vw_device_choice devices; // the first NULL: the run's
    uint32_t retrainings;            // in all, those of the ledger included; with until_confidence the most
    double until_confidence;         // stop where the lower end of the accuracy's interval reaches it; 0: never
    uint32_t together;               // retrainings that take their steps together on each device; 0: by it
    struct vw_report_options report;
    const char *payout; // amount to divide among the photos; NULL: none
    struct vw_interrupt interrupt;
};

struct vw_worth_run {
    struct vw_recorded_run recorded;
    struct vw_scoring scoring;
    struct vw_worth_summary summary;
    const char *prior;             // the method that replaces worth where there are no retrainings; NULL: there are
    struct vw_run_outputs outputs; // empty: not written
    char *scores_path;             // owned; NULL: not written
    char head[VW_HASH_HEX_BYTES];
};

// Refuses, before the run is trained, --until-confidence out of range and a payout that is not an amount:
// VW_ERROR_USAGE or VW_ERROR_INPUT.
enum vw_status vw_worth_run_check(const struct vw_worth_run_params *params);
// Computes worth. Opens the scene if there are retrainings to make or a payout to write. Keeps retrainings in
// OUT/retrainings.db at once, and in the ledger in groups. An interrupted worth that is called again gives the same
// bits as one without interruption. Removes all derived files and writes scores.csv, the tables, the report and
// SHA256SUMS; a payout only where one is asked for. Returns VW_ERROR_USAGE for a run that is imported or not finished,
// VW_ERROR_INPUT when the photos have fewer subsets. Free the result also after a failure.
enum vw_status vw_worth_run_make(const struct vw_worth_run_params *params, struct vw_worth_run *result);
// Makes the first `most` retrainings of the ledger again, as many as it has, and compares them with it and with
// OUT/retrainings.db bit for bit. Writes nothing. VW_ERROR_MISMATCH names the first that differs.
enum vw_status vw_worth_repeat(const struct vw_worth_run_params *params, uint32_t most, uint32_t *repeated);
void vw_worth_run_free(struct vw_worth_run *result);

#endif

// The results of commands on stdout, as text or as one JSON object. A function that prints returns VW_ERROR_MEMORY, or
// VW_ERROR_IO when stdout cannot be written; one that returns JSON returns NULL when memory is short.
#ifndef VIEWWORTH_CLI_OUTPUT_RESULTS_H
#define VIEWWORTH_CLI_OUTPUT_RESULTS_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "batch/batch.h"
#include "check/table.h"
#include "experiment/comparison.h"
#include "experiment/experiment.h"
#include "experiment/sweep/sweep.h"
#include "experiment/verified_selection.h"
#include "experiment/worth.h"
#include "run/plan/plan.h"
#include "run/run.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"

struct vw_scene_info {
    const struct vw_scene *scene;
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    struct vw_estimate estimate;
    struct vw_level_prices prices[VW_PRICED_LEVELS]; // with an estimate only
    const struct vw_photo_finding *findings;         // by view
};
enum vw_status vw_scene_info_print(const struct vw_scene_info *info, bool json);

struct vw_checked {
    const struct vw_scene *scene;
    const struct vw_check *check;
    const struct vw_check_row *rows; // all photos
    uint32_t row_count;
    const char *table; // the file that has them; NULL: none
    double seconds;
    const char *copy;      // the folder of the copy; NULL: none
    uint32_t mended_count; // photos of it that stand where they were found
};
// Prints the photos that have a defect; in JSON all, with their evidence.
enum vw_status vw_check_print(const struct vw_checked *checked, bool json);

// Prints a finished run, with its scores unless it trained only.
enum vw_status vw_run_print(const struct vw_run *run, bool trained_only, bool json);
enum vw_status vw_worth_print(const struct vw_worth_run *result, double until_confidence, bool json);
enum vw_status vw_comparison_print(const struct vw_comparison *comparison, bool json);
enum vw_status vw_sweep_print(const struct vw_sweep *sweep, bool json);

// Prints lasting credit: the photos at both ends, the gate, and the growth of the gradient.
void vw_lasting_print(const struct vw_lasting_summary *summary);
json_t *vw_lasting_to_json(const struct vw_lasting_summary *summary);

// Prints providers, payout and near-duplicates of a run.
void vw_attribution_print(const struct vw_attribution *attribution);
void vw_attribution_add_json(const struct vw_attribution *attribution, json_t **root);

// Prints a table of the candidates of a verified selection, and a sentence that names the choice and its reason.
void vw_verified_selection_print(const struct vw_verified_selection *verified, uint32_t seeds);
// Returns {candidates: [{name, photos, gain_db, ci_low, ci_high}], chosen}.
json_t *vw_verified_selection_to_json(const struct vw_verified_selection *verified);

// The display of a batch on stderr. All zero but for the first.
struct vw_batch_display {
    bool quiet;
    double drawn_s, started_s; // private
};
// Shows a line for every job that ends; on a terminal also one that is updated in place. A vw_batch_progress whose
// context is a struct vw_batch_display.
void vw_batch_show(void *context, const struct vw_batch *batch, const struct vw_batch_row *ended);
void vw_batch_show_end(struct vw_batch_display *display);
// Prints the table of jobs and the files that were written.
enum vw_status vw_batch_rows_print(struct vw_batch_rows *rows, const char *out, bool json);

// ---- Photos ranked by a score ---------------------------------------------------------------------------------------

// Photos ranked by a method's scores, as text and as JSON from the same rows.

// Borrows everything.
struct vw_ranking {
    const struct vw_ledger_score *scores; // the scores of one method, best first
    uint32_t count;
    const struct vw_scene *scene;         // names the photos; NULL: `images` do
    const struct vw_ledger_image *images; // sorted by image_id
    uint32_t image_count;
    const struct vw_ledger_score *qualities; // scores, `quality` among them; NULL: quality is not shown
    uint32_t quality_count;
    uint32_t judge_count; // validation photos; 0: those of the scene, or of `images`
    double gain_db;       // gain of the training: credit in dB is shown as a share of it if it is above 0
};

enum vw_ranking_rows { VW_RANKING_ALL, VW_RANKING_HIGHEST, VW_RANKING_LOWEST };

// Prints at most three photos at each end, each only once unless it is the only one, under the two headings,
// by names without the folder that all photos share. With fewer than 4 validation photos no rank is told, and why is
// said.
void vw_ranking_print(const struct vw_ranking *ranking, const char *highest, const char *lowest);
// Returns an array of the rows, the lowest first for VW_RANKING_LOWEST; NULL when memory is short.
json_t *vw_ranking_to_json(const struct vw_ranking *ranking, enum vw_ranking_rows rows);

// ---- The answer -----------------------------------------------------------------------------------------------------

// The answer to what value was asked, in its last lines: a verdict on the reconstruction, advice on the photos, and
// the command that comes next with its cost.

struct vw_answer_photo {
    char *name;         // owned
    const char *reason; // static
    enum vw_advice_word advice;
    double score; // NaN: none
};

struct vw_answer {
    const char *out;   // borrowed
    const char *scene; // borrowed; its path, or NULL
    struct vw_reconstruction reconstruction;
    uint32_t downscale, epochs; // that were trained
    uint32_t val_count;         // validation photos
    double times_at_most;       // times as long that the most accurate training takes
    double training_s;          // time of this training; NaN: unknown
    double unvalidated_share;   // share of it that a training without validation takes
    uint32_t mask_count;        // masks of what covers photos
    bool has_report;
    struct vw_answer_photo *photos; // owned; those with advice, in any order
    size_t photo_count;
};

// Keeps what is to be said of a finished run until after it is closed, since retrainings may follow that change the
// advice; then that is taken from their results. Free the answer also after a failure. VW_ERROR_MEMORY.
enum vw_status vw_answer_begin(const struct vw_run *run, const char *out, struct vw_answer *answer);
enum vw_status vw_answer_take(struct vw_answer *answer, const struct vw_results *results);
// Prints whether the reconstruction is good enough to rank photos by.
void vw_reconstruction_print(const struct vw_reconstruction *seen);
// Sorts the photos and prints the answer.
void vw_answer_print(struct vw_answer *answer);
void vw_answer_free(struct vw_answer *answer);

#endif

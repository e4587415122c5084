// The results of a run: made once when it ends, or read once from its folder. Page, CSV, JSON and terminal show them.
#ifndef VIEWWORTH_REPORT_RESULTS_H
#define VIEWWORTH_REPORT_RESULTS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/defect.h"
#include "value/matrix.h"
#include "value/verdict.h"
#include "value/worth.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/value.h"

// An encoded image; no bytes where there is none.
struct vw_report_picture {
    void *data;
    size_t size_bytes;
};

// ---- Advice (report/advice.h) ----

enum vw_advice_mark { VW_MARK_REMOVABLE = 1, VW_MARK_IRREPLACEABLE = 2, VW_MARK_LOOK = 4, VW_MARK_LONE = 8 };
enum vw_advice_word { VW_ADVICE_KEEP, VW_ADVICE_LOOK, VW_ADVICE_UNCLEAR, VW_ADVICE_DROP, VW_ADVICE_COUNT };

struct vw_photo_advice {
    const struct vw_ledger_image *image; // borrowed
    uint8_t marks;                       // enum vw_advice_mark
    enum vw_advice_word advice;
    const char *word, *reason;              // static: of `advice`; "lone view", "exposure", ...
    const struct vw_ledger_score *score;    // borrowed: by the method that answers for a photo's value; NULL: none
    const struct vw_photo_finding *finding; // borrowed; NULL: it was not checked
    const char *description;                // borrowed, of its defect; NULL: none was found
    double train_fit, quality;              // its scores by these methods; NaN: none
};

struct vw_advice {
    const char *basis; // static: "worth_psnr" or "lasting_psnr"; NULL: neither is known, only looks are advised
    bool by_order;     // by ranks, since the basis has no zero
    bool tested;       // the basis is worth_psnr, whose accuracy is known to be above 0
    struct vw_photo_advice *photos; // owned; in the order of the images
    uint32_t count;
};

// ---- All of them ----

struct vw_results {
    const char *label; // borrowed: the folder that it lies in; unlike those of other runs
    // Rows of its ledger; borrowed.
    struct vw_ledger_run row;
    char head[VW_HASH_HEX_BYTES]; // chain head
    struct vw_value_input input;
    const struct vw_ledger_score *scores; // may be none
    uint32_t score_count;
    const struct vw_ledger_retraining *retrainings; // from which worth is computed; may be none
    uint32_t retraining_count;
    // The findings of scene and field at the end of a run, which files of its folder have for a later report. Owned but
    // for the thumbnails; NULL where unknown.
    struct vw_reconstruction reconstruction;
    struct vw_photo_finding *findings;          // by image; NULL: no photo was checked
    json_t *map;                                // where cameras and points are (run/outputs/results_files.h)
    json_t *residuals;                          // photos beside their renders and errors (run/outputs/residuals.h)
    json_t *next;                               // places for the next photos (run/next)
    const struct vw_report_picture *thumbnails; // borrowed; WebP, one per image; runs may share them
    // Computed from all that; owned.
    struct vw_matrix matrix;
    struct vw_view_evidence *views; // one per column of the matrix
    double *standard_errors;        // one per row
    struct vw_ranking_agreement agreement;
    struct vw_worth_summary worth;
    struct vw_advice advice;
};

// Computes matrix and agreement from the rows. Free the results also after a failure.
enum vw_status vw_results_measure(struct vw_ledger *ledger, struct vw_results *results);
// Returns whether there are validated steps after burn-in.
bool vw_results_have_matrix(const struct vw_results *results);
void vw_results_free(struct vw_results *results);

#endif

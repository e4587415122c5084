// Outputs for people and other programs, from ledger rows alone (no GPU).
#ifndef VIEWWORTH_REPORT_PAGE_H
#define VIEWWORTH_REPORT_PAGE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/csv.h"
#include "value/matrix.h"
#include "value/ranking_agreement.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// Writes scores.csv (RFC 4180, but lines end with LF): header
// name,provider,method,value,unit,stderr,visits,rank,ci_low,ci_high,rank_ci_low,rank_ci_high; one row per train image
// and method, methods in the given order, best first; rank 1 = most valuable, ties by name. What is unknown is an empty
// field. Reals are printed so that they read back to the same double.
enum vw_status vw_report_write_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count);
// Makes the same in memory; `path` is for messages.
enum vw_status vw_report_make_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count, struct vw_csv_text *made);
// The header of a table of several runs, with the line end, and the rows of one run, each with `before` at its start.
extern const char vw_report_csv_header[];
enum vw_status vw_report_print_csv_rows(FILE *stream, const char *path, const char *before,
                                        const struct vw_ledger_score *scores, uint32_t score_count,
                                        const struct vw_ledger_image *images, uint32_t image_count);

// ---- The page ------------------------------------------------------------------------------------------------------

// An encoded image; no bytes where there is none.
struct vw_report_picture {
    void *data;
    size_t size_bytes;
};

// One run of the page. Everything is borrowed for the call.
struct vw_report_run {
    const char *label; // the folder it lies in; unlike those of other runs
    const struct vw_ledger_run *row;
    const char *head; // chain head of its ledger
    const struct vw_ledger_image *images;
    uint32_t image_count;
    const struct vw_ledger_score *scores; // may be none
    uint32_t score_count;
    const struct vw_step_record *records; // all steps in order
    uint64_t record_count;
    uint32_t burn_in_epochs;
    const struct vw_matrix *matrix;                 // NULL or without views: none
    const struct vw_view_evidence *views;           // one per column of the matrix
    const double *standard_errors;                  // one per row of the matrix
    const struct vw_report_picture *thumbnails;     // WebP, one per image; runs may share them; NULL: none
    struct vw_lasting_pass lasting;                 // arrays borrowed; step_count 0: none
    const struct vw_ledger_retraining *retrainings; // from which worth is computed; may be none
    uint32_t retraining_count;
    const struct vw_ranking_agreement *agreement; // NULL: not measured
    const char *map_json;            // as run/outputs/scene_map.h has it: where cameras and points are; NULL: none
    const char *residuals_json;      // as run/outputs/residuals.h: photos beside their renders and errors; NULL: none
    const char *reconstruction_json; // as run/outputs/reconstruction.h; NULL: none
    const char *next_json;           // as run/next/next.h: places for the next photos; NULL: none
    const char *duplicates_json;     // duplicates.csv of its folder, as a document of kind "table"; NULL: none
};

// A result in a folder other than a run, as a JSON text that the page's script knows by its kind:
// - "table", of a CSV file: {"header": [text, ...], "rows": [[text, ...], ...]}, and its file's name says which
// ("providers.csv", ...)
// - "compare": compare.json, with the PNG files that its renders name
struct vw_report_document {
    const char *kind, *label, *file, *json;   // label: the folder, as that of its run where there is one
    const char *const *picture_files;         // as the JSON text names them
    const struct vw_report_picture *pictures; // PNG
    uint32_t picture_count;
    const char *const *thumbnail_names;         // photos that the JSON text names and no run of the page shows
    const struct vw_report_picture *thumbnails; // WebP
    uint32_t thumbnail_count;
};

// A table that another program adds to the page, and the script that shows it. All borrowed.
struct vw_report_extra {
    const char *file;           // "name.csv" in a folder of results
    const char *const *columns; // that the script needs; NULL ends them
    const char *script;         // runs after the others
};

struct vw_report_page {
    const char *version;        // version of the program
    const char *default_method; // that is shown first
    const char *methods_json;   // [{"name", "unit", "formula"}, ...], in the order of the scores
    const struct vw_report_run *runs;
    uint32_t run_count;
    const struct vw_report_document *documents;
    uint32_t document_count;
    const struct vw_report_extra *extra; // NULL: none
};

// Writes one HTML file that contains everything it shows and may load nothing (its Content-Security-Policy): names,
// providers and every other text of the page are data of its script, never markup. It is written whole or not at all.
// The same page gives the same bytes. VW_ERROR_INPUT for a score of an image that is not among them and for a text that
// is not JSON; VW_ERROR_IO, VW_ERROR_MEMORY. `sha256` receives the hash of the bytes; NULL: it is not computed.
enum vw_status vw_report_write_html(const char *path, const struct vw_report_page *page,
                                    char sha256[VW_HASH_HEX_BYTES]);

#endif

// The page of results, from ledger rows and structs alone (no GPU).
#ifndef VIEWWORTH_REPORT_PAGE_H
#define VIEWWORTH_REPORT_PAGE_H

#include <jansson.h>
#include <stdint.h>

#include "report/results.h"

// A result in a folder other than a run, as a JSON value that the page's script knows by its kind:
// - "table", of a CSV file: {"header": [text, ...], "rows": [[text, ...], ...]}, and its file's name says which
// ("providers.csv", ...)
// - "compare": compare.json, with the PNG files that its renders name
struct vw_report_document {
    const char *kind, *label, *file; // label: the folder, as that of its run where there is one
    json_t *content;
    const char *const *picture_files;         // as the content names them
    const struct vw_report_picture *pictures; // PNG
    uint32_t picture_count;
    const char *const *thumbnail_names;         // photos that the content names and no run of the page shows
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
    const struct vw_results *const *runs;
    uint32_t run_count;
    const struct vw_report_document *documents;
    uint32_t document_count;
    const struct vw_report_extra *extra; // NULL: none
};

// Writes one HTML file that contains everything it shows and may load nothing (its Content-Security-Policy): names,
// providers and every other text of the page are data of its script, never markup. It is written whole or not at all.
// The same page gives the same bytes. VW_ERROR_INPUT for a score of an image that is not among them and for a text that
// is not JSON; VW_ERROR_IO, VW_ERROR_MEMORY.
enum vw_status vw_report_write_html(const char *path, const struct vw_report_page *page);

// ---- The inside of the page -----------------------------------------------------------------------------------------

// The inside of the page: its data, and its files, which the build put into the program (src/report/embed.cmake).

// Returns {version, default_method, methods, thumbnail_sets: [[data URI or null by image]], runs: [{label, run, config,
// scene_options, effects, images, thumbnails: place of its set or null, scores, steps, matrix}], documents: [{kind,
// label, file, content, pictures}]}. Rows of images, scores and steps lie in columns: an array per field. The caller
// drops the reference.
enum vw_status vw_html_data_make(const struct vw_report_page *page, json_t **data);

// report.html: {{policy}}, {{style}}, {{chart}}, {{widgets}}, {{script}}, {{tradeoff}}, {{photos}},
// {{scores}}, {{tables}}, {{extra}} and {{data}} stand for the rest
extern const char vw_html_template[];
extern const char vw_html_style[];    // report.css
extern const char vw_html_chart[];    // Chart.js
extern const char vw_html_widgets[];  // report_widgets.js
extern const char vw_html_script[];   // report.js
extern const char vw_html_tradeoff[]; // report_tradeoff.js
extern const char vw_html_photos[];   // report_photos.js
extern const char vw_html_scores[];   // report_scores.js
extern const char vw_html_tables[];   // report_tables.js
extern const char vw_html_next[];     // report_next.js, a part of {{extra}} where there are places for the next photos

#endif

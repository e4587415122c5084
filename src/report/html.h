// The inside of the page: its data, and its files, which the build put into the program (src/report/embed.cmake).
#ifndef VIEWWORTH_REPORT_HTML_H
#define VIEWWORTH_REPORT_HTML_H

#include <jansson.h>

#include "report/page.h"

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

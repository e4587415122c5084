// The data of the page as one JSON value.
#ifndef VIEWWORTH_REPORT_HTML_DATA_H
#define VIEWWORTH_REPORT_HTML_DATA_H

#include <jansson.h>

#include "report/page.h"

// Returns {version, default_method, methods, thumbnail_sets: [[data URI or null by image]], runs: [{label, run, config,
// scene_options, effects, images, thumbnails: place of its set or null, scores, steps, matrix}], documents: [{kind,
// label, file, content, pictures}]}. Rows of images, scores and steps lie in columns: an array per field. The caller
// drops the reference.
enum vw_status vw_html_data_make(const struct vw_report_page *page, json_t **data);

#endif

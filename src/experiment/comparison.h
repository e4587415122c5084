// Comparison: which list of photos makes the better reconstruction. Every list is trained on with the same seeds and
// measured on whole validation and test photos.
#ifndef VIEWWORTH_EXPERIMENT_COMPARISON_H
#define VIEWWORTH_EXPERIMENT_COMPARISON_H

#include "experiment/comparison_data.h"

// Makes the comparison, or resumes it. Writes to OUT: retrainings.db, compare.json (vw_comparison_to_json),
// report.html, renders/, and
// - compare.csv: a row per list and seed
// - pairs.csv: a row per pair and measure
// - disagreements.csv: a row per photo that one list has and another one has not, random lists left out
// VW_ERROR_USAGE and VW_ERROR_INPUT name the list or option that is wrong; nothing is written then. Free the result
// also after a failure.
enum vw_status vw_comparison_make(const struct vw_comparison_params *params, struct vw_comparison *comparison);
void vw_comparison_free(struct vw_comparison *comparison);

#endif

// The files of a comparison in OUT.
#ifndef VIEWWORTH_EXPERIMENT_COMPARISON_FILES_H
#define VIEWWORTH_EXPERIMENT_COMPARISON_FILES_H

#include <jansson.h>

#include "experiment/comparison_data.h"

// Makes the content of compare.json; NULL when memory is short.
json_t *vw_comparison_to_json(const struct vw_comparison *comparison);
// Writes compare.csv, pairs.csv and disagreements.csv.
enum vw_status vw_comparison_write_csv(const struct vw_comparison *comparison);

#endif

// Scores from gradients as a table, so that they are computed once: header
// run_id,steps,method,image_id,score,cpu_seconds, a row per method and photo. An empty score: the method has found
// none.
#ifndef VIEWWORTH_LAB_METHODS_GRADIENT_STORE_H
#define VIEWWORTH_LAB_METHODS_GRADIENT_STORE_H

#include <stdint.h>

#include "lab/methods/gradient_list.h"
#include "viewworth/status.h"

struct vw_gradient_store {
    const char *path, *run_id; // borrowed
    uint64_t steps;            // steps of the run, which may be extended
    const uint32_t *photos;    // borrowed; scene indices, ascending
    uint32_t photo_count;
    bool known[VW_GRADIENT_METHODS];
    double *scores[VW_GRADIENT_METHODS]; // owned; by photo
    double seconds[VW_GRADIENT_METHODS]; // CPU time of the pass
};

// Reads the scores that are known of that run and these photos from the file at `path`, if there is one (NULL: none).
// Scores of another run are ignored; a damaged file is ignored with a warning. Free the store also after a failure.
enum vw_status vw_gradient_store_open(struct vw_gradient_store *store);
// Writes what is known, completely or not at all. Nothing without a path.
enum vw_status vw_gradient_store_save(const struct vw_gradient_store *store);
void vw_gradient_store_free(struct vw_gradient_store *store);

#endif

// The measurements of a sweep in OUT/measurements.json, so that an interrupted sweep resumes: what is expensive to
// measure again, or would not come out the same to the last digit (times). The file is an object of configuration_ids
// with their quantities, and a checksum of it; a damaged file is told, and measured again.
#ifndef VIEWWORTH_EXPERIMENT_SWEEP_STORE_H
#define VIEWWORTH_EXPERIMENT_SWEEP_STORE_H

#include <jansson.h>
#include <stdbool.h>

#include "viewworth/status.h"

struct vw_sweep_store {
    char *path;     // owned
    json_t *values; // owned; {configuration_id: {quantity: value}}; NULL when memory was short
};

// Reads the file in OUT, if there is one. Close the store also after a failure.
enum vw_status vw_sweep_store_open(const char *out, struct vw_sweep_store *store);
void vw_sweep_store_close(struct vw_sweep_store *store);
// Finds a quantity of a configuration; NaN for one that was measured without a value.
bool vw_sweep_store_find(const struct vw_sweep_store *store, const char *configuration_id, const char *quantity,
                         double *value);
// Sets a quantity, which vw_sweep_store_save() writes.
void vw_sweep_store_set(struct vw_sweep_store *store, const char *configuration_id, const char *quantity, double value);
enum vw_status vw_sweep_store_save(const struct vw_sweep_store *store);

#endif

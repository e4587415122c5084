// The per-step log of any other trainer that takes one photo per step and validates after every step, read as if the
// steps were ours.
//
// A CSV file (see csv.h) whose header names at least the columns step, epoch, photo, psnr and l1, in any order; further
// columns are passed over. One row per step:
// - step   whole number; the first row has 0 or 1, every other one the number after that of the row before
// - epoch  whole number that never falls; epochs count from the first one that a photo is trained in, are fewer than
// 10^9, and are passes
//          over the photos: scoring holds a number per photo and epoch, so that their product may not exceed 2^26
// - photo  the name of the photo trained on; the first row may have none: it is the state before training, as is step 0
// whatever its photo
// - psnr   dB, validation after the step; finite values beyond 10^4, here and in l1, are refused: one would drown all
// scores
// - l1     mean absolute error of the same validation, not negative
// A step whose psnr and l1 are both empty was not validated; one of which either is nan or inf is flagged as not
// finite. Neither has a delta: the next one is taken from the last step that has values.
#ifndef VIEWWORTH_STEP_LOG_H
#define VIEWWORTH_STEP_LOG_H

#include <stdint.h>

#include "base/csv.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

struct vw_step_log {
    struct vw_csv csv;  // the file, which the names point into
    uint8_t sha256[32]; // of the file
    struct vw_step_record *
        records; // owned; from step 0 on (added, without values, where the log begins with 1); no pooled PSNR, no views
    uint32_t record_count;
    struct vw_ledger_image *images; // owned; the photos, all in split train, by name; image_id is the place here
    uint32_t image_count;
    uint32_t epochs; // number of the last one, and one
};

// VW_ERROR_INPUT names file, line and field of whatever is not as above. Clear it also after a failure.
enum vw_status vw_step_log_read(const char *path, struct vw_step_log *log);
void vw_step_log_clear(struct vw_step_log *log);

#endif

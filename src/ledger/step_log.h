// The step log of another trainer, read as if its steps were ours. The trainer takes one photo per step and validates
// after every step, or every so many.
//
// A CSV file (see csv.h). Its header has the columns step, epoch, photo, psnr and l1, in any order; other columns are
// ignored. One row per step:
// - step   whole number; 0 or 1 in the first row, then one more in each row
// - epoch  whole number that never falls. Epochs count from the first one with a photo, and are fewer than 10^9. An
// epoch
//          is a pass over the photos: scoring stores a number per photo and epoch, so photos times epochs is at most
//          2^26
// - photo  name of the photo trained on; may be empty in the first row, which then is the state before training. Step 0
// is
//          that state in any case
// - psnr   validation PSNR after the step, dB. Finite values beyond 10^4, also in l1, are refused: one of them would
//          dominate all scores
// - l1     mean absolute error of the same validation, at least 0
// A step whose psnr and l1 are both empty was not validated. Between two validated steps it gets values on the straight
// line between theirs, so that each step gets an equal share of the change; before the first and after the last one it
// stays without. A step with nan or inf is flagged as non-finite. A step without values has no delta: the next delta
// starts from the last step with values.
#ifndef VIEWWORTH_LEDGER_STEP_LOG_H
#define VIEWWORTH_LEDGER_STEP_LOG_H

#include <stdint.h>

#include "base/csv.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

struct vw_step_log {
    struct vw_csv csv;             // the file; names point into it
    uint8_t sha256[VW_HASH_BYTES]; // SHA-256 of the file
    struct vw_step_record *
        records; // owned; from step 0 on (added, without values, where the log begins with 1); no pooled PSNR, no views
    uint32_t record_count;
    struct vw_ledger_image *images; // owned; the photos, all in split train, by name; image_id is the place here
    uint32_t image_count;
    uint32_t epochs;          // number of the last one, and one
    uint64_t shared_count;    // steps that got a share of a change
    uint64_t validated_every; // steps between two validations, where steps share a change: the most; 0: none do
};

// Reads a step log. VW_ERROR_INPUT names the file, line and field that are wrong. Clear the log also after a failure.
enum vw_status vw_step_log_read(const char *path, struct vw_step_log *log);
void vw_step_log_clear(struct vw_step_log *log);

#endif

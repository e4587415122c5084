// The credits of a backward pass that was stopped, as a file in OUT: a line that names format, run and settings, the
// credits of the last steps of the run, in order, also those of validation photos, and a SHA-256 of everything
// before it.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_FILE_H
#define VIEWWORTH_RUN_LASTING_LASTING_FILE_H

#include <stdint.h>

#include "run/out_files.h"
#include "train/files/hashed_file.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_lasting_file {
    const char *out;    // its folder
    const char *run_id; // 64 hex digits
    uint32_t rays;      // rays per step
    uint64_t steps;     // steps of the run
    uint32_t views;     // validation photos with credits of their own
    const struct vw_file_binding *binding;
};

// Rows, one per step of the run, in order.
struct vw_lasting_rows {
    struct vw_lasting_step *steps;
    double *view_psnr; // as of vw_lasting_pass
};

// Writes the credits of the steps from `first_step` on, beside the place of the file, and moves them there.
enum vw_status vw_lasting_file_save(const struct vw_lasting_file *file, const struct vw_lasting_rows *credits,
                                    uint64_t first_step);
// Reads them into their places, and the first of their steps. VW_ERROR_INPUT when the file is missing, damaged, of
// another pass, or not kept by the binding: `credits` is then untouched.
enum vw_status vw_lasting_file_load(const struct vw_lasting_file *file, const struct vw_lasting_rows *credits,
                                    uint64_t *first_step);

#endif

// The files in OUT that a later command lists or removes. Others stay: checkpoints, retrainings.db, pictures, tables of
// comparisons, the states of jobs.
#ifndef VIEWWORTH_RUN_OUT_FILES_H
#define VIEWWORTH_RUN_OUT_FILES_H

#include <stdbool.h>
#include <stddef.h>

#define VW_LEDGER_FILE "ledger.db"
#define VW_FIELD_FILE "field.vwf"
#define VW_SPLATS_FILE "field.ply"
#define VW_ADVICE_FILE "advice.csv"
#define VW_REPORT_FILE "report.html"
#define VW_RETRAININGS_FILE "retrainings.db"
#define VW_LASTING_PASS_FILE "lasting.vws" // where a stopped backward pass is: train/adjoint/lasting.h
#define VW_SCENE_MAP_FILE "map.json"
#define VW_RESIDUALS_FILE "residuals.json"
#define VW_SPLITS_FILE "splits.json"
#define VW_RECONSTRUCTION_FILE "reconstruction.json"
#define VW_NEXT_FILE "next.json"
#define VW_CHECKSUMS_FILE "SHA256SUMS"
#define VW_OUT_LOCK_FILE ".viewworth.lock"

enum vw_out_outdated { VW_OUT_STAYS, VW_OUT_BY_SCORES, VW_OUT_BY_STEPS }; // by further scores, or only by further steps

struct vw_out_file {
    const char *name;
    enum vw_out_outdated outdated; // removed before
};

// Results of a run, which SHA256SUMS lists, come first, in the order of their names.
enum { VW_RESULT_FILE_COUNT = 15 };
extern const struct vw_out_file vw_out_files[];
extern const size_t vw_out_file_count;
bool vw_out_is_result(const char *name);

#endif

// The folder OUT: the files that a later command lists or removes, checks before any work that results can be written,
// and its lock. Others stay in it: checkpoints, retrainings.db, pictures, tables of comparisons, the states of jobs.
#ifndef VIEWWORTH_RUN_OUT_FOLDER_H
#define VIEWWORTH_RUN_OUT_FOLDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

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
#define VW_OUT_MASKS "masks" // folder, which --masks of other runs may name; SHA256SUMS does not list its files
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

// Checks where --out is or would be made; the folder itself is not created. VW_ERROR_USAGE when --out is a file, and
// when this user may not write at that place.
enum vw_status vw_out_check(const char *out);
// Refuses the name of a file to write, as an option gives it, unless it ends in .ply, or in .json if `json`, is not
// there yet, and is not a name of vw_out_files in `out`. NULL is fine.
enum vw_status vw_out_check_target(const char *option, const char *path, const char *out, bool json);
// Removes what further steps make out of date: all derived files, the field, and the state of a stopped lasting pass.
enum vw_status vw_run_remove_outdated(const char *out, bool pays);
// Removes all derived files, whoever made them: SHA256SUMS, tables, report and what the report needs. Unless the caller
// `pays`, a removed payout is told, and how to ask for one again.
enum vw_status vw_run_remove_derived(const char *out, bool pays);

// The lock of a folder: one writer per folder of results. Whoever writes into an OUT holds it from before the first
// write until the end; readers take none.
struct vw_out_lock;

// Creates OUT if it is not there, locks it, and removes what a killed writer has left half-written. VW_ERROR_USAGE, at
// once, when a link lies below OUT, a folder has the name of a result, or another process or another run of this one
// writes there. The lock is one of the kernel's on OUT/.viewworth.lock, so that it ends with the process, however that
// ends; on a file system without locks there is a warning instead.
enum vw_status vw_out_lock_take(const char *out, struct vw_out_lock **lock);
// Locks the one of the folders that the file `to` lies in, if it lies in one of them. `*lock` is NULL otherwise.
enum vw_status vw_out_lock_take_for(const char *to, const char *const *folders, uint32_t folder_count,
                                    struct vw_out_lock **lock);
// Returns the folder that is locked, as it was named.
const char *vw_out_lock_folder(const struct vw_out_lock *lock);
// Leaves the lock file. Removes OUT if the lock created it and nothing else was written to it.
void vw_out_lock_release(struct vw_out_lock **lock);

#endif

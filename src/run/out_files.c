#include "run/out_files.h"

#include "base/memory.h"

const struct vw_out_file vw_out_files[] = {
    // Results of a run, in the order of SHA256SUMS.
    {VW_ADVICE_FILE, true, VW_OUT_BY_SCORES},
    {"duplicates.csv", true, VW_OUT_BY_SCORES},
    {VW_SPLATS_FILE, true, VW_OUT_BY_SCORES},
    {VW_FIELD_FILE, true, VW_OUT_BY_STEPS},
    {VW_LEDGER_FILE, true, VW_OUT_STAYS},
    {VW_SCENE_MAP_FILE, true, VW_OUT_BY_SCORES},
    {"matrix.csv", true, VW_OUT_BY_SCORES},
    {"payout.csv", true, VW_OUT_BY_SCORES},
    {"payout_photos.csv", true, VW_OUT_BY_SCORES},
    {"providers.csv", true, VW_OUT_BY_SCORES},
    {VW_RECONSTRUCTION_FILE, true, VW_OUT_BY_SCORES},
    {VW_REPORT_FILE, true, VW_OUT_BY_SCORES},
    {VW_RESIDUALS_FILE, true, VW_OUT_BY_SCORES},
    {"scores.csv", true, VW_OUT_BY_SCORES},
    {VW_SPLITS_FILE, true, VW_OUT_STAYS}, // --splits may name it, even to resume the same run
    // The list of these results: a command replaces lines, and verify compares all of it.
    {VW_CHECKSUMS_FILE, false, VW_OUT_BY_SCORES},
    // States that later commands go on from.
    {"checkpoint_0.vwc", false, VW_OUT_STAYS},
    {"checkpoint_1.vwc", false, VW_OUT_STAYS},
    {VW_LASTING_PASS_FILE, false, VW_OUT_BY_STEPS},
    {VW_RETRAININGS_FILE, false, VW_OUT_STAYS},
    // Lists of the folds of --kfold, in fold-*/.
    {"train.txt", false, VW_OUT_STAYS},
    {"val.txt", false, VW_OUT_STAYS},
    {"test.txt", false, VW_OUT_STAYS},
    // Times and PSNR of a trade-off: they are read back, but decide nothing about a run.
    {"measurements.json", false, VW_OUT_STAYS},
    // States of jobs: they decide whether a job is started. The merge verifies its ledger, and prints the status there.
    {"*.json", false, VW_OUT_STAYS}, // JOB.json
    {"*.log", false, VW_OUT_STAYS},  // JOB.log
    {"slurm-*.log", false, VW_OUT_STAYS},
    // Tables that reports show beside the run.
    {"compare.json", false, VW_OUT_STAYS},
    {"tradeoff.csv", false, VW_OUT_STAYS},
    {"summary.csv", false, VW_OUT_STAYS},
    {"benchmark.csv", false, VW_OUT_STAYS},
    // Places for the next photos, by the field, that the report shows.
    {VW_NEXT_FILE, false, VW_OUT_BY_STEPS},
    // Pictures of a comparison, in renders/, of render, also in frames/, and of next.
    {"*.png", false, VW_OUT_STAYS},
    // Files that are only written.
    {"merged.db", false, VW_OUT_STAYS},
    {"slurm_job.sh", false, VW_OUT_STAYS},
    {"compare.csv", false, VW_OUT_STAYS},
    {"pairs.csv", false, VW_OUT_STAYS},
    {"disagreements.csv", false, VW_OUT_STAYS},
    {"dv_psnr.csv", false, VW_OUT_STAYS},     // made by --kfold
    {"verdicts-*.json", false, VW_OUT_STAYS}, // in the user's cache, not in OUT
    {VW_OUT_LOCK_FILE, false, VW_OUT_STAYS},
};
const size_t vw_out_file_count = VW_ARRAY_COUNT(vw_out_files);

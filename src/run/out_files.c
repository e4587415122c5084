#include "run/out_files.h"

#include <string.h>

#include "base/memory.h"

const struct vw_out_file vw_out_files[] = {
    // Results of a run, in the order of SHA256SUMS.
    {VW_ADVICE_FILE, VW_OUT_BY_SCORES},
    {"duplicates.csv", VW_OUT_BY_SCORES},
    {VW_SPLATS_FILE, VW_OUT_BY_SCORES},
    {VW_FIELD_FILE, VW_OUT_BY_STEPS},
    {VW_LEDGER_FILE, VW_OUT_STAYS},
    {VW_SCENE_MAP_FILE, VW_OUT_BY_SCORES},
    {"matrix.csv", VW_OUT_BY_SCORES},
    {"payout.csv", VW_OUT_BY_SCORES},
    {"payout_photos.csv", VW_OUT_BY_SCORES},
    {"providers.csv", VW_OUT_BY_SCORES},
    {VW_RECONSTRUCTION_FILE, VW_OUT_BY_SCORES},
    {VW_REPORT_FILE, VW_OUT_BY_SCORES},
    {VW_RESIDUALS_FILE, VW_OUT_BY_SCORES},
    {"scores.csv", VW_OUT_BY_SCORES},
    {VW_SPLITS_FILE, VW_OUT_STAYS}, // --splits may name it, even to resume the same run
    // The list of these results: a command replaces lines, and verify compares all of it.
    {VW_CHECKSUMS_FILE, VW_OUT_BY_SCORES},
    // States that later commands go on from.
    {"checkpoint_0.vwc", VW_OUT_STAYS},
    {"checkpoint_1.vwc", VW_OUT_STAYS},
    {VW_LASTING_PASS_FILE, VW_OUT_BY_STEPS},
    {VW_RETRAININGS_FILE, VW_OUT_STAYS},
    // Times and PSNR of a trade-off: they are read back, but decide nothing about a run.
    {"measurements.json", VW_OUT_STAYS},
    // States of jobs: they decide whether a job is started. The merge verifies its ledger, and prints the status there.
    {"*.json", VW_OUT_STAYS}, // JOB.json
    {"*.log", VW_OUT_STAYS},  // JOB.log
    {"slurm-*.log", VW_OUT_STAYS},
    // Tables that reports show beside the run.
    {"compare.json", VW_OUT_STAYS},
    {"tradeoff.csv", VW_OUT_STAYS},
    {"summary.csv", VW_OUT_STAYS},
    {"benchmark.csv", VW_OUT_STAYS},
    // Places for the next photos, by the field, that the report shows.
    {VW_NEXT_FILE, VW_OUT_BY_STEPS},
    // Pictures of a comparison, in renders/, of render, also in frames/, and of next.
    {"*.png", VW_OUT_STAYS},
    // Files that are only written.
    {"merged.db", VW_OUT_STAYS},
    {"slurm_job.sh", VW_OUT_STAYS},
    {"compare.csv", VW_OUT_STAYS},
    {"pairs.csv", VW_OUT_STAYS},
    {"disagreements.csv", VW_OUT_STAYS},
    {VW_OUT_LOCK_FILE, VW_OUT_STAYS},
};
const size_t vw_out_file_count = VW_ARRAY_COUNT(vw_out_files);

bool vw_out_is_result(const char *name) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (!strcmp(vw_out_files[i].name, name)) return true;
    return false;
}

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
    // Not results: the list of them, a stopped backward pass, and places for the next photos by the field.
    {VW_CHECKSUMS_FILE, VW_OUT_BY_SCORES},
    {VW_LASTING_PASS_FILE, VW_OUT_BY_STEPS},
    {VW_NEXT_FILE, VW_OUT_BY_STEPS},
};
const size_t vw_out_file_count = VW_ARRAY_COUNT(vw_out_files);

bool vw_out_is_result(const char *name) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (!strcmp(vw_out_files[i].name, name)) return true;
    return false;
}

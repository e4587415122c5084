#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "cli/output/print.h"
#include "cli/output/results.h"

enum { FEW_PHOTOS = 4 }; // validation photos, below which intervals are too wide to prove much

struct row {
    const char *name, *same_as;
    uint32_t photo_count;
    struct vw_gain gain;
    char interval[VW_CELL_BYTES];
};

static const struct vw_column columns[] = {
    {VW_CELL("name", struct row, TEXT, name), .title = "list"},
    {VW_CELL("photos", struct row, COUNT, photo_count), .title = "photos"},
    {VW_CELL("gain_db", struct row, REAL_OR_NULL, gain.gain_db), .title = "gain, dB", .digits = 2, .has_sign = true},
    {VW_CELL("ci_low", struct row, REAL_OR_NULL, gain.ci_low)},
    {VW_CELL("ci_high", struct row, REAL_OR_NULL, gain.ci_high)},
    {VW_CELL("interval", struct row, CHARS, interval), .left_out = VW_NOT_IN_JSON, .title = "interval"},
    {VW_CELL("same_as", struct row, TEXT_OR_NULL, same_as), .title = "the same"},
};

static struct vw_rows rows_of(const struct vw_verified_selection *verified, struct row rows[VW_VERIFIED_LISTS_MAX]) {
    for (uint32_t c = 0; c < verified->lists.count; c++) {
        const struct vw_gain *gain = &verified->gains[c];
        bool same = gain->ci_low == 0 && gain->ci_high == 0;
        rows[c] = (struct row){.name = verified->lists.of[c].name,
                               .same_as = verified->lists.of[c].same_as,
                               .photo_count = verified->lists.of[c].selections[VW_HALF_BOTH].count,
                               .gain = *gain};
        const char *words = !c ? "the others are compared with it" : same ? "all photos by the scores of a half" : NULL;
        if (words || isnan(gain->ci_low)) snprintf(rows[c].interval, VW_CELL_BYTES, "%s", words ? words : "unknown");
        else snprintf(rows[c].interval, VW_CELL_BYTES, "%+.2f to %+.2f", gain->ci_low, gain->ci_high);
    }
    return VW_ROWS(columns, rows, verified->lists.count);
}

json_t *vw_verified_selection_to_json(const struct vw_verified_selection *verified) {
    struct row rows[VW_VERIFIED_LISTS_MAX];
    const struct vw_rows lists = rows_of(verified, rows);
    return json_pack("{s:o, s:s}", "candidates", vw_rows_to_json(&lists), "chosen",
                     verified->lists.of[verified->chosen].name);
}

static void print_choice(const struct vw_verified_selection *verified) {
    const struct vw_verified_list *chosen = &verified->lists.of[verified->chosen];
    uint32_t judges = verified->half_sizes[VW_HALF_A] + verified->half_sizes[VW_HALF_B];
    if (verified->lists.count == 1)
        vw_print("chosen   all photos: every rule keeps them all, so nothing was trained\n");
    else if (verified->chosen)
        vw_print("chosen   %s: of the lists whose interval lies above 0 dB it gains the most\n", chosen->name);
    else vw_print("chosen   all photos: no list is better beyond noise, because no interval lies above 0 dB\n");
    if (judges < FEW_PHOTOS && verified->lists.count > 1)
        vw_print("         only %u validation photos judge, which proves little; name more with --val\n", judges);
}

void vw_verified_selection_print(const struct vw_verified_selection *verified, uint32_t seeds) {
    if (verified->lists.count > 1) {
        vw_print("verified by trainings at equal steps with seeds %" PRIu64 " to %" PRIu64
                 ": %u and %u validation photos\nselect for each other; gain in PSNR over all photos, 98 %% interval\n",
                 verified->first_seed, verified->first_seed + seeds - 1, verified->half_sizes[VW_HALF_A],
                 verified->half_sizes[VW_HALF_B]);
        vw_print("thinned: every n-th photo by name is left out; random: drawn\n\n");
        struct row rows[VW_VERIFIED_LISTS_MAX];
        const struct vw_rows lists = rows_of(verified, rows);
        vw_print_rows(&lists);
        vw_print("\n");
    }
    print_choice(verified);
}

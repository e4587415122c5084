#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "cli/output/print.h"
#include "cli/output/results.h"

enum { FEW_PHOTOS = 4 }; // validation photos, below which intervals are too wide to prove much

// ---- JSON ----

static json_t *candidate_to_json(const struct vw_verified_selection *verified, uint32_t place) {
    const struct vw_candidate *candidate = &verified->candidates.list[place];
    const struct vw_gain *gain = &verified->gains[place];
    return json_pack("{s:s, s:I, s:o, s:o, s:o, s:s*}", "name", candidate->name, "photos",
                     (json_int_t)candidate->selections[VW_HALF_BOTH].count, "gain_db", vw_json_real(gain->gain_db),
                     "ci_low", vw_json_real(gain->ci_low), "ci_high", vw_json_real(gain->ci_high), "same_as",
                     candidate->same_as);
}

json_t *vw_verified_selection_to_json(const struct vw_verified_selection *verified) {
    json_t *candidates = json_array();
    for (uint32_t c = 0; c < verified->candidates.count; c++)
        vw_json_append(&candidates, candidate_to_json(verified, c));
    return json_pack("{s:o, s:s}", "candidates", candidates, "chosen",
                     verified->candidates.list[verified->chosen].name);
}

// ---- Text ----

static void print_candidate(const struct vw_verified_selection *verified, uint32_t place) {
    const struct vw_candidate *candidate = &verified->candidates.list[place];
    const struct vw_gain *gain = &verified->gains[place];
    vw_print("%-18s %6u", candidate->name, candidate->selections[VW_HALF_BOTH].count);
    if (!place) vw_print("   the others are compared with it");
    else if (gain->ci_low == 0 && gain->ci_high == 0) vw_print("   %+8.2f  all photos by the scores of a half", 0.0);
    else if (isnan(gain->ci_low)) vw_print("   %+8.2f  unknown", gain->gain_db);
    else vw_print("   %+8.2f  %+.2f to %+.2f", gain->gain_db, gain->ci_low, gain->ci_high);
    vw_print("\n");
    if (candidate->same_as) vw_print("                   the same: %s\n", candidate->same_as);
}

static void print_verdict(const struct vw_verified_selection *verified) {
    const struct vw_candidate *chosen = &verified->candidates.list[verified->chosen];
    uint32_t judges = verified->half_sizes[VW_HALF_A] + verified->half_sizes[VW_HALF_B];
    if (verified->candidates.count == 1)
        vw_print("chosen   all photos: every rule keeps them all, so nothing was trained\n");
    else if (verified->chosen)
        vw_print("chosen   %s: of the lists whose interval lies above 0 dB it gains the most\n", chosen->name);
    else vw_print("chosen   all photos: no list is better beyond noise, because no interval lies above 0 dB\n");
    if (judges < FEW_PHOTOS && verified->candidates.count > 1)
        vw_print("         only %u validation photos judge, which proves little; name more with --val\n", judges);
}

void vw_verified_selection_print(const struct vw_verified_selection *verified, uint32_t seeds) {
    if (verified->candidates.count > 1) {
        vw_print("verified by trainings at equal steps with seeds %" PRIu64 " to %" PRIu64
                 ": %u and %u validation photos\nselect for each other; gain in PSNR over all photos, 98 %% interval\n",
                 verified->first_seed, verified->first_seed + seeds - 1, verified->half_sizes[VW_HALF_A],
                 verified->half_sizes[VW_HALF_B]);
        vw_print("thinned: every n-th photo by name is left out; random: drawn\n\n");
        vw_print("%-18s %6s   %8s  interval\n", "list", "photos", "gain, dB");
        for (uint32_t c = 0; c < verified->candidates.count; c++) print_candidate(verified, c);
        vw_print("\n");
    }
    print_verdict(verified);
}

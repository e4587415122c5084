#include <inttypes.h>
#include <math.h>

#include "cli/output/print.h"
#include "lab/output/results.h"
#include "value/lasting_scores.h"

enum { SHOWN_AT_EACH_END = 5 };

// ---- Text ----------------------------------------------------------------------------------------------------------

static void print_photo(const struct vw_lasting_seeds *seeds, uint32_t photo) {
    const struct vw_seed_mean *mean = &seeds->means[0][photo];
    vw_print("  %+9" VW_SCORE_DIGITS "f [%+9" VW_SCORE_DIGITS "f, %+9" VW_SCORE_DIGITS "f] %s  rank %u-%u  %s\n",
             mean->mean, mean->ci_low, mean->ci_high, seeds->units[0], mean->rank_ci_low, mean->rank_ci_high,
             seeds->names[photo]);
}

// Prints the photos of ranks `first` to `last`.
static void print_ranks(const struct vw_lasting_seeds *seeds, uint32_t first, uint32_t last) {
    for (uint32_t rank = first; rank <= last; rank++)
        for (uint32_t i = 0; i < seeds->photo_count; i++)
            if (seeds->means[0][i].rank == rank) print_photo(seeds, i);
}

static void print_told_apart(const struct vw_lasting_seeds *seeds) {
    if (seeds->told_apart == 0)
        vw_print("         all intervals overlap: these seeds cannot tell any of the photos apart; more --seeds make "
                 "intervals shorter, and on a clean scene the photos may be worth the same\n");
    else
        vw_print("         %" PRIu64 " of %" PRIu64
                 " pairs of photos have intervals that do not overlap; the others are "
                 "indistinguishable\n",
                 seeds->told_apart, seeds->pairs);
}

static void print_gates(const struct vw_lasting_seeds *seeds, uint64_t first_seed) {
    uint32_t known = 0, low = 0;
    vw_print("gate     correlation of predicted with measured change:");
    for (uint32_t i = 0; i < seeds->seed_count; i++) {
        if (isnan(seeds->gates[i])) continue;
        vw_print("%s seed %" PRIu64 " %.2f", known++ ? "," : "", first_seed + i, seeds->gates[i]);
        low += seeds->gates[i] < vw_lasting_gate_least;
    }
    vw_print(known ? "\n" : " none\n");
    if (low)
        vw_print("         below %.1f in %u of %u: lasting credit is not to be trusted there\n", vw_lasting_gate_least,
                 low, known);
}

void vw_lasting_seeds_print(const struct vw_lasting_seeds *seeds, uint64_t first_seed) {
    uint32_t photos = seeds->photo_count, half = photos > 1 ? photos / 2 : photos;
    uint32_t shown = half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END;
    vw_print(
        "\nhighest lasting credit over %u seeds (mean of lasting_psnr; 95 %% intervals over seeds, of score without "
        "the seed's level and of rank)\n",
        seeds->seed_count);
    print_ranks(seeds, 1, shown);
    vw_print("lowest lasting credit\n");
    print_ranks(seeds, photos - shown + 1, photos);
    print_told_apart(seeds);
    print_gates(seeds, first_seed);
    vw_print("lasting    %s\n", seeds->path);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *photos_to_json(const struct vw_lasting_seeds *seeds, uint32_t method) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < seeds->photo_count; i++) {
        const struct vw_seed_mean *mean = &seeds->means[method][i];
        vw_json_append(&array,
                       json_pack("{s:s, s:o, s:o, s:o, s:o, s:I, s:I, s:I, s:I}", "name", seeds->names[i], "mean",
                                 vw_json_real(mean->mean), "stderr", vw_json_real(mean->standard_error), "ci_low",
                                 vw_json_real(mean->ci_low), "ci_high", vw_json_real(mean->ci_high), "rank",
                                 (json_int_t)mean->rank, "rank_ci_low", (json_int_t)mean->rank_ci_low, "rank_ci_high",
                                 (json_int_t)mean->rank_ci_high, "indistinguishable_from", (json_int_t)mean->overlaps));
    }
    return array;
}

json_t *vw_lasting_seeds_to_json(const struct vw_lasting_seeds *seeds) {
    json_t *methods = json_array(), *gates = json_array();
    for (uint32_t i = 0; i < VW_LASTING_METHODS; i++)
        vw_json_append(&methods, json_pack("{s:s, s:s, s:o}", "method", seeds->methods[i], "unit", seeds->units[i],
                                           "photos", photos_to_json(seeds, i)));
    for (uint32_t i = 0; i < seeds->seed_count; i++) vw_json_append(&gates, vw_json_real(seeds->gates[i]));
    return json_pack("{s:I, s:I, s:b, s:o, s:o, s:s}", "pairs", (json_int_t)seeds->pairs, "pairs_told_apart",
                     (json_int_t)seeds->told_apart, "all_indistinguishable", seeds->told_apart == 0, "gates", gates,
                     "methods", methods, "table", seeds->path);
}

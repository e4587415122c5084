// The tables of a comparison for people.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "experiment/set_comparison.h"
#include "value/evaluation/paired_comparison.h"

enum { CELL_WIDTH = 18, NAME_WIDTH = 20 };

static const struct {
    const char *heading, *unit;
    int digits;
} columns[VW_AGGREGATE_MEASURES] = {
    [VW_AGGREGATE_VAL_PSNR] = {"val PSNR, dB", " dB", 2},
    [VW_AGGREGATE_VAL_SSIM] = {"val SSIM", "", 4},
    [VW_AGGREGATE_VAL_L1] = {"val L1", "", 4},
    [VW_AGGREGATE_TEST_PSNR] = {"test PSNR, dB", " dB", 2},
    [VW_AGGREGATE_TEST_SSIM] = {"test SSIM", "", 4},
    [VW_AGGREGATE_TEST_L1] = {"test L1", "", 4},
};

// Whether any training has such a value: a split may be empty, and photos smaller than a window.
static bool is_known(const struct vw_set_comparison *compared, enum vw_outcome_measure measure) {
    bool known = false;
    for (uint32_t i = 0; i < compared->lists->count * compared->options->seeds; i++)
        known |= isfinite(vw_outcome_of(&compared->outcomes[i], measure));
    return known;
}

// No blanks at the ends of lines.
static enum vw_outcome_measure last_known(const struct vw_set_comparison *compared) {
    enum vw_outcome_measure last = 0;
    for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
        if (is_known(compared, measure)) last = measure;
    return last;
}

static void print_cell(const char *text, bool last) { printf("  %-*s", last ? 0 : CELL_WIDTH, text); }

static void print_list(const struct vw_set_comparison *compared, uint32_t place, enum vw_outcome_measure last) {
    const struct vw_photo_set *list = &compared->lists->lists[place];
    printf("%-*s  %6u  %6u", NAME_WIDTH, list->name, list->count, list->epochs);
    for (enum vw_outcome_measure measure = 0; measure <= last; measure++) {
        if (!is_known(compared, measure)) continue;
        struct vw_outcome_mean mean =
            vw_outcomes_mean(vw_set_comparison_outcomes(compared, place), compared->options->seeds, measure);
        int digits = columns[measure].digits;
        char text[64];
        if (isnan(mean.standard_error)) snprintf(text, sizeof text, "%.*f", digits, mean.mean);
        else snprintf(text, sizeof text, "%.*f +-%.*f", digits, mean.mean, digits, mean.standard_error);
        print_cell(text, measure == last);
    }
    putchar('\n');
}

static void print_lists(const struct vw_set_comparison *compared) {
    enum vw_outcome_measure last = last_known(compared);
    printf("%-*s  photos  epochs", NAME_WIDTH, "list");
    for (enum vw_outcome_measure measure = 0; measure <= last; measure++)
        if (is_known(compared, measure)) print_cell(columns[measure].heading, measure == last);
    putchar('\n');
    for (uint32_t l = 0; l < compared->lists->count; l++) print_list(compared, l, last);
}

static const char *verdict_of(const struct vw_paired_difference *paired, enum vw_outcome_measure measure) {
    if (isnan(paired->ci_low)) return "a single seed says nothing of noise";
    if (!paired->beyond_noise) return "within noise";
    return (paired->difference > 0) == vw_outcome_more_is_better(measure) ? "better" : "worse";
}

static void print_difference(const struct vw_set_comparison *compared, const struct vw_set_pair *pair,
                             enum vw_outcome_measure measure) {
    struct vw_paired_difference paired =
        vw_outcomes_compare(vw_set_comparison_outcomes(compared, pair->list),
                            vw_set_comparison_outcomes(compared, pair->against), compared->options->seeds, measure);
    int digits = columns[measure].digits;
    printf("  %-9.*s  %+10.*f", (int)strcspn(columns[measure].heading, ","), columns[measure].heading, digits,
           paired.difference);
    if (!isnan(paired.ci_low)) printf(" [%+10.*f, %+10.*f]", digits, paired.ci_low, digits, paired.ci_high);
    printf("%s  %s\n", columns[measure].unit, verdict_of(&paired, measure));
}

static void print_pair(const struct vw_set_comparison *compared, const struct vw_set_pair *pair) {
    printf("\n%s against %s\n", compared->lists->lists[pair->list].name, compared->lists->lists[pair->against].name);
    for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
        if (is_known(compared, measure)) print_difference(compared, pair, measure);
}

void vw_set_comparison_print(const struct vw_set_comparison *compared) {
    const struct vw_options *options = compared->options;
    const struct vw_scene *scene = compared->scene;
    printf("%u lists of %s, %u seed%s from %" PRIu64 " on, equal %s; mean over seeds +- standard error\n"
           "PSNR, SSIM and L1: means over %u validation and %u test photos, %s\n",
           compared->lists->count, options->operand, options->seeds, options->seeds > 1 ? "s" : "",
           options->config.seed, vw_equal_name(options->equal), scene->split_count[VW_SPLIT_VAL],
           scene->split_count[VW_SPLIT_TEST],
           compared->half_views ? "their right halves: appearance is fitted on the left ones" : "whole");
    if (compared->lists->by_scores)
        printf("lists chosen by --scores were chosen on validation photos: only test figures are out of sample\n");
    putchar('\n');
    print_lists(compared);
    if (compared->pair_count) printf("\ndifferences of trainings with the same seed [95 %% interval]\n");
    for (uint32_t p = 0; p < compared->pair_count; p++) print_pair(compared, &compared->pairs[p]);
    printf("\ncomparison  %s/compare.json, compare.csv, pairs.csv, disagreements.csv\n", options->out);
    if (compared->shown_count)
        printf("renders     %s/renders/0.png to %u.png: the photo, then each list\n", options->out,
               compared->shown_count - 1);
}

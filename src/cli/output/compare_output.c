#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"

enum { CELL_WIDTH = 18, NAME_WIDTH = 20 };

static const struct {
    const char *heading, *unit;
    int digits;
} columns[VW_OUTCOME_COUNT] = {
    [VW_OUTCOME_VAL_PSNR] = {"val PSNR, dB", " dB", 2},
    [VW_OUTCOME_VAL_SSIM] = {"val SSIM", "", 4},
    [VW_OUTCOME_VAL_L1] = {"val L1", "", 4},
    [VW_OUTCOME_TEST_PSNR] = {"test PSNR, dB", " dB", 2},
    [VW_OUTCOME_TEST_SSIM] = {"test SSIM", "", 4},
    [VW_OUTCOME_TEST_L1] = {"test L1", "", 4},
};

// Returns true if any training has a value: a split may be empty, and photos may be smaller than the window of SSIM.
static bool is_known(const struct vw_comparison *comparison, enum vw_outcome outcome) {
    bool known = false;
    for (uint32_t i = 0; i < comparison->sets.count * comparison->params->common.seeds; i++)
        known |= isfinite(vw_outcome_of(&comparison->outcomes[i].result, outcome));
    return known;
}

// Returns the last outcome that is known: its column ends without blanks, since no line may end with them.
static enum vw_outcome last_known(const struct vw_comparison *comparison) {
    enum vw_outcome last = 0;
    for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
        if (is_known(comparison, outcome)) last = outcome;
    return last;
}

static void print_cell(const char *text, bool last) { vw_print("  %-*s", last ? 0 : CELL_WIDTH, text); }

static void print_list(const struct vw_comparison *comparison, uint32_t place, enum vw_outcome last) {
    const struct vw_photo_set *list = &comparison->sets.lists[place];
    vw_print("%-*s  %6u  %6u", NAME_WIDTH, list->name, list->count, list->epochs);
    for (enum vw_outcome outcome = 0; outcome <= last; outcome++) {
        if (!is_known(comparison, outcome)) continue;
        struct vw_outcome_mean mean = vw_comparison_mean(comparison, place, outcome);
        int digits = columns[outcome].digits;
        char text[64];
        if (isnan(mean.standard_error)) snprintf(text, sizeof text, "%.*f", digits, mean.mean);
        else snprintf(text, sizeof text, "%.*f +-%.*f", digits, mean.mean, digits, mean.standard_error);
        print_cell(text, outcome == last);
    }
    vw_print("\n");
}

static void print_lists(const struct vw_comparison *comparison) {
    enum vw_outcome last = last_known(comparison);
    vw_print("%-*s  photos  epochs", NAME_WIDTH, "list");
    for (enum vw_outcome outcome = 0; outcome <= last; outcome++)
        if (is_known(comparison, outcome)) print_cell(columns[outcome].heading, outcome == last);
    vw_print("\n");
    for (uint32_t l = 0; l < comparison->sets.count; l++) print_list(comparison, l, last);
}

static const char *verdict_of(const struct vw_paired_difference *paired, enum vw_outcome outcome) {
    if (isnan(paired->ci_low)) return "noise unknown with a single seed";
    if (!paired->beyond_noise) return "within noise";
    return (paired->difference > 0) == vw_outcome_higher_is_better(outcome) ? "better" : "worse";
}

// Prints a line, below the names of the lists where these begin.
static void print_pair(const struct vw_comparison *comparison, const struct vw_comparison_pair *pair) {
    const struct vw_paired_difference *paired = &pair->paired;
    int digits = columns[pair->outcome].digits;
    const char *heading = columns[pair->outcome].heading;
    if (pair->outcome == 0) vw_print("\n%s against %s\n", pair->list, pair->against);
    if (!is_known(comparison, pair->outcome)) return;
    vw_print("  %-9.*s  %+10.*f", (int)strcspn(heading, ","), heading, digits, paired->difference);
    if (!isnan(paired->ci_low)) vw_print(" [%+10.*f, %+10.*f]", digits, paired->ci_low, digits, paired->ci_high);
    vw_print("%s  %s\n", columns[pair->outcome].unit, verdict_of(paired, pair->outcome));
}

static void print_heading(const struct vw_comparison *comparison) {
    const struct vw_experiment_params *common = &comparison->params->common;
    const struct vw_scene *scene = comparison->session.scene;
    vw_print("%u lists of %s, %u seed%s from %" PRIu64 " on, equal %s; mean +- standard error\n"
             "PSNR, SSIM and L1: means over %u validation and %u test photos, %s\n",
             comparison->sets.count, common->scene.path, common->seeds, vw_plural(common->seeds), common->config->seed,
             vw_equal_name(comparison->params->sets.equal), scene->split_count[VW_SPLIT_VAL],
             scene->split_count[VW_SPLIT_TEST],
             comparison->half_views ? "their right halves: appearance is taken from the left ones" : "whole");
    if (comparison->sets.by_scores)
        vw_print("lists selected by --scores depend on the validation photos: only test metrics are out of sample\n");
}

static void print_text(const struct vw_comparison *comparison) {
    const char *out = comparison->params->common.out;
    print_heading(comparison);
    vw_print("\n");
    print_lists(comparison);
    if (comparison->pair_count) vw_print("\ndifferences of trainings with the same seed [95 %% interval]\n");
    for (uint32_t p = 0; p < comparison->pair_count; p++) print_pair(comparison, &comparison->pairs[p]);
    vw_print("\ncomparison  %s/compare.json, compare.csv, pairs.csv\n", out);
    if (comparison->rendered_count)
        vw_print("renders     %s/renders/0.png to %u.png: the photo, then each list\n", out,
                 comparison->rendered_count - 1);
    if (comparison->report_path) vw_print("report      %s\n", comparison->report_path);
}

enum vw_status vw_comparison_print(const struct vw_comparison *comparison, bool json) {
    if (json) return vw_json_print(vw_comparison_to_json(comparison));
    print_text(comparison);
    return VW_OK;
}

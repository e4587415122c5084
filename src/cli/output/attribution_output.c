#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "report/tables.h"

enum { SHOWN_ROWS = 20, SHOWN_GROUPS = 10, SHOWN_IN_GROUP = 6 }; // the tables have all
enum { AMOUNT_BYTES = 24 };

// Writes cents as "12.34".
static void amount_to_text(uint64_t cents, char text[AMOUNT_BYTES]) {
    snprintf(text, AMOUNT_BYTES, "%" PRIu64 ".%02" PRIu64, cents / 100, cents % 100);
}

// ---- Text ----------------------------------------------------------------------------------------------------------

static const char *provider_of(const char *provider) { return provider && *provider ? provider : "(no provider)"; }

static void print_value(double value, double standard_error, const char *unit) {
    char error[32] = "?"; // a single visit has no standard error
    if (isfinite(standard_error)) snprintf(error, sizeof error, "%" VW_SCORE_DIGITS "f", standard_error);
    vw_print("  %+9" VW_SCORE_DIGITS "f ± %s %s  ", value, error, unit);
}

static void print_more(uint32_t count, uint32_t shown, const char *path) {
    if (count > shown) vw_print("  and %u more: %s\n", count - shown, path);
}

static void print_groups(const struct vw_attribution *attribution, const char *method, const char *meaning) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < attribution->group_count; i++) {
        const struct vw_provider_score *group = &attribution->groups[i];
        if (strcmp(group->method, method) != 0 || ++count > SHOWN_ROWS) continue;
        if (count == 1) vw_print("providers (%s, %s ± standard error)\n", method, meaning);
        print_value(group->value, group->standard_error, group->unit);
        vw_print("%s (%u photo%s)\n", provider_of(group->provider), group->photo_count, vw_plural(group->photo_count));
    }
    print_more(count, SHOWN_ROWS, attribution->providers_path);
}

// Says who is paid, or why no one is.
static void print_outcome(const struct vw_attribution *attribution) {
    char amount[AMOUNT_BYTES];
    uint32_t enough = attribution->advised_retrainings;
    amount_to_text(attribution->request.cents, amount);
    if (attribution->outcome == VW_PAYOUT_PAID)
        vw_print("payout of %s by %s, the sum over each provider's photos [90 %% interval]\n", amount,
                 attribution->payouts.none_positive ? "the number of photos, since no photo has a positive worth"
                                                    : attribution->method);
    if (attribution->outcome == VW_PAYOUT_UNKNOWN_WORTH)
        vw_print(
            "payout of %s: nobody is paid, since no retrainings say what the photos are worth: viewworth worth OUT "
            "--retrainings %u --payout %s; or --pay-anyway\n",
            amount, enough, amount);
    if (attribution->outcome == VW_PAYOUT_NOT_TOLD_APART && enough)
        vw_print("payout of %s: nobody is paid, since %u retrainings tell no two photos apart; about %u would be "
                 "enough: viewworth worth OUT --retrainings %u --payout %s; or --pay-anyway\n",
                 amount, attribution->payouts.retraining_count, enough, enough, amount);
    if (attribution->outcome == VW_PAYOUT_NOT_TOLD_APART && !enough)
        vw_print(
            "payout of %s: nobody is paid, since %u retrainings tell no two photos apart, nor would any number that "
            "worth makes; add photos, or --pay-anyway\n",
            amount, attribution->payouts.retraining_count);
    if (attribution->outcome == VW_PAYOUT_NONE_POSITIVE)
        vw_print(
            "payout of %s: nobody is paid, since no photo has a positive worth; --payout-floor equal pays all photos "
            "the same\n",
            amount);
}

static void print_payout(const struct vw_payout *payout) {
    char amount[AMOUNT_BYTES], range[2 * VW_CELL_BYTES] = "?, ?";
    amount_to_text(payout->cents, amount);
    if (isfinite(payout->interval.low_cents))
        snprintf(range, sizeof range, "%.2f, %.2f", payout->interval.low_cents / 100,
                 payout->interval.high_cents / 100);
    vw_print("  %14s  [%s]  %s", amount, range, payout->provider);
    if (payout->alike_count)
        vw_print(" (not told apart from %u other%s)", payout->alike_count, vw_plural(payout->alike_count));
    vw_print("\n");
}

static void print_unvalued(const struct vw_attribution *attribution) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < attribution->payouts.provider_count; i++) {
        const struct vw_payout *payout = &attribution->payouts.providers[i];
        if (!payout->validating_count && !payout->test_count && !payout->unscored_count) continue;
        if (++count > SHOWN_ROWS) continue;
        vw_print("  unvalued, so not paid: of %s %u that validate, %u kept for tests, %u without a score\n",
                 payout->provider, payout->validating_count, payout->test_count, payout->unscored_count);
    }
    if (count > SHOWN_ROWS) vw_print("  and photos of %u more providers\n", count - SHOWN_ROWS);
    if (count) vw_print("  (viewworth value --kfold K values all photos but those kept for tests)\n");
}

static void print_payouts(const struct vw_attribution *attribution) {
    const struct vw_payouts *payouts = &attribution->payouts;
    bool shows = attribution->outcome == VW_PAYOUT_PAID || attribution->outcome == VW_PAYOUT_NOT_TOLD_APART;
    if (attribution->outcome == VW_PAYOUT_NOT_ASKED) return;
    print_outcome(attribution);
    for (uint32_t i = 0; shows && i < payouts->provider_count && i < SHOWN_ROWS; i++)
        print_payout(&payouts->providers[i]);
    if (attribution->outcome == VW_PAYOUT_PAID) {
        print_more(payouts->provider_count, SHOWN_ROWS, attribution->payout_path);
        vw_print("  of each photo: %s\n", attribution->payout_photos_path);
    }
    print_unvalued(attribution);
}

static const char *judged_as(const struct vw_duplicate_score *row) {
    if (row->score) return "";
    return strcmp(row->image->split, "val") == 0    ? " (validates)"
           : strcmp(row->image->split, "test") == 0 ? " (tests)"
                                                    : " (has no score)";
}

// Prints a group on one line; the table has each photo's own score. Returns how many rows it has.
static uint32_t print_duplicate_group(const struct vw_attribution *attribution, uint32_t first) {
    const struct vw_duplicate_score *rows = attribution->duplicates;
    uint32_t end = first;
    vw_print("near-duplicates, together %+" VW_SCORE_DIGITS "f by %s:", rows[first].group_value, attribution->method);
    for (; end < attribution->duplicate_count && rows[end].group == rows[first].group; end++) {
        const char *provider = rows[end].image->provider;
        if (end - first >= SHOWN_IN_GROUP) continue;
        vw_print("%s %s%s", end > first ? "," : "", rows[end].image->name, judged_as(&rows[end]));
        if (provider && *provider) vw_print(" of %s", provider);
    }
    if (end - first > SHOWN_IN_GROUP) vw_print(" and %u more", end - first - SHOWN_IN_GROUP);
    vw_print("\n");
    return end - first;
}

static void print_duplicates(const struct vw_attribution *attribution) {
    const struct vw_duplicate_score *rows = attribution->duplicates;
    uint32_t groups = 0, i = 0;
    while (i < attribution->duplicate_count && groups++ < SHOWN_GROUPS) i += print_duplicate_group(attribution, i);
    for (; i < attribution->duplicate_count; i++) groups += rows[i].group != rows[i - 1].group;
    print_more(groups, SHOWN_GROUPS, attribution->duplicates_path);
}

void vw_attribution_print(const struct vw_attribution *attribution) {
    print_groups(attribution, attribution->method, "sum of their photos");
    print_payouts(attribution);
    print_duplicates(attribution);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

// Adds the payouts; where no one is paid, why, and how many retrainings would be enough.
static void add_payouts(const struct vw_attribution *attribution, json_t **root) {
    static const char *const reasons[] = {[VW_PAYOUT_UNKNOWN_WORTH] = "no retrainings",
                                          [VW_PAYOUT_NOT_TOLD_APART] = "not told apart",
                                          [VW_PAYOUT_NONE_POSITIVE] = "no photo has a positive worth"};
    if (attribution->outcome == VW_PAYOUT_NOT_ASKED) return;
    if (attribution->outcome != VW_PAYOUT_PAID) {
        vw_json_set(root, "unpaid",
                    json_pack("{s:s, s:I}", "reason", reasons[attribution->outcome], "retrainings_enough",
                              (json_int_t)attribution->advised_retrainings));
        return;
    }
    const struct vw_rows providers = vw_payout_rows(&attribution->payouts),
                         photos = vw_photo_payout_rows(&attribution->payouts);
    vw_json_set(root, "payout", vw_rows_to_json(&providers));
    vw_json_set(root, "payout_photos", vw_rows_to_json(&photos));
}

void vw_attribution_add_json(const struct vw_attribution *attribution, json_t **root) {
    const struct vw_rows providers = vw_provider_rows(attribution->groups, attribution->group_count),
                         duplicates = vw_duplicate_rows(attribution->duplicates, attribution->duplicate_count);
    vw_json_set(root, "providers", vw_rows_to_json(&providers));
    vw_json_set(root, "duplicates", vw_rows_to_json(&duplicates));
    add_payouts(attribution, root);
}

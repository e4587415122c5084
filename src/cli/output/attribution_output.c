#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "report/tables.h"

enum { SHOWN_ROWS = 20, SHOWN_GROUPS = 10, SHOWN_IN_GROUP = 6 }; // the tables have all

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
    char amount[VW_AMOUNT_BYTES];
    uint32_t enough = attribution->advised_retrainings;
    vw_amount_to_text(attribution->request.cents, amount);
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
    char amount[VW_AMOUNT_BYTES], low[VW_AMOUNT_BYTES], high[VW_AMOUNT_BYTES];
    vw_amount_to_text(payout->cents, amount);
    vw_amount_range_to_text(payout->interval, low, high);
    vw_print("  %14s  [%s, %s]  %s", amount, *low ? low : "?", *high ? high : "?", payout->provider);
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

// Prints a group on one line; the table has each photo's own score. Returns how many rows it has.
static uint32_t print_duplicate_group(const struct vw_attribution *attribution, uint32_t first) {
    const struct vw_duplicate_score *rows = attribution->duplicates;
    uint32_t end = first;
    vw_print("near-duplicates, together %+" VW_SCORE_DIGITS "f by %s:", rows[first].group_value, attribution->method);
    for (; end < attribution->duplicate_count && rows[end].group == rows[first].group; end++) {
        const char *provider = rows[end].image->provider;
        if (end - first >= SHOWN_IN_GROUP) continue;
        vw_print("%s %s%s", end > first ? "," : "", rows[end].image->name, rows[end].score ? "" : " (validates)");
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
    print_groups(attribution, vw_joint_worth_method, "all their photos at once, by trainings with and without them");
    print_payouts(attribution);
    print_duplicates(attribution);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *provider_to_json(const struct vw_provider_score *group) {
    return json_pack("{s:s, s:s, s:o, s:s, s:o, s:I}", "provider", group->provider, "method", group->method, "value",
                     vw_json_real(group->value), "unit", group->unit, "stderr", vw_json_real(group->standard_error),
                     "photos", (json_int_t)group->photo_count);
}

// Makes the amount with its interval, of a provider or a photo.
static json_t *amount_to_json(double share, uint64_t cents, struct vw_payout_interval interval) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(cents, amount);
    return json_pack("{s:o, s:s, s:I, s:o, s:o}", "share", vw_json_real(share), "amount", amount, "cents",
                     (json_int_t)cents, "ci_low_cents", vw_json_real(interval.low_cents), "ci_high_cents",
                     vw_json_real(interval.high_cents));
}

static json_t *payout_to_json(const struct vw_payout *payout) {
    json_t *root = amount_to_json(payout->share, payout->cents, payout->interval);
    vw_json_set(&root, "provider", json_string(payout->provider));
    vw_json_set(&root, "overlaps", json_integer(payout->alike_count));
    vw_json_set(&root, "photos", json_integer(payout->photo_count));
    vw_json_set(&root, "validating", json_integer(payout->validating_count));
    vw_json_set(&root, "tests", json_integer(payout->test_count));
    vw_json_set(&root, "unscored", json_integer(payout->unscored_count));
    return root;
}

static json_t *photo_to_json(const struct vw_photo_payout *photo) {
    json_t *root = amount_to_json(photo->share, photo->cents, photo->interval);
    vw_json_set(&root, "name", json_string(photo->image->name));
    vw_json_set(&root, "provider", json_string(photo->image->provider));
    vw_json_set(&root, "method", json_string(photo->score->method));
    vw_json_set(&root, "value", vw_json_real(photo->score->value));
    return root;
}

// Adds the payouts; where no one is paid, why, and how many retrainings would be enough.
static void add_payouts(const struct vw_attribution *attribution, json_t **root) {
    static const char *const reasons[] = {[VW_PAYOUT_UNKNOWN_WORTH] = "no retrainings",
                                          [VW_PAYOUT_NOT_TOLD_APART] = "not told apart",
                                          [VW_PAYOUT_NONE_POSITIVE] = "no photo has a positive worth"};
    const struct vw_payouts *payouts = &attribution->payouts;
    if (attribution->outcome == VW_PAYOUT_NOT_ASKED) return;
    if (attribution->outcome != VW_PAYOUT_PAID) {
        vw_json_set(root, "unpaid",
                    json_pack("{s:s, s:I}", "reason", reasons[attribution->outcome], "retrainings_enough",
                              (json_int_t)attribution->advised_retrainings));
        return;
    }
    json_t *providers = json_array(), *photos = json_array();
    for (uint32_t i = 0; i < payouts->provider_count; i++)
        vw_json_append(&providers, payout_to_json(&payouts->providers[i]));
    for (uint32_t i = 0; i < payouts->photo_count; i++) vw_json_append(&photos, photo_to_json(&payouts->photos[i]));
    vw_json_set(root, "payout", providers);
    vw_json_set(root, "payout_photos", photos);
}

static json_t *duplicate_to_json(const struct vw_duplicate_score *row) {
    return json_pack("{s:I, s:s, s:s, s:s, s:o, s:o, s:o, s:I}", "group", (json_int_t)row->group, "name",
                     row->image->name, "split", row->image->split, "provider",
                     row->image->provider ? row->image->provider : "", "similarity", vw_json_real(row->similarity),
                     "value", vw_json_real(row->score ? row->score->value : NAN), "group_value",
                     vw_json_real(row->group_value), "providers", (json_int_t)row->provider_count);
}

void vw_attribution_add_json(const struct vw_attribution *attribution, json_t **root) {
    json_t *providers = json_array(), *duplicates = json_array();
    for (uint32_t i = 0; i < attribution->group_count; i++)
        vw_json_append(&providers, provider_to_json(&attribution->groups[i]));
    for (uint32_t i = 0; i < attribution->duplicate_count; i++)
        vw_json_append(&duplicates, duplicate_to_json(&attribution->duplicates[i]));
    vw_json_set(root, "providers", providers);
    vw_json_set(root, "duplicates", duplicates);
    add_payouts(attribution, root);
}

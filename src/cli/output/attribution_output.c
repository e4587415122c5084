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

static void print_more(uint32_t count, uint32_t shown, const char *out, const char *file) {
    if (count > shown) vw_print("  and %u more: %s/%s\n", count - shown, out, file);
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
    print_more(count, SHOWN_ROWS, attribution->out, "providers.csv");
}

// Says why no one is paid, and who would get nothing.
static void print_unpaid(const struct vw_payouts *payouts, const char *out, const char *amount) {
    uint32_t made = payouts->retraining_count;
    if (payouts->outcome == VW_PAYOUT_NONE_POSITIVE)
        vw_print("payout of %s: nobody is paid, since no photo has a positive worth\n", amount);
    else if (payouts->outcome == VW_PAYOUT_UNKNOWN_WORTH)
        vw_print("payout of %s: nobody is paid, since no retrainings say what the photos are worth; make two for each "
                 "photo to begin with: viewworth worth %s --retrainings M --payout %s\n",
                 amount, out, amount);
    else
        vw_print("payout of %s: nobody is paid, since %u retrainings tell no two photos apart; more may: viewworth "
                 "worth %s --retrainings %u --payout %s\n",
                 amount, made, out, 2 * made, amount);
    for (uint32_t i = 0; payouts->outcome == VW_PAYOUT_NOT_TOLD_APART && i < payouts->provider_count; i++)
        if (!payouts->providers[i].cents) vw_print("  would get nothing: %s\n", payouts->providers[i].provider);
}

static void print_payouts(const struct vw_attribution *attribution) {
    const struct vw_payouts *payouts = &attribution->payouts;
    struct vw_rows rows = vw_payout_rows(payouts);
    char amount[AMOUNT_BYTES];
    if (payouts->outcome == VW_PAYOUT_NOT_ASKED) return;
    amount_to_text(payouts->amount_cents, amount);
    if (payouts->outcome != VW_PAYOUT_PAID) {
        print_unpaid(payouts, attribution->out, amount);
        return;
    }
    vw_print(
        "payout of %s by worth (steps and retrainings not repeated: viewworth verify %s --replay all --retrainings "
        "all)\n",
        amount, attribution->out);
    if (rows.count > SHOWN_ROWS) rows.count = SHOWN_ROWS;
    vw_print_rows(&rows);
    print_more(payouts->provider_count, SHOWN_ROWS, attribution->out, "payout.csv");
    vw_print("of each photo: %s/payout_photos.csv\n", attribution->out);
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
    print_more(groups, SHOWN_GROUPS, attribution->out, "duplicates.csv");
}

void vw_attribution_print(const struct vw_attribution *attribution) {
    print_groups(attribution, attribution->method, "sum of their photos");
    print_payouts(attribution);
    print_duplicates(attribution);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

// Adds the payouts, or why no one is paid.
static void add_payouts(const struct vw_attribution *attribution, json_t **root) {
    static const char *const reasons[] = {[VW_PAYOUT_UNKNOWN_WORTH] = "no retrainings",
                                          [VW_PAYOUT_NOT_TOLD_APART] = "not told apart",
                                          [VW_PAYOUT_NONE_POSITIVE] = "no photo has a positive worth"};
    const struct vw_payouts *payouts = &attribution->payouts;
    const struct vw_rows rows = vw_payout_rows(payouts), of_photos = vw_photo_payout_rows(payouts);
    if (payouts->outcome == VW_PAYOUT_NOT_ASKED) return;
    if (payouts->outcome != VW_PAYOUT_PAID) {
        vw_json_set(root, "unpaid", json_pack("{s:s}", "reason", reasons[payouts->outcome]));
        return;
    }
    vw_json_set(root, "payout", vw_rows_to_json(&rows));
    vw_json_set(root, "payout_photos", vw_rows_to_json(&of_photos));
}

void vw_attribution_add_json(const struct vw_attribution *attribution, json_t **root) {
    const struct vw_rows providers = vw_provider_rows(attribution->groups, attribution->group_count),
                         duplicates = vw_duplicate_rows(attribution->duplicates, attribution->duplicate_count);
    vw_json_set(root, "providers", vw_rows_to_json(&providers));
    vw_json_set(root, "duplicates", vw_rows_to_json(&duplicates));
    add_payouts(attribution, root);
}

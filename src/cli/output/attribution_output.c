#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/output/print.h"
#include "cli/output/results.h"
#include "report/tables.h"

enum { SHOWN_ROWS = 20, SHOWN_GROUPS = 10 }; // the tables have all

// ---- Text ----------------------------------------------------------------------------------------------------------

static bool is_shown(const struct vw_attribution *attribution, const struct vw_provider_score *group) {
    return strcmp(group->method, attribution->method) == 0;
}

static const char *provider_of(const char *provider) { return provider && *provider ? provider : "(no provider)"; }

static void print_value(double value, double standard_error, const char *unit) {
    char error[32] = "?"; // a single visit has no standard error
    if (isfinite(standard_error)) snprintf(error, sizeof error, "%" VW_SCORE_DIGITS "f", standard_error);
    vw_print("  %+9" VW_SCORE_DIGITS "f ± %s %s  ", value, error, unit);
}

static void print_more(uint32_t count, uint32_t shown, const char *path) {
    if (count > shown) vw_print("  and %u more: %s\n", count - shown, path);
}

static void print_providers(const struct vw_attribution *attribution) {
    uint32_t count = 0;
    if (attribution->group_count > 0)
        vw_print("providers (%s, %s ± standard error)\n", attribution->method,
                 attribution->players ? "all their photos at once, by trainings with and without them"
                                      : "sum of their photos");
    for (uint32_t i = 0; i < attribution->group_count; i++) {
        const struct vw_provider_score *group = &attribution->groups[i];
        if (!is_shown(attribution, group) || ++count > SHOWN_ROWS) continue;
        print_value(group->value, group->standard_error, group->unit);
        vw_print("%s (%u photo%s)\n", provider_of(group->provider), group->photo_count,
                 group->photo_count == 1 ? "" : "s");
    }
    print_more(count, SHOWN_ROWS, attribution->providers_path);
}

static void print_payout(const struct vw_attribution *attribution) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(attribution->amount_cents, amount);
    if (attribution->payout_count > 0)
        vw_print("payout of %s by %s (in proportion to positive values; other providers receive nothing)\n", amount,
                 attribution->method);
    for (uint32_t i = 0; i < attribution->payout_count && i < SHOWN_ROWS; i++) {
        vw_amount_to_text(attribution->payouts[i].cents, amount);
        vw_print("  %14s  %s\n", amount, attribution->payouts[i].group->provider);
    }
    print_more(attribution->payout_count, SHOWN_ROWS, attribution->payout_path);
    if (attribution->photo_count)
        vw_print("  split among each provider's photos by %s above the scene's lowest: %s\n", vw_payout_split_method,
                 attribution->payout_photos_path);
    else if (attribution->payout_count)
        vw_print("  not split among photos, which needs lasting credit: viewworth lasting\n");
}

static void print_duplicate(const struct vw_duplicate_score *row) {
    if (row->score) print_value(row->score->value, row->score->standard_error, row->score->unit);
    else vw_print("  validates  ");
    vw_print("%s, %s, similarity %.4f\n", row->image->name, provider_of(row->image->provider), row->similarity);
}

static void print_duplicates(const struct vw_attribution *attribution) {
    uint32_t groups = 0;
    const struct vw_duplicate_score *rows = attribution->duplicates;
    for (uint32_t i = 0; i < attribution->duplicate_count; i++) {
        bool begins = i == 0 || rows[i].group != rows[i - 1].group;
        if (begins && ++groups <= SHOWN_GROUPS)
            vw_print("near-duplicates, together %+" VW_SCORE_DIGITS "f by %s\n", rows[i].group_value,
                     attribution->method);
        if (groups <= SHOWN_GROUPS) print_duplicate(&rows[i]);
    }
    print_more(groups, SHOWN_GROUPS, attribution->duplicates_path);
}

void vw_attribution_print(const struct vw_attribution *attribution) {
    print_providers(attribution);
    print_payout(attribution);
    print_duplicates(attribution);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *provider_to_json(const struct vw_provider_score *group) {
    return json_pack("{s:s, s:s, s:o, s:s, s:o, s:I}", "provider", group->provider, "method", group->method, "value",
                     vw_json_real(group->value), "unit", group->unit, "stderr", vw_json_real(group->standard_error),
                     "photos", (json_int_t)group->photo_count);
}

static json_t *payout_to_json(const struct vw_payout *payout) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(payout->cents, amount);
    return json_pack("{s:s, s:o, s:s, s:I}", "provider", payout->group->provider, "share", vw_json_real(payout->share),
                     "amount", amount, "cents", (json_int_t)payout->cents);
}

static json_t *photo_to_json(const struct vw_photo_payout *photo) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(photo->cents, amount);
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:s, s:I}", "name", photo->image->name, "provider",
                     photo->image->provider, "method", photo->score->method, "value", vw_json_real(photo->score->value),
                     "share", vw_json_real(photo->share), "amount", amount, "cents", (json_int_t)photo->cents);
}

static json_t *duplicate_to_json(const struct vw_duplicate_score *row) {
    return json_pack("{s:I, s:s, s:s, s:s, s:o, s:o, s:o, s:I}", "group", (json_int_t)row->group, "name",
                     row->image->name, "split", row->image->split, "provider",
                     row->image->provider ? row->image->provider : "", "similarity", vw_json_real(row->similarity),
                     "value", vw_json_real(row->score ? row->score->value : NAN), "group_value",
                     vw_json_real(row->group_value), "providers", (json_int_t)row->provider_count);
}

void vw_attribution_add_json(const struct vw_attribution *attribution, json_t **root) {
    json_t *providers = json_array(), *payout = json_array(), *photos = json_array(), *duplicates = json_array();
    for (uint32_t i = 0; i < attribution->group_count; i++)
        vw_json_append(&providers, provider_to_json(&attribution->groups[i]));
    for (uint32_t i = 0; i < attribution->duplicate_count; i++)
        vw_json_append(&duplicates, duplicate_to_json(&attribution->duplicates[i]));
    for (uint32_t i = 0; i < attribution->payout_count; i++)
        vw_json_append(&payout, payout_to_json(&attribution->payouts[i]));
    for (uint32_t i = 0; i < attribution->photo_count; i++)
        vw_json_append(&photos, photo_to_json(&attribution->photos[i]));
    vw_json_set(root, "providers", providers);
    vw_json_set(root, "duplicates", duplicates);
    if (attribution->payout_count) vw_json_set(root, "payout", payout);
    else json_decref(payout);
    if (attribution->photo_count) vw_json_set(root, "payout_photos", photos);
    else json_decref(photos);
}

#include "run/outputs/attribution.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/output/json_output.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "scene/duplicates.h"
#include "report/tables.h"

enum { SHOWN_ROWS = 20, SHOWN_GROUPS = 10 }; // on stdout: the tables have all

// ---- Making
// -----------------------------------------------------------------------------------------------------------

static bool has_providers(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && *scene->views[i].provider) return true;
    return false;
}

enum vw_status vw_attribution_check_options(const struct vw_options *options) {
    uint64_t cents;
    if (!options->payout) return VW_OK;
    if (!vw_payout_parse(options->payout, &cents))
        return vw_fail(VW_ERROR_USAGE, "--payout takes an amount of 0.01 to %.0f, such as 1000 or 99.50, not \"%s\"",
                       (double)VW_PAYOUT_CENTS_MAX / 100, options->payout);
    if (options->config.epochs <= options->config.burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE,
                       "--payout: there will be no scores to pay by; take more --epochs than --burn-in");
    return VW_OK;
}

enum vw_status vw_attribution_check_scene(const struct vw_options *options, const struct vw_scene *scene) {
    if (options->payout && !has_providers(scene))
        return vw_fail(VW_ERROR_USAGE,
                       "--payout: no photo to train on has a provider; name them by --providers FILE.csv");
    return VW_OK;
}

// Providers may be named after the run: they decide no bit of it.
static enum vw_status take_providers(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                     struct vw_attribution *attribution) {
    const struct vw_value_input *input = &scoring->input;
    bool changed = false;
    attribution->images = vw_allocate(input->image_count, sizeof *attribution->images);
    if (!attribution->images) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const char *recorded = input->images[i].provider ? input->images[i].provider : "";
        attribution->images[i] = input->images[i];
        attribution->images[i].provider = run->scene->views[input->images[i].image_id].provider;
        changed = changed || strcmp(attribution->images[i].provider, recorded) != 0;
    }
    if (changed) vw_log_warning("providers are those given now, not those that the ledger recorded when the run began");
    return VW_OK;
}

static enum vw_status name_outputs(const char *out, struct vw_attribution *attribution) {
    attribution->providers_path = vw_path_join(out, "providers.csv");
    attribution->payout_path = vw_path_join(out, "payout.csv");
    attribution->duplicates_path = vw_path_join(out, "duplicates.csv");
    return attribution->providers_path && attribution->payout_path && attribution->duplicates_path ? VW_OK
                                                                                                   : VW_ERROR_MEMORY;
}

static enum vw_status make_groups(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                  struct vw_attribution *attribution) {
    if (!has_providers(run->scene)) return VW_OK;
    enum vw_status status =
        vw_providers_score(scoring->scores, scoring->score_count, attribution->images, scoring->input.image_count,
                           &attribution->groups, &attribution->group_count);
    if (!status && attribution->group_count > 0)
        status = vw_table_write_providers(attribution->providers_path, attribution->groups, attribution->group_count);
    return status;
}

static enum vw_status make_payout(const struct vw_training_run *run, struct vw_attribution *attribution) {
    if (!run->options->payout || !vw_payout_parse(run->options->payout, &attribution->amount_cents)) return VW_OK;
    if (attribution->group_count == 0)
        return vw_fail(VW_ERROR_INPUT, "--payout: the run has no scores to pay by; %s says why", run->ledger_path);
    enum vw_status status =
        vw_payout_divide(attribution->groups, attribution->group_count, attribution->method, attribution->amount_cents,
                         &attribution->payouts, &attribution->payout_count, &attribution->nobody_helped);
    return status ? status
                  : vw_table_write_payout(attribution->payout_path, attribution->payouts, attribution->payout_count);
}

static enum vw_status make_duplicates(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                      struct vw_attribution *attribution) {
    struct vw_duplicate *found = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_scene_find_duplicates(run->scene, &found, &count);
    if (!status)
        status = vw_duplicates_score(found, count, attribution->method, scoring->scores, scoring->score_count,
                                     attribution->images, scoring->input.image_count, &attribution->duplicates,
                                     &attribution->duplicate_count);
    if (!status && attribution->duplicate_count > 0)
        status = vw_table_write_duplicates(attribution->duplicates_path, attribution->duplicates,
                                           attribution->duplicate_count);
    free(found);
    return status;
}

// One line each, however many groups there are.
static void warn(const struct vw_attribution *attribution) {
    const struct vw_duplicate_score *rows = attribution->duplicates, *shared = NULL, *leaked = NULL;
    uint32_t shared_count = 0, leaked_count = 0;
    for (uint32_t i = attribution->duplicate_count; i-- > 0;) {
        if (i > 0 && rows[i].group == rows[i - 1].group) continue; // not the first of its group
        if (rows[i].provider_count > 1) shared = &rows[i], shared_count++;
        if (rows[i].validation_count > 0) leaked = &rows[i], leaked_count++;
    }
    if (shared)
        vw_log_warning("%u groups of near-duplicates are of several providers, the first that of %s: a copy shares its "
                       "original's credit; "
                       "pay for one photo of each, and value the rest without the others",
                       shared_count, shared->image->name);
    if (leaked)
        vw_log_warning("%u groups of near-duplicates both train and validate, the first that of %s: what trains there "
                       "scores high by being "
                       "known; exclude one side",
                       leaked_count, leaked->image->name);
    if (attribution->nobody_helped)
        vw_log_warning("--payout: no provider's sum is positive, so that all share equally");
}

enum vw_status vw_attribution_make(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                   const char *method, struct vw_attribution *attribution) {
    *attribution = (struct vw_attribution){.method = method};
    enum vw_status status = name_outputs(run->options->out, attribution);
    if (!status) status = take_providers(run, scoring, attribution);
    if (!status) status = make_groups(run, scoring, attribution);
    if (!status) status = make_payout(run, attribution);
    if (!status) status = make_duplicates(run, scoring, attribution);
    if (!status) warn(attribution);
    return status;
}

void vw_attribution_free(struct vw_attribution *attribution) {
    free(attribution->images);
    free(attribution->groups);
    free(attribution->payouts);
    free(attribution->duplicates);
    free(attribution->providers_path);
    free(attribution->payout_path);
    free(attribution->duplicates_path);
    *attribution = (struct vw_attribution){0};
}

// ---- Showing
// ----------------------------------------------------------------------------------------------------------

static bool is_shown(const struct vw_attribution *attribution, const struct vw_provider_score *group) {
    return strcmp(group->method, attribution->method) == 0;
}

static const char *provider_of(const char *provider) { return provider && *provider ? provider : "(no provider)"; }

// Control characters would command the terminal.
static void print_name(const char *name) {
    for (const char *next = name; *next; next++) putchar((unsigned char)*next < 0x20 || *next == 0x7f ? '?' : *next);
}

static void print_value(double value, double standard_error, const char *unit) {
    char error[32] = "?"; // of a single visit
    if (isfinite(standard_error)) snprintf(error, sizeof error, "%.4f", standard_error);
    printf("  %+9.4f ± %s %s  ", value, error, unit);
}

static void print_more(uint32_t count, uint32_t shown, const char *path) {
    if (count > shown) printf("  and %u more: %s\n", count - shown, path);
}

static void print_providers(const struct vw_attribution *attribution) {
    uint32_t count = 0;
    if (attribution->group_count > 0)
        printf("providers (%s, sum of their photos ± standard error)\n", attribution->method);
    for (uint32_t i = 0; i < attribution->group_count; i++) {
        const struct vw_provider_score *group = &attribution->groups[i];
        if (!is_shown(attribution, group) || ++count > SHOWN_ROWS) continue;
        print_value(group->value, group->standard_error, group->unit);
        print_name(provider_of(group->provider));
        printf(" (%u photo%s)\n", group->photo_count, group->photo_count == 1 ? "" : "s");
    }
    print_more(count, SHOWN_ROWS, attribution->providers_path);
}

static void print_payout(const struct vw_attribution *attribution) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(attribution->amount_cents, amount);
    if (attribution->payout_count > 0)
        printf("payout of %s by %s (nothing for sums that are not positive, the others in proportion)\n", amount,
               attribution->method);
    for (uint32_t i = 0; i < attribution->payout_count && i < SHOWN_ROWS; i++) {
        vw_amount_to_text(attribution->payouts[i].cents, amount);
        printf("  %14s  ", amount);
        print_name(attribution->payouts[i].group->provider);
        putchar('\n');
    }
    print_more(attribution->payout_count, SHOWN_ROWS, attribution->payout_path);
}

static void print_duplicate(const struct vw_duplicate_score *row) {
    if (row->score) print_value(row->score->value, row->score->standard_error, row->score->unit);
    else printf("  validates  ");
    print_name(row->image->name);
    printf(", ");
    print_name(provider_of(row->image->provider));
    printf(", similarity %.4f\n", row->similarity);
}

static void print_duplicates(const struct vw_attribution *attribution) {
    uint32_t groups = 0;
    const struct vw_duplicate_score *rows = attribution->duplicates;
    for (uint32_t i = 0; i < attribution->duplicate_count; i++) {
        bool begins = i == 0 || rows[i].group != rows[i - 1].group;
        if (begins && ++groups <= SHOWN_GROUPS)
            printf("near-duplicates, together %+.4f by %s\n", rows[i].group_value, attribution->method);
        if (groups <= SHOWN_GROUPS) print_duplicate(&rows[i]);
    }
    print_more(groups, SHOWN_GROUPS, attribution->duplicates_path);
}

void vw_attribution_print(const struct vw_attribution *attribution) {
    print_providers(attribution);
    print_payout(attribution);
    print_duplicates(attribution);
}

// ---- JSON
// -------------------------------------------------------------------------------------------------------------

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

static json_t *duplicate_to_json(const struct vw_duplicate_score *row) {
    return json_pack("{s:I, s:s, s:s, s:s, s:o, s:o, s:o, s:I}", "group", (json_int_t)row->group, "name",
                     row->image->name, "split", row->image->split, "provider",
                     row->image->provider ? row->image->provider : "", "similarity", vw_json_real(row->similarity),
                     "value", vw_json_real(row->score ? row->score->value : NAN), "group_value",
                     vw_json_real(row->group_value), "providers", (json_int_t)row->provider_count);
}

bool vw_attribution_add_json(const struct vw_attribution *attribution, json_t *root) {
    json_t *providers = json_array(), *payout = json_array(), *duplicates = json_array();
    int failed = 0;
    for (uint32_t i = 0; i < attribution->group_count; i++)
        failed |= json_array_append_new(providers, provider_to_json(&attribution->groups[i]));
    for (uint32_t i = 0; i < attribution->payout_count; i++)
        failed |= json_array_append_new(payout, payout_to_json(&attribution->payouts[i]));
    for (uint32_t i = 0; i < attribution->duplicate_count; i++)
        failed |= json_array_append_new(duplicates, duplicate_to_json(&attribution->duplicates[i]));
    failed |= json_object_set_new(root, "providers", providers);
    failed |= json_object_set_new(root, "duplicates", duplicates);
    if (attribution->payout_count > 0) failed |= json_object_set_new(root, "payout", payout);
    else json_decref(payout);
    return !failed;
}

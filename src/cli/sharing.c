#include "cli/sharing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_output.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/tables.h"

enum { SHOWN_ROWS = 20, SHOWN_GROUPS = 10 }; // on stdout: the tables have all

// ---- Making -----------------------------------------------------------------------------------------------------------

static bool has_providers(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && *scene->views[i].provider) return true;
    return false;
}

enum vw_status vw_sharing_check_options(const struct vw_options *options) {
    uint64_t cents;
    if (!options->payout) return VW_OK;
    if (!vw_payout_parse(options->payout, &cents))
        return vw_fail(VW_ERROR_USAGE, "--payout takes an amount of 0.01 to %.0f, such as 1000 or 99.50, not \"%s\"",
                       (double)VW_PAYOUT_CENTS_MAX / 100, options->payout);
    if (options->config.epochs <= options->config.burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE, "--payout: there will be no scores to pay by; take more --epochs than --burn-in");
    return VW_OK;
}

enum vw_status vw_sharing_check_scene(const struct vw_options *options, const struct vw_scene *scene) {
    if (options->payout && !has_providers(scene))
        return vw_fail(VW_ERROR_USAGE, "--payout: no photo to train on has a provider; name them by --providers FILE.csv");
    return VW_OK;
}

// Providers may be named after the run: they decide no bit of it.
static enum vw_status take_providers(const struct vw_training_run *run, const struct vw_scoring *scoring, struct vw_sharing *sharing) {
    const struct vw_value_input *input = &scoring->input;
    bool changed = false;
    sharing->images = vw_allocate(input->image_count, sizeof *sharing->images);
    if (!sharing->images) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const char *recorded = input->images[i].provider ? input->images[i].provider : "";
        sharing->images[i] = input->images[i];
        sharing->images[i].provider = run->scene->views[input->images[i].image_id].provider;
        changed = changed || strcmp(sharing->images[i].provider, recorded) != 0;
    }
    if (changed) vw_log_warning("providers are those given now, not those that the ledger recorded when the run began");
    return VW_OK;
}

static enum vw_status name_outputs(const char *out, struct vw_sharing *sharing) {
    sharing->providers_path = vw_path_join(out, "providers.csv");
    sharing->payout_path = vw_path_join(out, "payout.csv");
    sharing->duplicates_path = vw_path_join(out, "duplicates.csv");
    return sharing->providers_path && sharing->payout_path && sharing->duplicates_path ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status make_groups(const struct vw_training_run *run, const struct vw_scoring *scoring, struct vw_sharing *sharing) {
    if (!has_providers(run->scene)) return VW_OK;
    enum vw_status status = vw_providers_score(scoring->scores, scoring->score_count, sharing->images, scoring->input.image_count,
                                               &sharing->groups, &sharing->group_count);
    if (!status && sharing->group_count > 0)
        status = vw_table_write_providers(sharing->providers_path, sharing->groups, sharing->group_count);
    return status;
}

static enum vw_status make_payout(const struct vw_training_run *run, struct vw_sharing *sharing) {
    if (!run->options->payout || !vw_payout_parse(run->options->payout, &sharing->amount_cents)) return VW_OK;
    if (sharing->group_count == 0)
        return vw_fail(VW_ERROR_INPUT, "--payout: the run has no scores to pay by; %s says why", run->ledger_path);
    enum vw_status status = vw_payout_divide(sharing->groups, sharing->group_count, sharing->method, sharing->amount_cents,
                                             &sharing->payouts, &sharing->payout_count, &sharing->nobody_helped);
    return status ? status : vw_table_write_payout(sharing->payout_path, sharing->payouts, sharing->payout_count);
}

static enum vw_status make_duplicates(const struct vw_training_run *run, const struct vw_scoring *scoring, struct vw_sharing *sharing) {
    struct vw_duplicate *found = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_scene_find_duplicates(run->scene, &found, &count);
    if (!status)
        status = vw_duplicates_score(found, count, sharing->method, scoring->scores, scoring->score_count, sharing->images,
                                     scoring->input.image_count, &sharing->duplicates, &sharing->duplicate_count);
    if (!status && sharing->duplicate_count > 0)
        status = vw_table_write_duplicates(sharing->duplicates_path, sharing->duplicates, sharing->duplicate_count);
    free(found);
    return status;
}

// One line each, however many groups there are.
static void warn(const struct vw_sharing *sharing) {
    const struct vw_duplicate_score *rows = sharing->duplicates, *shared = NULL, *leaked = NULL;
    uint32_t shared_count = 0, leaked_count = 0;
    for (uint32_t i = sharing->duplicate_count; i-- > 0;) {
        if (i > 0 && rows[i].group == rows[i - 1].group) continue; // not the first of its group
        if (rows[i].provider_count > 1) shared = &rows[i], shared_count++;
        if (rows[i].validation_count > 0) leaked = &rows[i], leaked_count++;
    }
    if (shared)
        vw_log_warning("%u groups of near-duplicates are of several providers, the first that of %s: a copy shares its original's credit; "
                       "pay for one photo of each, and value the rest without the others",
                       shared_count, shared->image->name);
    if (leaked)
        vw_log_warning("%u groups of near-duplicates both train and validate, the first that of %s: what trains there scores high by being "
                       "known; exclude one side",
                       leaked_count, leaked->image->name);
    if (sharing->nobody_helped) vw_log_warning("--payout: no provider's sum is positive, so that all share equally");
}

enum vw_status vw_sharing_make(const struct vw_training_run *run, const struct vw_scoring *scoring, const char *method,
                               struct vw_sharing *sharing) {
    *sharing = (struct vw_sharing){.method = method};
    enum vw_status status = name_outputs(run->options->out, sharing);
    if (!status) status = take_providers(run, scoring, sharing);
    if (!status) status = make_groups(run, scoring, sharing);
    if (!status) status = make_payout(run, sharing);
    if (!status) status = make_duplicates(run, scoring, sharing);
    if (!status) warn(sharing);
    return status;
}

void vw_sharing_free(struct vw_sharing *sharing) {
    free(sharing->images);
    free(sharing->groups);
    free(sharing->payouts);
    free(sharing->duplicates);
    free(sharing->providers_path);
    free(sharing->payout_path);
    free(sharing->duplicates_path);
    *sharing = (struct vw_sharing){0};
}

// ---- Showing ----------------------------------------------------------------------------------------------------------

static bool is_shown(const struct vw_sharing *sharing, const struct vw_provider_score *group) {
    return strcmp(group->method, sharing->method) == 0;
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

static void print_providers(const struct vw_sharing *sharing) {
    uint32_t count = 0;
    if (sharing->group_count > 0) printf("providers (%s, sum of their photos ± standard error)\n", sharing->method);
    for (uint32_t i = 0; i < sharing->group_count; i++) {
        const struct vw_provider_score *group = &sharing->groups[i];
        if (!is_shown(sharing, group) || ++count > SHOWN_ROWS) continue;
        print_value(group->value, group->standard_error, group->unit);
        print_name(provider_of(group->provider));
        printf(" (%u photo%s)\n", group->photo_count, group->photo_count == 1 ? "" : "s");
    }
    print_more(count, SHOWN_ROWS, sharing->providers_path);
}

static void print_payout(const struct vw_sharing *sharing) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(sharing->amount_cents, amount);
    if (sharing->payout_count > 0)
        printf("payout of %s by %s (nothing for sums that are not positive, the others in proportion)\n", amount, sharing->method);
    for (uint32_t i = 0; i < sharing->payout_count && i < SHOWN_ROWS; i++) {
        vw_amount_to_text(sharing->payouts[i].cents, amount);
        printf("  %14s  ", amount);
        print_name(sharing->payouts[i].group->provider);
        putchar('\n');
    }
    print_more(sharing->payout_count, SHOWN_ROWS, sharing->payout_path);
}

static void print_duplicate(const struct vw_duplicate_score *row) {
    if (row->score) print_value(row->score->value, row->score->standard_error, row->score->unit);
    else printf("  validates  ");
    print_name(row->image->name);
    printf(", ");
    print_name(provider_of(row->image->provider));
    printf(", similarity %.4f\n", row->similarity);
}

static void print_duplicates(const struct vw_sharing *sharing) {
    uint32_t groups = 0;
    const struct vw_duplicate_score *rows = sharing->duplicates;
    for (uint32_t i = 0; i < sharing->duplicate_count; i++) {
        bool begins = i == 0 || rows[i].group != rows[i - 1].group;
        if (begins && ++groups <= SHOWN_GROUPS) printf("near-duplicates, together %+.4f by %s\n", rows[i].group_value, sharing->method);
        if (groups <= SHOWN_GROUPS) print_duplicate(&rows[i]);
    }
    print_more(groups, SHOWN_GROUPS, sharing->duplicates_path);
}

void vw_sharing_print(const struct vw_sharing *sharing) {
    print_providers(sharing);
    print_payout(sharing);
    print_duplicates(sharing);
}

// ---- JSON -------------------------------------------------------------------------------------------------------------

static json_t *provider_to_json(const struct vw_provider_score *group) {
    return json_pack("{s:s, s:s, s:o, s:s, s:o, s:I}", "provider", group->provider, "method", group->method, "value",
                     vw_json_real(group->value), "unit", group->unit, "stderr", vw_json_real(group->standard_error), "photos",
                     (json_int_t)group->photo_count);
}

static json_t *payout_to_json(const struct vw_payout *payout) {
    char amount[VW_AMOUNT_BYTES];
    vw_amount_to_text(payout->cents, amount);
    return json_pack("{s:s, s:o, s:s, s:I}", "provider", payout->group->provider, "share", vw_json_real(payout->share), "amount", amount,
                     "cents", (json_int_t)payout->cents);
}

static json_t *duplicate_to_json(const struct vw_duplicate_score *row) {
    return json_pack("{s:I, s:s, s:s, s:s, s:o, s:o, s:o, s:I}", "group", (json_int_t)row->group, "name", row->image->name, "split",
                     row->image->split, "provider", row->image->provider ? row->image->provider : "", "similarity",
                     vw_json_real(row->similarity), "value", vw_json_real(row->score ? row->score->value : NAN), "group_value",
                     vw_json_real(row->group_value), "providers", (json_int_t)row->provider_count);
}

bool vw_sharing_add_json(const struct vw_sharing *sharing, json_t *root) {
    json_t *providers = json_array(), *payout = json_array(), *duplicates = json_array();
    int failed = 0;
    for (uint32_t i = 0; i < sharing->group_count; i++) failed |= json_array_append_new(providers, provider_to_json(&sharing->groups[i]));
    for (uint32_t i = 0; i < sharing->payout_count; i++) failed |= json_array_append_new(payout, payout_to_json(&sharing->payouts[i]));
    for (uint32_t i = 0; i < sharing->duplicate_count; i++)
        failed |= json_array_append_new(duplicates, duplicate_to_json(&sharing->duplicates[i]));
    failed |= json_object_set_new(root, "providers", providers);
    failed |= json_object_set_new(root, "duplicates", duplicates);
    if (sharing->payout_count > 0) failed |= json_object_set_new(root, "payout", payout);
    else json_decref(payout);
    return !failed;
}

#include "experiment/verified_candidates.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "viewworth/log.h"

static const struct {
    const char *name, *method; // method NULL: several
    enum vw_selection_rule rule;
    double percent;
} rules[] = {
    {"without-outliers", NULL, VW_SELECT_OUTLIERS, 0},
    {"without-outliers:dv_psnr", "dv_psnr", VW_SELECT_OUTLIERS, 0},
    {"without-outliers:dv_loss", "dv_loss", VW_SELECT_OUTLIERS, 0},
    {"without-outliers:quality", "quality", VW_SELECT_OUTLIERS, 0},
    {"not-harmful", "dv_psnr", VW_SELECT_NOT_HARMFUL, 0},
    {"positive", "dv_psnr", VW_SELECT_POSITIVE, 0},
    {"top:90%:dv_psnr", "dv_psnr", VW_SELECT_TOP, 90},
    {"top:75%:dv_psnr", "dv_psnr", VW_SELECT_TOP, 75},
    {"top:50%:dv_psnr", "dv_psnr", VW_SELECT_TOP, 50},
    {"top:90%:quality", "quality", VW_SELECT_TOP, 90},
    {"top:75%:quality", "quality", VW_SELECT_TOP, 75},
    {"top:50%:quality", "quality", VW_SELECT_TOP, 50},
    {"without-outliers:lasting_psnr", "lasting_psnr", VW_SELECT_OUTLIERS, 0},
    {"top:90%:lasting_psnr", "lasting_psnr", VW_SELECT_TOP, 90},
    {"top:75%:lasting_psnr", "lasting_psnr", VW_SELECT_TOP, 75},
    {"top:50%:lasting_psnr", "lasting_psnr", VW_SELECT_TOP, 50},
};
_Static_assert(VW_ARRAY_COUNT(rules) + 1 < VW_CANDIDATES_MAX, "two more are all photos and the list asked for");

static bool has_method(const struct vw_scorings *scorings, const char *method) {
    bool everywhere = true;
    for (int s = 0; s < VW_SCORINGS; s++) {
        bool here = !method && scorings->score_counts[s] > 0;
        for (uint32_t i = 0; !here && method && i < scorings->score_counts[s]; i++)
            here = strcmp(scorings->scores[s][i].method, method) == 0;
        everywhere &= here;
    }
    return everywhere;
}

static void free_candidate(struct vw_candidate *candidate) {
    free(candidate->same_as);
    for (int s = 0; s < VW_SCORINGS; s++) vw_selection_free(&candidate->selections[s]);
}

// ---- All photos ----

static enum vw_status list_all(const struct vw_scorings *scorings, struct vw_selection *selection) {
    selection->image_ids = vw_allocate(scorings->image_count, sizeof *selection->image_ids);
    if (!selection->image_ids) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scorings->image_count; i++)
        if (strcmp(scorings->images[i].split, "train") == 0)
            selection->image_ids[selection->count++] = scorings->images[i].image_id;
    selection->scored_count = selection->count;
    return VW_OK;
}

static enum vw_status add_all(const struct vw_scorings *scorings, struct vw_candidates *candidates) {
    struct vw_candidate *all = &candidates->list[candidates->count++];
    enum vw_status status = VW_OK;
    *all = (struct vw_candidate){.name = "all", .method = "none"};
    for (int s = 0; !status && s < VW_SCORINGS; s++) status = list_all(scorings, &all->selections[s]);
    return status;
}

// ---- Rules ----

// Tells whether two lists, each without repetitions, have the same photos. The order differs by scoring.
static enum vw_status compare(const struct vw_selection *one, const struct vw_selection *other, bool *equal) {
    *equal = one->count == other->count;
    if (!*equal) return VW_OK;
    uint32_t *sorted = vw_allocate(2 * (size_t)one->count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    uint32_t *second = sorted + one->count;
    memcpy(sorted, one->image_ids, one->count * sizeof *sorted);
    memcpy(second, other->image_ids, one->count * sizeof *sorted);
    vw_sort_places(sorted, one->count);
    vw_sort_places(second, one->count);
    *equal = memcmp(sorted, second, one->count * sizeof *sorted) == 0;
    free(sorted);
    return VW_OK;
}

static enum vw_status note_same(struct vw_candidate *first, const char *name) {
    char *longer = vw_format_text("%s%s%s", first->same_as ? first->same_as : "", first->same_as ? ", " : "", name);
    if (!longer) return VW_ERROR_MEMORY;
    free(first->same_as);
    first->same_as = longer;
    return VW_OK;
}

// Adds the candidate, or its name to that of an equal one. Takes what it owns.
static enum vw_status add(struct vw_candidates *candidates, struct vw_candidate *made) {
    for (uint32_t c = 0; c < candidates->count; c++) {
        bool equal = true;
        for (int s = 0; equal && s < VW_SCORINGS; s++) {
            enum vw_status status = compare(&candidates->list[c].selections[s], &made->selections[s], &equal);
            if (status) return status;
        }
        if (equal) return note_same(&candidates->list[c], made->name);
    }
    candidates->list[candidates->count++] = *made;
    *made = (struct vw_candidate){0};
    return VW_OK;
}

// Applies a rule; one that keeps too few photos by some scores does not fail.
static enum vw_status apply(const struct vw_scorings *scorings, const struct vw_selection_params *params,
                            struct vw_candidate *made, bool *fits) {
    *fits = true;
    for (int s = 0; *fits && s < VW_SCORINGS; s++) {
        enum vw_status status = vw_selection_make(scorings->scores[s], scorings->score_counts[s], scorings->images,
                                                  scorings->image_count, params, &made->selections[s]);
        if (status && status != VW_ERROR_INPUT) return status;
        *fits = !status && made->selections[s].count > 1;
    }
    return VW_OK;
}

static enum vw_status add_rule(const struct vw_scorings *scorings, const char *name,
                               const struct vw_selection_params *params, struct vw_candidates *candidates) {
    struct vw_candidate made = {.name = name,
                                .method = params->method ? params->method : "train_fit, dv_psnr, dv_loss"};
    bool fits = false;
    enum vw_status status = apply(scorings, params, &made, &fits);
    if (!status && fits) status = add(candidates, &made);
    else if (!status) vw_log_info("list     %s: keeps fewer than 2 photos and is left out", name);
    free_candidate(&made);
    return status;
}

static enum vw_status add_asked(const struct vw_scorings *scorings, const struct vw_selection_params *asked,
                                const char *name, struct vw_candidates *candidates) {
    if (!has_method(scorings, asked->method))
        return vw_fail(VW_ERROR_USAGE,
                       "--verify needs scores by each half of the validation photos, and %s has none; leave --verify "
                       "out, or compare the list by viewworth compare",
                       asked->method);
    return add_rule(scorings, name, asked, candidates);
}

enum vw_status vw_candidates_make(const struct vw_scorings *scorings, const struct vw_selection_params *asked,
                                  const char *asked_name, struct vw_candidates *candidates) {
    *candidates = (struct vw_candidates){0};
    for (int s = 0; s < VW_SCORINGS; s++)
        if (!scorings->score_counts[s])
            return vw_fail(VW_ERROR_INPUT,
                           "the ledger has no scores; value the photos first, with --epochs larger than --burn-in");
    enum vw_status status = add_all(scorings, candidates);
    if (!status && asked) status = add_asked(scorings, asked, asked_name, candidates);
    for (size_t r = 0; !status && r < VW_ARRAY_COUNT(rules); r++) {
        const struct vw_selection_params params = {
            .method = rules[r].method, .rule = rules[r].rule, .amount = rules[r].percent, .percent = true};
        if (has_method(scorings, rules[r].method)) status = add_rule(scorings, rules[r].name, &params, candidates);
    }
    return status;
}

void vw_candidates_free(struct vw_candidates *candidates) {
    for (uint32_t c = 0; c < candidates->count; c++) free_candidate(&candidates->list[c]);
    candidates->count = 0;
}

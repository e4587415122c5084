// How well scores find the photos that are spoiled, and how well they come back with another seed.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "value/contest.h"
#include "viewworth/memory.h"
#include "viewworth/statistics.h"

static const char clean[] = "clean";

bool vw_photo_is_clean(const struct vw_contest *contest, uint32_t photo) { return !strcmp(contest->truths[photo], clean); }

double vw_auc(const struct vw_contest *contest, const double *scores, vw_kind_filter *counts, const void *context, uint32_t *pairs) {
    double won = 0;
    *pairs = 0;
    for (uint32_t spoiled = 0; spoiled < contest->photo_count; spoiled++) {
        if (vw_photo_is_clean(contest, spoiled) || (counts && !counts(context, contest->truths[spoiled]))) continue;
        for (uint32_t other = 0; other < contest->photo_count; other++) {
            if (!vw_photo_is_clean(contest, other)) continue;
            if (isnan(scores[other]) || isnan(scores[spoiled])) return NAN;
            won += scores[other] > scores[spoiled] ? 1 : scores[other] == scores[spoiled] ? 0.5 : 0;
            ++*pairs;
        }
    }
    return *pairs ? won / *pairs : NAN;
}

static enum vw_status add_auc(const struct vw_contest *contest, vw_kind_filter *counts, const void *context, const char *name,
                              struct vw_judgements *judgements) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < contest->contestant_count; i++) {
        const struct vw_contestant *contestant = &contest->contestants[i];
        struct vw_judgement row = {.method = contestant->name, .low = NAN, .high = NAN};
        for (uint32_t seed = 0; seed < contest->seed_count; seed++) {
            const double *scores = contestant->scores + (size_t)seed * contest->photo_count;
            row.value += vw_auc(contest, scores, counts, context, &row.count) / contest->seed_count;
        }
        status = vw_judgements_add(judgements, "auc", name, row);
    }
    return status;
}

static bool is_kind(const void *context, const char *kind) { return !strcmp(kind, context); }

// Whether no photo before this one has its truth.
static bool is_first_of_kind(const struct vw_contest *contest, uint32_t photo) {
    for (uint32_t i = 0; i < photo; i++)
        if (!strcmp(contest->truths[i], contest->truths[photo])) return false;
    return true;
}

enum vw_status vw_judge_detection(const struct vw_contest *contest, struct vw_judgements *judgements) {
    enum vw_status status = VW_OK;
    for (uint32_t photo = 0; !status && photo < contest->photo_count; photo++)
        if (!vw_photo_is_clean(contest, photo) && is_first_of_kind(contest, photo))
            status = add_auc(contest, is_kind, contest->truths[photo], contest->truths[photo], judgements);
    return status ? status : add_auc(contest, NULL, NULL, "spoiled", judgements);
}

static bool is_harmful(const void *context, const char *kind) {
    const struct vw_judgement *harm = vw_judgements_find(context, "harm", kind, "trials");
    return harm && harm->low > 0;
}

enum vw_status vw_judge_harmful(const struct vw_contest *contest, struct vw_judgements *judgements) {
    return add_auc(contest, is_harmful, judgements, "harmful", judgements);
}

// The scores of the first two seeds, of all photos or the clean ones; returns how many.
static uint32_t gather(const struct vw_contest *contest, const double *scores, bool clean_only, double *first, double *second) {
    uint32_t count = 0;
    for (uint32_t photo = 0; photo < contest->photo_count; photo++) {
        if (clean_only && !vw_photo_is_clean(contest, photo)) continue;
        first[count] = scores[photo];
        second[count++] = scores[contest->photo_count + photo];
    }
    return count;
}

enum vw_status vw_judge_seeds(const struct vw_contest *contest, struct vw_judgements *judgements) {
    if (contest->seed_count < 2) return VW_OK;
    double *first = vw_allocate(contest->photo_count, 2 * sizeof *first), *second = first ? first + contest->photo_count : NULL;
    enum vw_status status = first ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < 2 * contest->contestant_count; i++) {
        const struct vw_contestant *contestant = &contest->contestants[i / 2];
        const char *over = i % 2 ? clean : "all";
        struct vw_judgement row = {.method = contestant->name, .low = NAN, .high = NAN};
        row.count = gather(contest, contestant->scores, i % 2, first, second);
        row.value = vw_pearson(first, second, row.count);
        status = vw_judgements_add(judgements, "seed_pearson", over, row);
        if (!status && isfinite(row.value)) status = vw_spearman(first, second, row.count, &row.value);
        if (!status) status = vw_judgements_add(judgements, "seed_spearman", over, row);
    }
    free(first);
    return status;
}

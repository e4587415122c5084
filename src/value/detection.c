// How well scores find the photos that are spoiled, and how well they come back with another seed.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "value/agreement.h"
#include "value/contest.h"
#include "viewworth/memory.h"

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

static enum vw_status add_agreement(const char *method, const char *over, double pearson, double spearman, uint32_t count,
                                    struct vw_judgements *judgements) {
    struct vw_judgement row = {.method = method, .value = pearson, .low = NAN, .high = NAN, .count = count};
    enum vw_status status = vw_judgements_add(judgements, "seed_pearson", over, row);
    row.value = spearman;
    return status ? status : vw_judgements_add(judgements, "seed_spearman", over, row);
}

static enum vw_status judge_seeds_of(const struct vw_contest *contest, const struct vw_contestant *contestant, const bool *is_clean,
                                     struct vw_judgements *judgements) {
    struct vw_agreement agreement;
    const double *values = agreement.values;
    enum vw_status status =
        vw_agreement_of_pair(contestant->scores, contestant->scores + contest->photo_count, is_clean, contest->photo_count, &agreement);
    if (!status)
        status = add_agreement(contestant->name, "all", values[VW_AGREEMENT_PEARSON], values[VW_AGREEMENT_SPEARMAN], agreement.photos,
                               judgements);
    if (!status)
        status = add_agreement(contestant->name, clean, values[VW_AGREEMENT_UNSPOILED_PEARSON], values[VW_AGREEMENT_UNSPOILED_SPEARMAN],
                               agreement.unspoiled, judgements);
    return status;
}

enum vw_status vw_judge_seeds(const struct vw_contest *contest, struct vw_judgements *judgements) {
    if (contest->seed_count < 2) return VW_OK;
    bool *is_clean = vw_allocate(contest->photo_count, sizeof *is_clean);
    enum vw_status status = is_clean ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t photo = 0; !status && photo < contest->photo_count; photo++) is_clean[photo] = vw_photo_is_clean(contest, photo);
    for (uint32_t i = 0; !status && i < contest->contestant_count; i++)
        status = judge_seeds_of(contest, &contest->contestants[i], is_clean, judgements);
    free(is_clean);
    return status;
}

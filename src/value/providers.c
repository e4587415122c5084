#include "value/providers.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "viewworth/value.h"

// A score with its provider and its sort keys.
struct member {
    const char *provider;
    const struct vw_ledger_score *score;
    uint32_t place; // index of the first score of its method
};

static int compare_members(const void *left, const void *right) {
    const struct member *a = left, *b = right;
    if (a->place != b->place) return a->place < b->place ? -1 : 1;
    int order = strcmp(a->provider, b->provider);
    if (order) return order;
    return (a->score->image_id > b->score->image_id) - (a->score->image_id < b->score->image_id);
}

static enum vw_status collect(const struct vw_ledger_score *scores, uint32_t score_count,
                              const struct vw_ledger_image *images, uint32_t image_count, struct member *members) {
    for (uint32_t i = 0; i < score_count; i++) {
        const struct vw_ledger_image *image = NULL;
        enum vw_status status = vw_ledger_require_image(images, image_count, scores[i].image_id, &image);
        if (status) return vw_fail_context(status, "scores");
        bool begins = i == 0 || strcmp(scores[i].method, scores[i - 1].method) != 0;
        members[i] =
            (struct member){image->provider ? image->provider : "", &scores[i], begins ? i : members[i - 1].place};
    }
    return VW_OK;
}

static int compare_groups(const void *left, const void *right) {
    const struct vw_provider_score *a = left, *b = right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return strcmp(a->provider, b->provider);
}

static struct vw_provider_score add_up(const struct member *members, uint32_t count) {
    struct vw_provider_score group = {.provider = members[0].provider,
                                      .method = members[0].score->method,
                                      .unit = members[0].score->unit,
                                      .photo_count = count};
    double squares = 0;
    for (uint32_t i = 0; i < count; i++) {
        group.value += members[i].score->value;
        squares += members[i].score->standard_error * members[i].score->standard_error;
    }
    group.standard_error = sqrt(squares);
    return group;
}

// Returns the end of the members from `first` on that share its method and, if asked for, its provider.
static uint32_t end_of_run(const struct member *members, uint32_t count, uint32_t first, bool same_provider) {
    uint32_t end = first + 1;
    while (end < count && members[end].place == members[first].place &&
           (!same_provider || strcmp(members[end].provider, members[first].provider) == 0))
        end++;
    return end;
}

enum vw_status vw_providers_score(const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_provider_score **groups, uint32_t *group_count) {
    struct member *members = vw_allocate(score_count, sizeof *members);
    struct vw_provider_score *made = vw_allocate(score_count, sizeof *made);
    uint32_t count = 0;
    enum vw_status status =
        members && made ? collect(scores, score_count, images, image_count, members) : VW_ERROR_MEMORY;
    if (!status) qsort(members, score_count, sizeof *members, compare_members);
    for (uint32_t first = 0, end; !status && first < score_count; first = end) {
        uint32_t first_group = count;
        end = end_of_run(members, score_count, first, false);
        const struct vw_value_method *method = vw_value_method_find(members[first].score->method);
        if (!method || !method->additive) continue;
        for (uint32_t i = first, next; i < end; i = next) {
            next = end_of_run(members, end, i, true);
            made[count++] = add_up(&members[i], next - i);
        }
        qsort(&made[first_group], count - first_group, sizeof *made, compare_groups);
        for (uint32_t i = first_group; i < count; i++) made[i].rank = i - first_group + 1;
    }
    free(members);
    if (status) {
        free(made);
        return status;
    }
    *groups = made;
    *group_count = count;
    return VW_OK;
}

// ---- Near-duplicates ----

static const struct vw_ledger_score *find_score(const struct vw_ledger_score *scores, uint32_t score_count,
                                                const char *method, uint32_t image_id) {
    for (uint32_t i = 0; i < score_count; i++)
        if (scores[i].image_id == image_id && strcmp(scores[i].method, method) == 0) return &scores[i];
    return NULL;
}

static bool has_provider(const struct vw_duplicate_score *row) { return row->image->provider && *row->image->provider; }

static bool is_first_of_provider(const struct vw_duplicate_score *rows, uint32_t place) {
    for (uint32_t i = 0; i < place; i++)
        if (has_provider(&rows[i]) && strcmp(rows[i].image->provider, rows[place].image->provider) == 0) return false;
    return true;
}

// Fills the members that the rows of a group share. Returns the number of rows with a score.
static uint32_t sum_group(struct vw_duplicate_score *rows, uint32_t count) {
    struct vw_duplicate_score sum = {0};
    uint32_t scored = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (rows[i].score) sum.group_value += rows[i].score->value;
        scored += rows[i].score != NULL;
        sum.validation_count += strcmp(rows[i].image->split, "val") == 0;
        sum.provider_count += has_provider(&rows[i]) && is_first_of_provider(rows, i);
    }
    for (uint32_t i = 0; i < count; i++) {
        rows[i].group_value = sum.group_value;
        rows[i].provider_count = sum.provider_count;
        rows[i].validation_count = sum.validation_count;
    }
    return scored;
}

enum vw_status vw_duplicates_score(const struct vw_duplicate *duplicates, uint32_t duplicate_count, const char *method,
                                   const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count,
                                   struct vw_duplicate_score **rows, uint32_t *row_count) {
    uint32_t count = 0;
    struct vw_duplicate_score *made = vw_allocate(duplicate_count, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    for (uint32_t first = 0, next; first < duplicate_count; first = next) {
        struct vw_duplicate_score *group = &made[count];
        for (next = first; next < duplicate_count && duplicates[next].group == duplicates[first].group; next++) {
            const struct vw_duplicate *duplicate = &duplicates[next];
            const struct vw_ledger_image *image = NULL;
            enum vw_status status = vw_ledger_require_image(images, image_count, duplicate->view, &image);
            if (status) {
                free(made);
                return vw_fail_context(status, "near-duplicates");
            }
            group[next - first] =
                (struct vw_duplicate_score){.group = duplicate->group,
                                            .similarity = duplicate->similarity,
                                            .image = image,
                                            .score = find_score(scores, score_count, method, duplicate->view)};
        }
        if (sum_group(group, next - first) > 0) count += next - first;
    }
    *rows = made;
    *row_count = count;
    return VW_OK;
}

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "value/duplicate_scores.h"

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

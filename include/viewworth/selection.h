// Selects train photos by their scores, from ledger rows alone (no GPU).
#ifndef VIEWWORTH_SELECTION_H
#define VIEWWORTH_SELECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_selection_rule {
    VW_SELECT_POSITIVE,    // value above zero
    VW_SELECT_SIGNIFICANT, // lower end of the interval above zero; a score without an interval never is
    VW_SELECT_NOT_HARMFUL, // upper end of the interval not below zero; a score without an interval always is
    VW_SELECT_TOP,         // the best `amount`
    VW_SELECT_DROP,        // all but the worst `amount`
};

struct vw_selection_params {
    const char *method; // NULL: vw_value_default_method
    enum vw_selection_rule rule;
    double amount; // of VW_SELECT_TOP and VW_SELECT_DROP: a whole number of photos from 1 on, or a percentage, above 0
                   // and at most 100
    bool percent; // of the photos that have a score, rounded to the nearest whole number of photos; to be kept at least
                  // 1
};

struct vw_selection {
    uint32_t *image_ids;   // owned: the train photos kept, best first, ties by image_id
    uint32_t count;        // at least 1
    uint32_t scored_count; // among so many was chosen
};

// Reads "K" or "P%" into amount and percent; false for what is neither. The range is vw_selection_make's to check.
bool vw_selection_read_amount(const char *text, struct vw_selection_params *params);

// A train photo without a score of the method (NaN, or no visit that counts) is not chosen from by any rule: nothing is
// known of it. VW_ERROR_USAGE for a method without scores (the message names those that have some) and for an amount
// out of range; VW_ERROR_INPUT where there are no scores at all, where a score's image is not among the images, and
// where nothing would be selected.
enum vw_status vw_selection_make(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count,
                                 const struct vw_selection_params *params, struct vw_selection *selection);
void vw_selection_free(struct vw_selection *selection);

VW_PUBLIC_END

#endif

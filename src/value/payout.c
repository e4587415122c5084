#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "value/providers.h"
#include "value/worth.h"

// Reads digits; returns the text after them.
static const char *parse_digits(const char *text, uint64_t *number) {
    for (*number = 0; *text >= '0' && *text <= '9'; text++)
        if (*number < UINT64_MAX / 100)
            *number = *number * 10 + (uint64_t)(*text - '0'); // larger numbers are out of range anyway
    return text;
}

bool vw_payout_parse(const char *text, uint64_t *cents) {
    uint64_t whole = 0, fraction = 0;
    const char *end = parse_digits(text, &whole), *point = end;
    if (end == text || whole > VW_PAYOUT_CENTS_MAX / 100) return false;
    if (*point == '.') end = parse_digits(point + 1, &fraction);
    long digits = *point == '.' ? end - point - 1 : 0;
    if (*end || digits > 2 || (*point == '.' && digits == 0)) return false;
    *cents = 100 * whole + (digits == 1 ? 10 * fraction : fraction);
    return *cents > 0 && *cents <= VW_PAYOUT_CENTS_MAX;
}

// A provider's or a photo's claim, in whole numbers, so that nothing is rounded.
struct claim {
    double value;     // by which it is weighed
    const char *name; // by which ties are broken
    uint64_t *cents;  // the payout
    double *share;
    uint64_t weight;
    unsigned __int128 remainder; // remainder of amount * weight / sum of weights: the fraction of a cent
};

// Sorts the largest fraction first.
static int compare_claims(const void *left, const void *right) {
    const struct claim *a = left, *b = right;
    if (a->remainder != b->remainder) return a->remainder > b->remainder ? -1 : 1;
    return strcmp(a->name, b->name);
}

// Claims in units of 2^-52 of the largest; all equal if no value is positive. Returns their sum.
static unsigned __int128 weigh(struct claim *claims, uint32_t count, bool *none_positive) {
    double largest = 0;
    unsigned __int128 sum = 0; // sum of at most 2^52 each
    for (uint32_t i = 0; i < count; i++) largest = fmax(largest, claims[i].value);
    *none_positive = !(largest > 0);
    for (uint32_t i = 0; i < count; i++) {
        double value = claims[i].value;
        claims[i].weight = *none_positive ? 1 : value > 0 ? (uint64_t)llround(value / largest * 0x1p52) : 0;
        sum += claims[i].weight;
    }
    return sum;
}

static void divide(struct claim *claims, uint32_t count, uint64_t amount_cents, bool *none_positive) {
    unsigned __int128 sum = weigh(claims, count, none_positive);
    uint64_t left_cents = amount_cents;
    assert(sum > 0 || count == 0); // the largest value weighs 2^52; if none is positive, all weigh 1
    for (uint32_t i = 0; i < count; i++) {
        unsigned __int128 product = (unsigned __int128)amount_cents * claims[i].weight;
        claims[i].remainder = product % sum;
        *claims[i].cents = (uint64_t)(product / sum);
        *claims[i].share = (double)claims[i].weight / (double)sum;
        left_cents -= *claims[i].cents;
    }
    qsort(claims, count, sizeof *claims, compare_claims);
    for (uint64_t i = 0; i < left_cents; i++) ++*claims[i].cents; // there are fewer of these cents than fractions
}

// ---- Among providers ------------------------------------------------------------------------------------------------

enum vw_status vw_payout_divide(const struct vw_provider_score *groups, uint32_t group_count, const char *method,
                                uint64_t amount_cents, struct vw_payout **payouts, uint32_t *payout_count,
                                bool *none_positive) {
    uint32_t count = 0;
    struct vw_payout *made = vw_allocate(group_count, sizeof *made);
    struct claim *claims = vw_allocate(group_count, sizeof *claims);
    enum vw_status status = made && claims ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < group_count; i++) {
        if (!*groups[i].provider || strcmp(groups[i].method, method) != 0) continue;
        made[count] = (struct vw_payout){.group = &groups[i]};
        claims[count] = (struct claim){.value = groups[i].value,
                                       .name = groups[i].provider,
                                       .cents = &made[count].cents,
                                       .share = &made[count].share};
        count++;
    }
    if (!status && count == 0)
        status = vw_fail(VW_ERROR_INPUT, "no photo with a score has a provider; name them by --providers FILE.csv");
    if (!status) divide(claims, count, amount_cents, none_positive);
    free(claims);
    if (status) {
        free(made);
        return status;
    }
    *payouts = made;
    *payout_count = count;
    return VW_OK;
}

// ---- Within a provider ----------------------------------------------------------------------------------------------

const char vw_payout_split_method[] = "lasting_psnr";

// Returns the lowest score of the method, over all photos; infinite: there is none.
static double lowest_of(const struct vw_ledger_score *scores, uint32_t score_count) {
    double lowest = INFINITY;
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, vw_payout_split_method) == 0) lowest = fmin(lowest, scores[i].value);
    return lowest;
}

static bool harms(const struct vw_ledger_score *scores, uint32_t score_count, uint32_t image_id) {
    for (uint32_t i = 0; i < score_count; i++)
        if (scores[i].image_id == image_id && strcmp(scores[i].method, vw_worth_method) == 0)
            return scores[i].ci_high < 0;
    return false;
}

// Writes the claims of one provider's photos; their payouts come after `photos`.
static uint32_t claim_photos(const struct vw_payout *payout, const struct vw_payout_scores *scores, double lowest,
                             struct vw_photo_payout *photos, struct claim *claims) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scores->score_count; i++) {
        const struct vw_ledger_score *score = &scores->scores[i];
        if (strcmp(score->method, vw_payout_split_method) != 0) continue;
        const struct vw_ledger_image *image =
            vw_ledger_find_image(scores->images, scores->image_count, score->image_id);
        if (!image || !image->provider || strcmp(image->provider, payout->group->provider) != 0) continue;
        bool paid = !harms(scores->scores, scores->score_count, score->image_id);
        photos[count] = (struct vw_photo_payout){.payout = payout, .image = image, .score = score};
        claims[count] = (struct claim){.value = paid ? score->value - lowest : 0,
                                       .name = image->name,
                                       .cents = &photos[count].cents,
                                       .share = &photos[count].share};
        count++;
    }
    return count;
}

enum vw_status vw_payout_split(const struct vw_payout *payouts, uint32_t payout_count,
                               const struct vw_payout_scores *scores, struct vw_photo_payout **photos,
                               uint32_t *photo_count) {
    struct vw_photo_payout *made = vw_allocate(scores->score_count, sizeof *made);
    struct claim *claims = vw_allocate(scores->score_count, sizeof *claims);
    double lowest = lowest_of(scores->scores, scores->score_count);
    uint32_t count = 0;
    for (uint32_t i = 0; made && claims && i < payout_count; i++) {
        bool none_positive;
        uint32_t own = claim_photos(&payouts[i], scores, lowest, &made[count], claims);
        if (own) divide(claims, own, payouts[i].cents, &none_positive);
        count += own;
    }
    free(claims);
    if (!made || !claims) {
        free(made);
        return VW_ERROR_MEMORY;
    }
    *photos = made;
    *photo_count = count;
    return VW_OK;
}

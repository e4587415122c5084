#include "value/payout.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "value/evaluation/resampling.h"

static const double TAIL = 0.05;

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

// ---- Photos and their providers -------------------------------------------------------------------------------------

// Sorts photos provider by provider.
static int compare_photos(const void *left, const void *right) {
    const struct vw_photo_payout *a = left, *b = right;
    int order = strcmp(a->image->provider, b->image->provider);
    return order ? order : (a->image->image_id > b->image->image_id) - (a->image->image_id < b->image->image_id);
}

// Lists the photos that have a provider and were used, with their worths; sorted by provider.
static enum vw_status list_photos(const struct vw_worth_input *input, struct vw_payouts *made) {
    made->photos = vw_allocate(input->image_count, sizeof *made->photos);
    if (!made->photos) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const struct vw_ledger_image *image = &input->images[i];
        if (image->provider && *image->provider && strcmp(image->split, "excluded") != 0)
            made->photos[made->photo_count++] = (struct vw_photo_payout){.image = image};
    }
    for (uint32_t i = 0; i < input->score_count; i++)
        for (uint32_t k = 0; k < made->photo_count && !strcmp(input->scores[i].method, vw_worth_method); k++)
            if (made->photos[k].image->image_id == input->scores[i].image_id) made->photos[k].score = &input->scores[i];
    qsort(made->photos, made->photo_count, sizeof *made->photos, compare_photos);
    return VW_OK;
}

// Makes a row per provider, and leaves only photos with a worth in the list.
static enum vw_status list_providers(struct vw_payouts *made) {
    uint32_t scored = 0;
    made->providers = vw_allocate(made->photo_count, sizeof *made->providers);
    if (!made->providers) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < made->photo_count; i++) {
        const struct vw_photo_payout photo = made->photos[i];
        struct vw_payout *last = made->provider_count ? &made->providers[made->provider_count - 1] : NULL;
        if (!last || strcmp(last->provider, photo.image->provider) != 0) {
            last = &made->providers[made->provider_count++];
            *last = (struct vw_payout){.provider = photo.image->provider, .first_photo = scored};
        }
        last->photo_count += photo.score != NULL;
        last->unvalued_count += photo.score == NULL;
        last->value += photo.score ? fmax(photo.score->value, 0) : 0;
        if (photo.score) made->photos[scored++] = photo;
    }
    made->photo_count = scored;
    if (scored) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "no photo that has a worth has a provider; name them by --providers FILE.csv");
}

// ---- Shares ---------------------------------------------------------------------------------------------------------

// A photo's claim, in whole numbers, so that nothing is rounded.
struct claim {
    struct vw_photo_payout *photo;
    uint64_t weight;             // in units of 2^-52 of the largest worth
    unsigned __int128 remainder; // remainder of amount * weight / sum of weights: the fraction of a cent
};

// Sorts the largest fraction first.
static int compare_claims(const void *left, const void *right) {
    const struct claim *a = left, *b = right;
    if (a->remainder != b->remainder) return a->remainder > b->remainder ? -1 : 1;
    return strcmp(a->photo->image->name, b->photo->image->name);
}

static void divide(struct vw_payouts *made, struct claim *claims) {
    uint32_t count = made->photo_count;
    uint64_t left_cents = made->amount_cents;
    unsigned __int128 sum = 0; // sum of at most 2^52 each
    double largest = 0;
    for (uint32_t i = 0; i < count; i++) largest = fmax(largest, made->photos[i].score->value);
    if (!(largest > 0)) return; // no one is paid
    for (uint32_t i = 0; i < count; i++) {
        double share = fmax(made->photos[i].score->value, 0) / largest;
        claims[i] = (struct claim){.photo = &made->photos[i], .weight = (uint64_t)llround(share * 0x1p52)};
        sum += claims[i].weight;
    }
    for (uint32_t i = 0; i < count; i++) {
        unsigned __int128 product = (unsigned __int128)made->amount_cents * claims[i].weight;
        claims[i].remainder = product % sum;
        claims[i].photo->cents = (uint64_t)(product / sum);
        claims[i].photo->share = (double)claims[i].weight / (double)sum;
        left_cents -= claims[i].photo->cents;
    }
    qsort(claims, count, sizeof *claims, compare_claims);
    assert(left_cents <= count); // there are fewer of these cents than fractions
    for (uint64_t i = 0; i < left_cents; i++) claims[i].photo->cents++;
}

// ---- Intervals ------------------------------------------------------------------------------------------------------

// Scales the worths of a draw so that the positive ones add up to the amount. NaN makes NaN of all.
static void pay_draw(const uint32_t *places, uint32_t count, double amount, double *drawn) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += drawn[places[i]] <= 0 ? 0 : drawn[places[i]]; // NaN stays
    for (uint32_t i = 0; i < count; i++)
        drawn[places[i]] = sum == 0 ? 0 : isnan(sum) ? NAN : fmax(drawn[places[i]], 0) / sum * amount;
}

static struct vw_payout_interval interval_of(double *drawn, uint64_t cents) {
    if (!vw_all_finite(drawn, VW_RESAMPLES)) return (struct vw_payout_interval){NAN, NAN};
    vw_sort(drawn, VW_RESAMPLES);
    return (struct vw_payout_interval){fmin((double)cents, vw_quantile_of_sorted(drawn, VW_RESAMPLES, TAIL)),
                                       fmax((double)cents, vw_quantile_of_sorted(drawn, VW_RESAMPLES, 1 - TAIL))};
}

// Sums up what a provider's photos get: draws[draw][image].
static void add_up(const struct vw_worth_input *input, const double *draws, struct vw_payouts *made,
                   struct vw_payout *payout) {
    double of_photo[VW_RESAMPLES], of_provider[VW_RESAMPLES] = {0};
    for (uint32_t i = 0; i < payout->photo_count; i++) {
        struct vw_photo_payout *photo = &made->photos[payout->first_photo + i];
        const double *column = draws + (photo->image - input->images);
        for (size_t r = 0; r < VW_RESAMPLES; r++) of_provider[r] += of_photo[r] = column[r * input->image_count];
        photo->interval = interval_of(of_photo, photo->cents);
        payout->share += photo->share;
        payout->cents += photo->cents;
    }
    payout->interval = interval_of(of_provider, payout->cents);
}

static enum vw_status pay(const struct vw_worth_input *input, double *draws, struct vw_payouts *made) {
    struct claim *claims = vw_allocate(made->photo_count, sizeof *claims);
    uint32_t *places = vw_allocate(made->photo_count, sizeof *places);
    bool paid = claims && places;
    if (paid) {
        divide(made, claims);
        for (uint32_t i = 0; i < made->photo_count; i++) places[i] = (uint32_t)(made->photos[i].image - input->images);
        vw_sort_places(places, made->photo_count); // no provider's name decides an order of sums
        for (size_t r = 0; r < VW_RESAMPLES; r++)
            pay_draw(places, made->photo_count, (double)made->amount_cents, draws + r * input->image_count);
        for (uint32_t p = 0; p < made->provider_count; p++) add_up(input, draws, made, &made->providers[p]);
    }
    free(claims);
    free(places);
    return paid ? VW_OK : VW_ERROR_MEMORY;
}

// ---- Who is paid ----------------------------------------------------------------------------------------------------

// Returns whether some two photos are told apart. Never by their providers: names decide nothing about a payment.
// Unknown intervals overlap all.
static bool tell_apart(const struct vw_payouts *made) {
    double highest_low = -INFINITY, lowest_high = INFINITY;
    for (uint32_t i = 0; i < made->photo_count; i++) {
        const struct vw_payout_interval *interval = &made->photos[i].interval;
        if (!isfinite(interval->low_cents) || !isfinite(interval->high_cents)) return false;
        highest_low = fmax(highest_low, interval->low_cents);
        lowest_high = fmin(lowest_high, interval->high_cents);
    }
    return highest_low > lowest_high;
}

// Sorts the best paid first.
static int compare_payouts(const void *left, const void *right) {
    const struct vw_payout *a = left, *b = right;
    if (a->cents != b->cents) return a->cents > b->cents ? -1 : 1;
    if (!a->photo_count != !b->photo_count) return a->photo_count ? -1 : 1;
    return strcmp(a->provider, b->provider);
}

enum vw_status vw_payouts_divide(const struct vw_worth_input *input, double *draws, struct vw_payouts *payouts) {
    enum vw_status status = list_photos(input, payouts);
    if (!status) status = list_providers(payouts);
    if (!status) status = pay(input, draws, payouts);
    if (status) return status;
    qsort(payouts->providers, payouts->provider_count, sizeof *payouts->providers, compare_payouts);
    payouts->outcome = !tell_apart(payouts)           ? VW_PAYOUT_NOT_TOLD_APART
                       : !payouts->providers[0].cents ? VW_PAYOUT_NONE_POSITIVE
                                                      : VW_PAYOUT_PAID;
    return VW_OK;
}

enum vw_status vw_payouts_make(const struct vw_worth_input *input, uint64_t amount_cents, struct vw_payouts *payouts) {
    bool valued = false;
    *payouts = (struct vw_payouts){
        .outcome = VW_PAYOUT_UNKNOWN_WORTH, .amount_cents = amount_cents, .retraining_count = input->retraining_count};
    for (uint32_t i = 0; i < input->score_count; i++) valued |= !strcmp(input->scores[i].method, vw_worth_method);
    if (!valued) return VW_OK;
    double *draws = vw_allocate(VW_RESAMPLES, input->image_count * sizeof *draws);
    enum vw_status status = draws ? vw_worth_draw(input, draws) : VW_ERROR_MEMORY;
    if (!status) status = vw_payouts_divide(input, draws, payouts);
    free(draws);
    return status;
}

void vw_payouts_free(struct vw_payouts *payouts) {
    free(payouts->providers);
    free(payouts->photos);
    *payouts = (struct vw_payouts){0};
}

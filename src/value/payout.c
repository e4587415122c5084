#include "value/payout.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"
#include "value/evaluation/resampling.h"

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
    if (order) return order;
    return (a->image->image_id > b->image->image_id) - (a->image->image_id < b->image->image_id);
}

// Notes the score of each image, NULL: none.
static void find_scores(const struct vw_payout_input *input, const struct vw_ledger_score **of_images) {
    const struct vw_worth_input *of = &input->of;
    for (uint32_t i = 0; i < of->score_count; i++) {
        if (strcmp(of->scores[i].method, input->method) != 0) continue;
        const struct vw_ledger_image *image = vw_ledger_find_image(of->images, of->image_count, of->scores[i].image_id);
        if (image) of_images[image - of->images] = &of->scores[i];
    }
}

// Lists the photos that have a provider and were used, with their scores; sorted by provider.
static enum vw_status list_photos(const struct vw_payout_input *input, struct vw_payouts *made) {
    const struct vw_worth_input *of = &input->of;
    const struct vw_ledger_score **scores = vw_allocate(of->image_count, sizeof *scores);
    made->photos = vw_allocate(of->image_count, sizeof *made->photos);
    if (!scores || !made->photos) {
        free(scores);
        return VW_ERROR_MEMORY;
    }
    find_scores(input, scores);
    for (uint32_t i = 0; i < of->image_count; i++) {
        const struct vw_ledger_image *image = &of->images[i];
        if (image->provider && *image->provider && strcmp(image->split, "excluded") != 0)
            made->photos[made->photo_count++] = (struct vw_photo_payout){.image = image, .score = scores[i]};
    }
    free(scores);
    qsort(made->photos, made->photo_count, sizeof *made->photos, compare_photos);
    return VW_OK;
}

static void count_photo(const struct vw_photo_payout *photo, struct vw_payout *payout) {
    const char *split = photo->image->split;
    if (photo->score) {
        payout->photo_count++;
        payout->value += photo->score->value > 0 ? photo->score->value : 0;
    } else if (strcmp(split, "val") == 0) payout->validating_count++;
    else if (strcmp(split, "test") == 0) payout->test_count++;
    else payout->unscored_count++;
}

// Makes a row per provider, and leaves only photos with a score in the list.
static enum vw_status list_providers(struct vw_payouts *made) {
    uint32_t scored = 0;
    made->providers = vw_allocate(made->photo_count, sizeof *made->providers);
    if (!made->providers) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < made->photo_count; i++) {
        const struct vw_photo_payout *photo = &made->photos[i];
        struct vw_payout *last = made->provider_count ? &made->providers[made->provider_count - 1] : NULL;
        if (!last || strcmp(last->provider, photo->image->provider) != 0) {
            last = &made->providers[made->provider_count++];
            *last = (struct vw_payout){.provider = photo->image->provider, .first_photo = scored};
        }
        count_photo(photo, last);
        if (photo->score) made->photos[scored++] = *photo;
    }
    made->photo_count = scored;
    if (!scored)
        return vw_fail(VW_ERROR_INPUT, "no photo with a score has a provider; name them by --providers FILE.csv");
    return VW_OK;
}

// ---- Shares ---------------------------------------------------------------------------------------------------------

// A photo's claim, in whole numbers, so that nothing is rounded.
struct claim {
    struct vw_photo_payout *photo;
    uint64_t weight;
    unsigned __int128 remainder; // remainder of amount * weight / sum of weights: the fraction of a cent
};

// Sorts the largest fraction first.
static int compare_claims(const void *left, const void *right) {
    const struct claim *a = left, *b = right;
    if (a->remainder != b->remainder) return a->remainder > b->remainder ? -1 : 1;
    return strcmp(a->photo->image->name, b->photo->image->name);
}

// Weighs photos in units of 2^-52 of the largest score. Returns the sum.
static unsigned __int128 weigh(struct vw_payouts *made, bool floor_equal, struct claim *claims) {
    double largest = 0;
    unsigned __int128 sum = 0; // sum of at most 2^52 each
    for (uint32_t i = 0; i < made->photo_count; i++) largest = fmax(largest, made->photos[i].score->value);
    made->none_positive = !(largest > 0);
    for (uint32_t i = 0; i < made->photo_count; i++) {
        double value = made->photos[i].score->value;
        uint64_t weight = value > 0 ? (uint64_t)llround(value / largest * 0x1p52) : 0;
        claims[i] = (struct claim){.photo = &made->photos[i], .weight = made->none_positive ? floor_equal : weight};
        sum += claims[i].weight;
    }
    return sum;
}

static void divide(struct claim *claims, uint32_t count, unsigned __int128 sum, uint64_t amount_cents) {
    uint64_t left_cents = amount_cents;
    if (sum == 0) return; // no one is paid
    for (uint32_t i = 0; i < count; i++) {
        unsigned __int128 product = (unsigned __int128)amount_cents * claims[i].weight;
        claims[i].remainder = product % sum;
        claims[i].photo->cents = (uint64_t)(product / sum);
        claims[i].photo->share = (double)claims[i].weight / (double)sum;
        left_cents -= claims[i].photo->cents;
    }
    qsort(claims, count, sizeof *claims, compare_claims);
    assert(left_cents <= count); // there are fewer of these cents than fractions
    for (uint64_t i = 0; i < left_cents; i++) claims[i].photo->cents++;
}

static enum vw_status pay(const struct vw_payout_input *input, struct vw_payouts *made) {
    struct claim *claims = vw_allocate(made->photo_count, sizeof *claims);
    if (!claims) return VW_ERROR_MEMORY;
    divide(claims, made->photo_count, weigh(made, input->floor_equal, claims), input->amount_cents);
    free(claims);
    for (uint32_t p = 0; p < made->provider_count; p++) {
        struct vw_payout *payout = &made->providers[p];
        for (uint32_t i = 0; i < payout->photo_count; i++) {
            payout->share += made->photos[payout->first_photo + i].share;
            payout->cents += made->photos[payout->first_photo + i].cents;
        }
    }
    return VW_OK;
}

// ---- Intervals ------------------------------------------------------------------------------------------------------

static const double TAIL = 0.05;

// Lists which images are paid for, ascending, so that no provider's name decides an order of sums.
static enum vw_status list_places(const struct vw_payout_input *input, const struct vw_payouts *made,
                                  uint32_t **places) {
    *places = vw_allocate(made->photo_count, sizeof **places);
    if (!*places) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < made->photo_count; i++)
        (*places)[i] = (uint32_t)(made->photos[i].image - input->of.images);
    vw_sort_places(*places, made->photo_count);
    return VW_OK;
}

// Draws scores within their standard errors, as vw_worth_draw() draws worths together: draws[draw][image].
static void draw_scores(const struct vw_payout_input *input, const struct vw_payouts *made, double *draws) {
    for (size_t r = 0; r < VW_RESAMPLES; r++)
        for (uint32_t i = 0; i < made->photo_count; i++) {
            uint32_t place = (uint32_t)(made->photos[i].image - input->of.images);
            const struct vw_ledger_score *score = made->photos[i].score;
            draws[r * input->of.image_count + place] =
                score->value + score->standard_error * vw_resampling_normal((uint32_t)r, place);
        }
}

// Scales a draw so that its positive scores add up to the amount. Where none is positive, each gets `floor`. A score
// without an error makes NaN of all.
static void pay_draw(const uint32_t *places, uint32_t count, double amount, double floor, double *drawn) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += drawn[places[i]] <= 0 ? 0 : drawn[places[i]]; // NaN stays
    for (uint32_t i = 0; i < count; i++) {
        double *value = &drawn[places[i]];
        *value = sum == 0 ? floor : isnan(sum) ? NAN : fmax(*value, 0) / sum * amount;
    }
}

static enum vw_status pay_draws(const struct vw_payout_input *input, const struct vw_payouts *made, double *draws) {
    uint32_t *places = NULL, count = made->photo_count;
    double amount = (double)input->amount_cents, floor = made->none_positive && input->floor_equal ? amount / count : 0;
    enum vw_status status = list_places(input, made, &places);
    for (size_t r = 0; !status && r < VW_RESAMPLES; r++)
        pay_draw(places, count, amount, floor, draws + r * input->of.image_count);
    free(places);
    return status;
}

static struct vw_payout_interval interval_of(double *drawn, uint64_t cents) {
    struct vw_payout_interval interval = {NAN, NAN};
    if (!vw_all_finite(drawn, VW_RESAMPLES)) return interval;
    vw_sort(drawn, VW_RESAMPLES);
    interval.low_cents = fmin((double)cents, vw_quantile_of_sorted(drawn, VW_RESAMPLES, TAIL));
    interval.high_cents = fmax((double)cents, vw_quantile_of_sorted(drawn, VW_RESAMPLES, 1 - TAIL));
    return interval;
}

static void take_intervals(const struct vw_payout_input *input, const double *draws, struct vw_payouts *made) {
    double of_photo[VW_RESAMPLES], of_provider[VW_RESAMPLES];
    for (uint32_t p = 0; p < made->provider_count; p++) {
        struct vw_payout *payout = &made->providers[p];
        for (size_t r = 0; r < VW_RESAMPLES; r++) of_provider[r] = 0;
        for (uint32_t i = 0; i < payout->photo_count; i++) {
            struct vw_photo_payout *photo = &made->photos[payout->first_photo + i];
            const double *column = draws + (photo->image - input->of.images);
            for (size_t r = 0; r < VW_RESAMPLES; r++) of_provider[r] += of_photo[r] = column[r * input->of.image_count];
            photo->interval = interval_of(of_photo, photo->cents);
        }
        payout->interval = interval_of(of_provider, payout->cents);
    }
}

static enum vw_status find_intervals(const struct vw_payout_input *input, struct vw_payouts *made) {
    double *draws = vw_allocate(VW_RESAMPLES, input->of.image_count * sizeof *draws);
    if (!draws) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (strcmp(input->method, vw_worth_method) == 0) status = vw_worth_draw(&input->of, draws);
    else draw_scores(input, made, draws);
    if (!status) status = pay_draws(input, made, draws);
    if (!status) take_intervals(input, draws, made);
    free(draws);
    return status;
}

// ---- Who is told apart ----------------------------------------------------------------------------------------------

// Sorts the best paid first.
static int compare_payouts(const void *left, const void *right) {
    const struct vw_payout *a = left, *b = right;
    if (a->cents != b->cents) return a->cents > b->cents ? -1 : 1;
    if (!a->photo_count != !b->photo_count) return a->photo_count ? -1 : 1;
    return strcmp(a->provider, b->provider);
}

// Estimates how many times the retrainings would part two photos, whose intervals shrink by the root of their number.
static double times_to_part(const struct vw_photo_payout *more, const struct vw_photo_payout *less) {
    double gap = (double)more->cents - (double)less->cents;
    double width = (double)more->cents - more->interval.low_cents + less->interval.high_cents - (double)less->cents;
    return gap > 0 ? pow(width / gap, 2) : INFINITY;
}

// Returns whether a photo is paid more than another one; equal ones by their ID, which no name changes.
static bool is_paid_more(const struct vw_photo_payout *a, const struct vw_photo_payout *b) {
    return a->cents != b->cents ? a->cents > b->cents : a->image->image_id < b->image->image_id;
}

// Compares every photo with the best and the worst paid one. More retrainings than were made are enough, and no more
// than the photos to train on have subsets.
static uint32_t find_enough(const struct vw_payout_input *input, const struct vw_payouts *made) {
    enum { MOST = 100000 };
    const struct vw_photo_payout *best = made->photos, *worst = made->photos;
    uint32_t training = 0;
    double times = INFINITY;
    for (uint32_t i = 0; i < made->photo_count; i++) {
        if (is_paid_more(&made->photos[i], best)) best = &made->photos[i];
        if (is_paid_more(worst, &made->photos[i])) worst = &made->photos[i];
    }
    for (uint32_t i = 0; i < made->photo_count; i++)
        times = fmin(times, fmin(times_to_part(best, &made->photos[i]), times_to_part(&made->photos[i], worst)));
    for (uint32_t i = 0; i < input->of.image_count; i++) training += !strcmp(input->of.images[i].split, "train");
    double enough = VW_WORTH_REPEAT_EVERY *
                    ceil(fmax(times * made->retraining_count, made->retraining_count + 1.) / VW_WORTH_REPEAT_EVERY);
    return enough <= fmin(MOST, vw_worth_count_possible(training)) ? (uint32_t)enough : 0;
}

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

// Counts the sorted values below `limit`.
static uint32_t count_below(const double *sorted, uint32_t count, double limit) {
    uint32_t below = 0, end = count;
    while (below < end) {
        uint32_t middle = below + (end - below) / 2;
        if (sorted[middle] < limit) below = middle + 1;
        else end = middle;
    }
    return below;
}

// Counts the intervals that each one overlaps, by their sorted ends. Unknown intervals overlap all.
static void count_alike(struct vw_payouts *made, uint32_t scored, double *lows, double *highs) {
    bool known = true;
    for (uint32_t i = 0; i < scored; i++) {
        lows[i] = -made->providers[i].interval.low_cents; // so that those above an end are below its negative
        highs[i] = made->providers[i].interval.high_cents;
        known = known && isfinite(lows[i]) && isfinite(highs[i]);
    }
    if (known) vw_sort(lows, scored), vw_sort(highs, scored);
    for (uint32_t i = 0; i < scored; i++) {
        struct vw_payout *payout = &made->providers[i];
        payout->alike_count = scored - 1;
        if (!known) continue;
        payout->alike_count -= count_below(highs, scored, payout->interval.low_cents);
        payout->alike_count -= count_below(lows, scored, -payout->interval.high_cents);
    }
}

static enum vw_status compare_providers(const struct vw_payout_input *input, struct vw_payouts *made) {
    uint32_t scored = 0;
    while (scored < made->provider_count && made->providers[scored].photo_count) scored++;
    double *ends = vw_allocate(scored, 2 * sizeof *ends);
    if (!ends) return VW_ERROR_MEMORY;
    count_alike(made, scored, ends, ends + scored);
    made->told_apart = tell_apart(made);
    if (!made->told_apart) made->enough_retrainings = find_enough(input, made);
    free(ends);
    return VW_OK;
}

// Puts providers in order, and their photos in the same order.
static enum vw_status sort_payouts(struct vw_payouts *made) {
    struct vw_photo_payout *photos = vw_allocate(made->photo_count, sizeof *photos);
    uint32_t count = 0;
    if (!photos) return VW_ERROR_MEMORY;
    qsort(made->providers, made->provider_count, sizeof *made->providers, compare_payouts);
    for (uint32_t p = 0; p < made->provider_count; p++) {
        struct vw_payout *payout = &made->providers[p];
        memcpy(photos + count, made->photos + payout->first_photo, payout->photo_count * sizeof *photos);
        payout->first_photo = count;
        payout->method = made->photos[0].score->method; // there is one at least
        payout->unit = made->photos[0].score->unit;
        count += payout->photo_count;
    }
    free(made->photos);
    made->photos = photos;
    return VW_OK;
}

// ---- All of it ------------------------------------------------------------------------------------------------------

enum vw_status vw_payouts_make(const struct vw_payout_input *input, struct vw_payouts *payouts) {
    *payouts = (struct vw_payouts){.retraining_count = input->of.retraining_count};
    enum vw_status status = list_photos(input, payouts);
    if (!status) status = list_providers(payouts);
    if (!status) status = pay(input, payouts);
    if (!status) status = find_intervals(input, payouts);
    if (!status) status = sort_payouts(payouts);
    return status ? status : compare_providers(input, payouts);
}

void vw_payouts_free(struct vw_payouts *payouts) {
    free(payouts->providers);
    free(payouts->photos);
    *payouts = (struct vw_payouts){0};
}

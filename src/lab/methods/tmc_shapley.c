// Truncated Monte Carlo Data Shapley (Ghorbani and Zou, ICML 2019): in random orders, what adding a photo to those
// before it changes of the validation PSNR of training on them.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "lab/methods/registry.h"

// Truncation: after more than TRUNCATING prefixes in a row within TOLERANCE_DB of training on all photos, the others of
// the order count as 0. Prefixes are trained LOOK_AHEAD at a time: those of a group after the truncation are trained in
// vain.
enum { TRUNCATING = 5, LOOK_AHEAD = 16 };
// About the noise of a training. Not a share of the PSNR, as in the paper's code, since PSNR has no zero.
static const double TOLERANCE_DB = 0.1;
// Convergence: orders end once the scores of each of the last SETTLED orders differ from the last ones by less than
// ERROR of them, on average over the photos. At least SETTLED orders are used.
enum { SETTLED = 100 };
static const double ERROR = 0.1;

struct orders {
    const struct vw_retraining_input *input;
    uint32_t left;    // retrainings that the budget still permits
    double all_psnr;  // PSNR of training on all photos, from the first order
    uint32_t *order;  // owned; [photo]: places of photos
    uint32_t *views;  // owned; [LOOK_AHEAD][photo]
    double *sums;     // owned; [photo]: of what it changed
    uint32_t *counts; // owned; [photo]: orders that reached it
    double *settled;  // owned; [SETTLED][photo]: scores after the last orders, at order % SETTLED
};

static uint32_t least_budget(const struct vw_retraining_input *input) { return input->photo_count; }

static double score_of(const struct orders *orders, uint32_t photo) {
    return orders->counts[photo] ? orders->sums[photo] / orders->counts[photo] : NAN;
}

// Returns a training on the first `size` photos of the order.
static struct vw_retrain_params prefix(const struct orders *orders, uint32_t size, uint64_t seed, uint32_t *views) {
    for (uint32_t i = 0; i < size; i++) views[i] = orders->input->photos[orders->order[i]];
    vw_sort_places(views, size);
    return (struct vw_retrain_params){.views = views, .view_count = size, .seed = seed};
}

// Trains on prefixes first + 1 ... first + count.
static enum vw_status train(struct orders *orders, uint32_t first, uint32_t count, uint64_t seed, double *psnr_db) {
    const struct vw_retraining_input *input = orders->input;
    struct vw_retrain_params retrainings[LOOK_AHEAD];
    struct vw_retrain_result results[LOOK_AHEAD];
    for (uint32_t i = 0; i < count; i++)
        retrainings[i] = prefix(orders, first + 1 + i, seed, orders->views + (size_t)i * input->photo_count);
    enum vw_status status = input->retrain(input->context, retrainings, count, results);
    for (uint32_t i = 0; !status && i < count; i++) psnr_db[i] = results[i].val_psnr;
    return status;
}

// Adds a change of PSNR to the photo at `place`. A training without a value changes neither of its neighbours.
static void add_change(struct orders *orders, uint32_t place, double change) {
    if (!isfinite(change)) return;
    orders->sums[orders->order[place]] += change;
    orders->counts[orders->order[place]]++;
}

// Trains along an order. The first one is not truncated, since the others compare with its end. An order that the
// budget ends counts up to that place.
static enum vw_status walk(struct orders *orders, uint32_t number) {
    const struct vw_retraining_input *input = orders->input;
    uint64_t seed = input->first_seed + number;
    uint32_t photos = input->photo_count, near_all = 0;
    double psnr_db[LOOK_AHEAD], before = NAN;
    vw_random_order(input->key, number, photos, orders->order);
    struct vw_retrain_result untrained;
    enum vw_status status = input->retrain(input->context, &(struct vw_retrain_params){.seed = seed}, 1, &untrained);
    if (!status) before = untrained.val_psnr;
    for (uint32_t place = 0; !status && place < photos && orders->left > 0;) {
        uint32_t count = photos - place < LOOK_AHEAD ? photos - place : LOOK_AHEAD;
        if (count > orders->left) count = orders->left;
        orders->left -= count;
        status = train(orders, place, count, seed, psnr_db);
        for (uint32_t i = 0; !status && i < count; i++, place++) {
            bool truncated = near_all > TRUNCATING;
            add_change(orders, place, truncated ? 0 : psnr_db[i] - before);
            before = psnr_db[i];
            if (number > 0 && !truncated) near_all = fabs(before - orders->all_psnr) <= TOLERANCE_DB ? near_all + 1 : 0;
        }
        if (near_all <= TRUNCATING) continue;
        for (; place < photos; place++) add_change(orders, place, 0);
    }
    if (number == 0) orders->all_psnr = before;
    return status;
}

// Keeps the scores after an order, and compares them with those of the orders before it.
static bool has_settled(struct orders *orders, uint32_t number) {
    uint32_t photos = orders->input->photo_count;
    double largest = 0;
    for (uint32_t i = 0; i < photos; i++)
        orders->settled[(size_t)(number % SETTLED) * photos + i] = score_of(orders, i);
    for (uint32_t row = 0; row < SETTLED; row++) {
        double error = 0;
        for (uint32_t i = 0; i < photos; i++)
            error += fabs(orders->settled[(size_t)row * photos + i] - score_of(orders, i)) /
                     (fabs(score_of(orders, i)) + 1e-12) / photos;
        if (!isfinite(error)) return false; // a photo without a change yet
        largest = fmax(largest, error);
    }
    return number + 1 >= SETTLED && largest < ERROR;
}

static enum vw_status allocate(const struct vw_retraining_input *input, struct orders *orders) {
    size_t photos = input->photo_count;
    *orders = (struct orders){.input = input,
                              .left = input->budget,
                              .all_psnr = NAN,
                              .order = vw_allocate(photos, sizeof *orders->order),
                              .views = vw_allocate(LOOK_AHEAD * photos, sizeof *orders->views),
                              .sums = vw_allocate(photos, sizeof *orders->sums),
                              .counts = vw_allocate(photos, sizeof *orders->counts),
                              .settled = vw_allocate(SETTLED * photos, sizeof *orders->settled)};
    return orders->order && orders->views && orders->sums && orders->counts && orders->settled ? VW_OK
                                                                                               : VW_ERROR_MEMORY;
}

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    struct orders orders;
    bool settled = false;
    enum vw_status status = allocate(input, &orders);
    for (uint32_t number = 0; !status && !settled && orders.left > 0; number++) {
        status = walk(&orders, number);
        settled = !status && has_settled(&orders, number);
    }
    for (uint32_t i = 0; !status && i < input->photo_count; i++) scores[i] = score_of(&orders, i);
    free(orders.order);
    free(orders.views);
    free(orders.sums);
    free(orders.counts);
    free(orders.settled);
    return status;
}

const struct vw_retraining_method vw_tmc_shapley = {
    .name = "tmc_shapley",
    .meaning = "what adding the photo to those before it changes, mean over random orders",
    .has_sign = true,
    .estimates = VW_EXACT_SHAPLEY,
    .least_budget = least_budget,
    .score = score,
};

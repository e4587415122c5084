#include "value/evaluation/worth_regression.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "value/evaluation/resampling.h"

static const uint64_t FOLD_SEED = 0x666f6c6473; // used by no training
// Penalties of the players, per subset: 1e-8, 4e-8, ... 10.7 for sums; 1e-4, 2.5e-4, ... 93 for means, which few
// subsets would otherwise fit without an error. The ratios multiply them for B; the last leaves B without a prior.
enum { PENALTIES = 16, RATIOS = 4, FITS = PENALTIES * RATIOS };
static const double least_penalty[] = {1e-8, 1e-4}, penalty_factor[] = {4, 2.5}; // by form
static const double ratios[RATIOS] = {1e-4, 1e-2, 1, 1e6};
static const double SAME_DIRECTION = 1e-18; // limit for squared lengths
static const double GUARD = 1e-9;           // penalty of the size, so that a fit of subsets of one size has a solution

// Columns of a subset: 1, its size, the features of the players summed as the players are, and the players, whose
// coefficients are per photo. The outcome does not change when these grow by the same number, so that their mean is
// free, and the penalty pulls them to their own mean.
enum { CONSTANT, SIZE, FIRST_FEATURE };

struct regression {
    const struct vw_worth_params *params;
    struct vw_outcomes outcomes; // less their mean, `centre`
    double centre;
    uint32_t columns, first_player;
    uint32_t *folds;          // [subset kept]
    double *rows;             // [subset kept][column]
    double *basis;            // [column from first_player on][player]; NULL: these columns are the players
    double *contrasts;        // [player][column]: the row of all players less that without this one
    double *unseen;           // [player]: squared length of what the contrast has outside the basis
    double *gram, *moments;   // sums over subsets: [column][column], of which the lower half counts, and [column]
    double squares;           // sum over the outcomes
    uint32_t used;            // subsets in these sums
    double *factor, *scratch; // Cholesky's; one row, also of all players
    double *pulled;           // [column]: `moments` and what pulls B to what is expected
    double *solutions;        // [fit][column]
    double errors[FITS], weights[FITS];
    double *variances;   // [fit][player], of the worths
    double noises[FITS]; // variance of an outcome, dB^2
};

// ---- Rows ----

// Makes the row of the subset whose players have `in`; scratch of the caller.
static void make_row(const struct regression *regression, const bool *in, double *row) {
    const struct vw_worth_params *params = regression->params;
    uint32_t players = params->subsets->photo_count;
    double of_subset = 0;
    for (uint32_t i = 0; i < players; i++) of_subset += in[i];
    double share = of_subset / players;
    bool mean = params->form == VW_WORTH_MEAN;
    row[CONSTANT] = 1;
    row[SIZE] = mean ? log(share) : share - 0.5;
    for (uint32_t i = 0; i < players; i++)
        row[regression->first_player + i] = mean ? (in[i] ? 1 / share : 0) - 1 : (in[i] ? 1 : 0) - share;
    for (uint32_t f = 0; f < params->feature_count; f++) {
        row[FIRST_FEATURE + f] = 0;
        for (uint32_t i = 0; i < players; i++)
            row[FIRST_FEATURE + f] += params->features[(size_t)f * players + i] * row[regression->first_player + i];
    }
}

static void mark(const struct vw_subsets *subsets, uint32_t subset, bool *in) {
    memset(in, 0, subsets->photo_count * sizeof *in);
    for (uint32_t j = subsets->offsets[subset]; j < subsets->offsets[subset + 1]; j++) in[subsets->places[j]] = true;
}

static enum vw_status make_rows(struct regression *regression) {
    const struct vw_subsets *subsets = regression->params->subsets;
    bool *in = vw_allocate(subsets->photo_count, sizeof *in);
    if (!in) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < regression->outcomes.count; i++) {
        mark(subsets, regression->outcomes.kept[i], in);
        make_row(regression, in, regression->rows + (size_t)i * regression->columns);
    }
    free(in);
    return VW_OK;
}

// Writes the columns of a row of all players (`scratch`), and returns the squared length of what the basis lacks of it.
static double take_row(const struct regression *regression, double *row) {
    uint32_t first = regression->first_player, players = regression->params->subsets->photo_count;
    const double *of_players = regression->scratch + first;
    uint32_t copied = regression->basis ? first : regression->columns;
    memcpy(row, regression->scratch, copied * sizeof *row);
    if (!regression->basis) return 0;
    double seen = 0;
    for (uint32_t k = first; k < regression->columns; k++) {
        row[k] = vw_dot(of_players, regression->basis + (size_t)(k - first) * players, players);
        seen += row[k] * row[k];
    }
    return fmax(vw_dot(of_players, of_players, players) - seen, 0);
}

// Orthonormalises by Gram and Schmidt, twice because of rounding. Returns the number of directions.
static uint32_t find_basis(const struct regression *regression, double *basis) {
    uint32_t players = regression->params->subsets->photo_count, rank = 0;
    for (uint32_t i = 0; i < regression->outcomes.count; i++) {
        double *next = basis + (size_t)rank * players;
        memcpy(next, regression->rows + (size_t)i * regression->columns + regression->first_player,
               players * sizeof *next);
        double whole = vw_dot(next, next, players);
        for (uint32_t k = 0; k < 2 * rank; k++) {
            const double *other = basis + (size_t)(k % rank) * players;
            double share = vw_dot(next, other, players);
            for (uint32_t j = 0; j < players; j++) next[j] -= share * other[j];
        }
        double left = vw_dot(next, next, players);
        if (!(left > SAME_DIRECTION * whole)) continue;
        for (uint32_t j = 0; j < players; j++) next[j] /= sqrt(left);
        rank++;
    }
    return rank;
}

// Chooses a basis of the subsets if there are fewer subsets than players. The penalty is the same in every direction,
// so that the fit in this basis is the fit of the players, with as many columns as there are subsets.
static enum vw_status choose_columns(struct regression *regression) {
    uint32_t players = regression->params->subsets->photo_count, count = regression->outcomes.count,
             all = regression->columns;
    if (players <= count) return VW_OK;
    double *basis = vw_allocate(count, players * sizeof *basis);
    if (!basis) return VW_ERROR_MEMORY;
    regression->columns = regression->first_player + find_basis(regression, basis);
    regression->basis = basis;
    for (uint32_t i = 0; i < count; i++) {
        memcpy(regression->scratch, regression->rows + (size_t)i * all, all * sizeof *regression->scratch);
        take_row(regression, regression->rows + (size_t)i * regression->columns);
    }
    return VW_OK;
}

static enum vw_status make_contrasts(struct regression *regression) {
    uint32_t players = regression->params->subsets->photo_count, all = regression->first_player + players;
    bool *in = vw_allocate(players, sizeof *in);
    double *whole = vw_allocate(all, sizeof *whole);
    enum vw_status status = in && whole ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < players; i++) in[i] = true;
    if (!status) make_row(regression, in, whole);
    for (uint32_t i = 0; !status && i < players && players > 1; i++) {
        in[i] = false;
        make_row(regression, in, regression->scratch);
        in[i] = true;
        for (uint32_t j = 0; j < all; j++) regression->scratch[j] = whole[j] - regression->scratch[j];
        regression->unseen[i] = take_row(regression, regression->contrasts + (size_t)i * regression->columns);
    }
    free(in);
    free(whole);
    return status;
}

// ---- Least squares ----

static void clear_sums(struct regression *regression) {
    memset(regression->gram, 0, (size_t)regression->columns * (regression->columns + 1) * sizeof *regression->gram);
    regression->squares = 0;
    regression->used = 0;
}

static void add_subset(struct regression *regression, uint32_t kept, uint32_t times) {
    uint32_t columns = regression->columns;
    const double *row = regression->rows + (size_t)kept * columns, outcome = regression->outcomes.means[kept];
    for (uint32_t i = 0; i < columns; i++) {
        for (uint32_t j = 0; j <= i; j++) regression->gram[(size_t)i * columns + j] += times * row[i] * row[j];
        regression->moments[i] += times * row[i] * outcome;
    }
    regression->squares += times * outcome * outcome;
    regression->used += times;
}

static double penalty_of(const struct regression *regression, uint32_t fit, uint32_t column) {
    enum vw_worth_form form = regression->params->form;
    double penalty = least_penalty[form] * pow(penalty_factor[form], fit / RATIOS) * regression->used;
    return column >= regression->first_player ? penalty
           : column >= FIRST_FEATURE          ? penalty * ratios[fit % RATIOS]
           : column == SIZE                   ? GUARD * regression->gram[0]
                                              : 0;
}

static double expected_of(const struct regression *regression, uint32_t column) {
    const double *expected = regression->params->expected;
    return expected && column >= FIRST_FEATURE && column < regression->first_player ? expected[column - FIRST_FEATURE]
                                                                                    : 0;
}

// Computes Cholesky's factor of the penalised matrix, and its right-hand side. False if it is singular.
static bool factorise(struct regression *regression, uint32_t fit) {
    uint32_t columns = regression->columns;
    double *factor = regression->factor;
    for (uint32_t i = 0; i < columns; i++)
        regression->pulled[i] = regression->moments[i] + penalty_of(regression, fit, i) * expected_of(regression, i);
    for (uint32_t i = 0; i < columns; i++)
        for (uint32_t j = 0; j <= i; j++) {
            double sum = regression->gram[(size_t)i * columns + j] + (i == j ? penalty_of(regression, fit, i) : 0);
            for (uint32_t k = 0; k < j; k++) sum -= factor[(size_t)i * columns + k] * factor[(size_t)j * columns + k];
            if (i == j && !(sum > 0)) return false;
            factor[(size_t)i * columns + j] = i == j ? sqrt(sum) : sum / factor[(size_t)j * columns + j];
        }
    return true;
}

// Solves factor x = from, from the first column on; `columns` of them.
static void solve_forward(const struct regression *regression, const double *from, uint32_t columns, double *x) {
    for (uint32_t i = 0; i < columns; i++) {
        const double *row = regression->factor + (size_t)i * regression->columns;
        double sum = from[i];
        for (uint32_t k = 0; k < i; k++) sum -= row[k] * x[k];
        x[i] = sum / row[i];
    }
}

// Solves for the coefficients of the first `columns`, a separate problem with the same factor.
static void solve(const struct regression *regression, uint32_t columns, double *solution) {
    solve_forward(regression, regression->pulled, columns, solution);
    for (uint32_t i = columns; i-- > 0;) {
        double sum = solution[i];
        for (uint32_t k = i + 1; k < columns; k++)
            sum -= regression->factor[(size_t)k * regression->columns + i] * solution[k];
        solution[i] = sum / regression->factor[(size_t)i * regression->columns + i];
    }
}

// Returns x' (X'X + penalties)^-1 x.
static double leverage(const struct regression *regression, const double *x) {
    solve_forward(regression, x, regression->columns, regression->scratch);
    return vw_dot(regression->scratch, regression->scratch, regression->columns);
}

// ---- Fits of all penalties ----

// Sums the squared errors of the subsets outside the fold `unseen`, each by the fit without it.
static double left_out_error(const struct regression *regression, uint32_t unseen, const double *solution) {
    double sum = 0;
    for (uint32_t i = 0; i < regression->outcomes.count; i++) {
        if (regression->folds[i] == unseen) continue;
        const double *row = regression->rows + (size_t)i * regression->columns;
        double error = regression->outcomes.means[i] - vw_dot(row, solution, regression->columns);
        sum += pow(error / fmax(1 - leverage(regression, row), 1e-9), 2);
    }
    return sum;
}

static void find_variances(struct regression *regression, uint32_t fit, const double *solution, double *variances) {
    double rest = regression->squares - vw_dot(regression->pulled, solution, regression->columns);
    for (uint32_t i = 0; i < regression->columns; i++)
        rest += penalty_of(regression, fit, i) * pow(expected_of(regression, i), 2);
    double noise = fmax(rest, 0) / fmax(regression->used - 2.0, 1); // the penalty counts as a prior's part
    double penalty = penalty_of(regression, fit, regression->first_player);
    regression->noises[fit] = noise;
    for (uint32_t i = 0; i < regression->params->subsets->photo_count; i++)
        variances[i] = noise * (leverage(regression, regression->contrasts + (size_t)i * regression->columns) +
                                regression->unseen[i] / penalty); // no subset tells anything about these
}

static void weigh_fits(struct regression *regression) {
    double least = INFINITY, sum = 0;
    for (uint32_t fit = 0; fit < FITS; fit++) least = fmin(least, regression->errors[fit]);
    for (uint32_t fit = 0; fit < FITS; fit++) {
        double error = regression->errors[fit];
        regression->weights[fit] = error == least    ? 1
                                   : isfinite(error) ? exp(-0.5 * regression->used * log(error / least))
                                                     : 0;
        sum += regression->weights[fit];
    }
    for (uint32_t fit = 0; fit < FITS; fit++) regression->weights[fit] /= sum;
}

// Fits the subsets outside the fold `unseen` (VW_WORTH_FOLDS: all) with every penalty, and weighs the fits.
static void fit_all(struct regression *regression, uint32_t unseen) {
    uint32_t players = regression->params->subsets->photo_count;
    clear_sums(regression);
    for (uint32_t i = 0; i < regression->outcomes.count; i++)
        if (regression->folds[i] != unseen) add_subset(regression, i, 1);
    for (uint32_t fit = 0; fit < FITS; fit++) {
        double *solution = regression->solutions + (size_t)fit * regression->columns;
        bool idle = !regression->params->feature_count && fit % RATIOS; // it would be the fit before
        regression->errors[fit] = INFINITY;
        if (idle || !factorise(regression, fit)) continue;
        solve(regression, regression->columns, solution);
        regression->errors[fit] = left_out_error(regression, unseen, solution);
        if (unseen == VW_WORTH_FOLDS)
            find_variances(regression, fit, solution, regression->variances + (size_t)fit * players);
    }
    weigh_fits(regression);
}

static double average(const struct regression *regression, const double *row) {
    double sum = 0;
    for (uint32_t fit = 0; fit < FITS; fit++)
        if (regression->weights[fit] > 0)
            sum += regression->weights[fit] *
                   vw_dot(row, regression->solutions + (size_t)fit * regression->columns, regression->columns);
    return sum;
}

// ---- Predictions ----

static void predict_left_out(struct regression *regression, struct vw_worths *worths) {
    double of_size[FIRST_FEATURE];
    for (uint32_t fold = 0; fold < VW_WORTH_FOLDS; fold++) {
        fit_all(regression, fold);
        solve(regression, FIRST_FEATURE, of_size); // no penalty changes that part of the factor
        for (uint32_t i = 0; i < regression->outcomes.count; i++) {
            if (regression->folds[i] != fold) continue;
            const double *row = regression->rows + (size_t)i * regression->columns;
            uint32_t subset = regression->outcomes.kept[i];
            worths->predicted[subset] = regression->centre + average(regression, row);
            worths->by_size[subset] = regression->centre + vw_dot(row, of_size, FIRST_FEATURE);
        }
    }
}

static enum vw_status compare_left_out(const struct regression *regression, struct vw_worths *worths) {
    const struct vw_outcomes *outcomes = &regression->outcomes;
    double *predicted = vw_allocate(outcomes->count, sizeof *predicted), error = 0;
    if (!predicted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < outcomes->count; i++) {
        predicted[i] = worths->predicted[outcomes->kept[i]] - regression->centre;
        error += pow(predicted[i] - outcomes->means[i], 2);
    }
    double total = vw_dot(outcomes->means, outcomes->means, outcomes->count);
    worths->pearson = vw_pearson(predicted, outcomes->means, outcomes->count);
    worths->r2 = total > 0 ? 1 - error / total : NAN;
    free(predicted);
    return VW_OK;
}

// ---- Worths ----

static void take_worths(struct regression *regression, struct vw_worths *worths) {
    uint32_t players = worths->photo_count;
    double quantile = vw_student_quantile(fmax(regression->used - 2.0, 1));
    for (uint32_t i = 0; i < players; i++) {
        const double *contrast = regression->contrasts + (size_t)i * regression->columns;
        double value = average(regression, contrast), variance = 0;
        for (uint32_t fit = 0; fit < FITS; fit++) {
            if (!(regression->weights[fit] > 0)) continue;
            const double *solution = regression->solutions + (size_t)fit * regression->columns;
            variance += regression->weights[fit] * (regression->variances[(size_t)fit * players + i] +
                                                    pow(vw_dot(contrast, solution, regression->columns) - value, 2));
        }
        worths->values[i] = value;
        worths->standard_errors[i] = sqrt(variance);
        worths->ci_low[i] = value - quantile * sqrt(variance);
        worths->ci_high[i] = value + quantile * sqrt(variance);
    }
}

// Resamples with the penalty of the least error over all subsets, which is not chosen anew.
static enum vw_status resample(struct regression *regression, struct vw_worths *worths) {
    uint32_t players = worths->photo_count, count = regression->outcomes.count, best = 0;
    uint16_t *times = vw_resamples_draw(count);
    if (!times) return VW_ERROR_MEMORY;
    for (uint32_t fit = 1; fit < FITS; fit++)
        if (regression->errors[fit] < regression->errors[best]) best = fit;
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) {
        clear_sums(regression);
        for (uint32_t i = 0; i < count; i++)
            if (times[(size_t)r * count + i]) add_subset(regression, i, times[(size_t)r * count + i]);
        if (!factorise(regression, best)) continue;
        solve(regression, regression->columns, regression->solutions);
        for (uint32_t i = 0; i < players; i++)
            worths->resampled[(size_t)r * players + i] = vw_dot(regression->contrasts + (size_t)i * regression->columns,
                                                                regression->solutions, regression->columns);
    }
    free(times);
    return VW_OK;
}

// ---- Draws ----

// Chooses a fit by its weight.
static uint32_t draw_fit(const struct regression *regression, uint32_t draw) {
    double left = vw_resampling_unit(draw, 0);
    uint32_t fit = 0;
    while (fit + 1 < FITS && left >= regression->weights[fit]) left -= regression->weights[fit++];
    while (fit && !(regression->weights[fit] > 0)) fit--; // rounding led past the last
    return fit;
}

// Returns a factor that turns normal draws into Student's, the same for all players of a draw: the noise is estimated.
static double draw_scale(const struct regression *regression, uint32_t draw) {
    uint32_t degrees = regression->used > 3 ? regression->used - 2 : 1;
    double squares = 0;
    for (uint32_t i = 0; i < degrees; i++) squares += pow(vw_resampling_normal(draw, UINT32_MAX / 4 - i), 2);
    return sqrt(degrees / squares);
}

// Adds to each player's worth what no subset tells: normal directions outside the basis, `spread` dB wide. A contrast
// is c_i (own share) less a_i of every other player; it is read off the form here, since its row is not kept.
static void add_unseen(const struct regression *regression, double spread, double *directions, double *worths) {
    const struct vw_worth_params *params = regression->params;
    uint32_t players = params->subsets->photo_count, first = regression->first_player;
    for (uint32_t k = first; k < regression->columns; k++) {
        const double *basis = regression->basis + (size_t)(k - first) * players;
        double share = vw_dot(directions, basis, players);
        for (uint32_t j = 0; j < players; j++) directions[j] -= share * basis[j];
    }
    double sum = 0, share = (players - 1.) / players; // all players but one
    bool mean = params->form == VW_WORTH_MEAN;
    for (uint32_t j = 0; j < players; j++) sum += directions[j];
    for (uint32_t i = 0; i < players; i++) {
        double own = directions[i];
        worths[i] += spread * ((mean ? 1 : share) * own - (mean ? 1 / share - 1 : 1 - share) * (sum - own));
    }
}

// Solves factor' x = x, in place.
static void solve_backward(const struct regression *regression, double *x) {
    for (uint32_t i = regression->columns; i-- > 0;) {
        for (uint32_t k = i + 1; k < regression->columns; k++)
            x[i] -= regression->factor[(size_t)k * regression->columns + i] * x[k];
        x[i] /= regression->factor[(size_t)i * regression->columns + i];
    }
}

// Draws the worths of all players together by one fit, whose factor is there.
static void draw_once(const struct regression *regression, uint32_t fit, uint32_t draw, double *coefficients,
                      double *directions, double *worths) {
    uint32_t players = regression->params->subsets->photo_count;
    const double *solution = regression->solutions + (size_t)fit * regression->columns;
    double scale = draw_scale(regression, draw) * sqrt(regression->noises[fit]);
    for (uint32_t k = 0; k < regression->columns; k++) coefficients[k] = vw_resampling_normal(draw, 1 + k);
    solve_backward(regression, coefficients);
    for (uint32_t k = 0; k < regression->columns; k++) coefficients[k] = solution[k] + scale * coefficients[k];
    for (uint32_t i = 0; i < players; i++)
        worths[i] = vw_dot(regression->contrasts + (size_t)i * regression->columns, coefficients, regression->columns);
    if (!regression->basis) return;
    for (uint32_t j = 0; j < players; j++) directions[j] = vw_resampling_normal(draw, 1 + regression->columns + j);
    add_unseen(regression, scale / sqrt(penalty_of(regression, fit, regression->first_player)), directions, worths);
}

static enum vw_status draw_worths(struct regression *regression, struct vw_worths *worths) {
    uint32_t players = worths->photo_count;
    double *coefficients = vw_allocate(regression->columns, sizeof *coefficients);
    double *directions = vw_allocate(players, sizeof *directions);
    enum vw_status status = coefficients && directions ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t fit = 0; !status && fit < FITS; fit++) {
        if (!(regression->weights[fit] > 0) || !factorise(regression, fit)) continue;
        for (uint32_t draw = 0; draw < VW_RESAMPLES; draw++)
            if (draw_fit(regression, draw) == fit)
                draw_once(regression, fit, draw, coefficients, directions, worths->drawn + (size_t)draw * players);
    }
    free(coefficients);
    free(directions);
    return status;
}

// ---- All of it ----

static enum vw_status allocate_rows(struct regression *regression) {
    size_t columns = regression->columns, players = regression->params->subsets->photo_count;
    regression->folds = vw_allocate(regression->outcomes.count, sizeof *regression->folds);
    regression->rows = vw_allocate(regression->outcomes.count, columns * sizeof *regression->rows);
    regression->scratch = vw_allocate(columns, sizeof *regression->scratch);
    regression->unseen = vw_allocate(players, sizeof *regression->unseen);
    bool enough = regression->folds && regression->rows && regression->scratch && regression->unseen;
    return enough ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status allocate_fits(struct regression *regression) {
    size_t columns = regression->columns, players = regression->params->subsets->photo_count;
    regression->contrasts = vw_allocate(players, columns * sizeof *regression->contrasts);
    regression->gram = vw_allocate(columns, (columns + 1) * sizeof *regression->gram);
    regression->factor = vw_allocate(columns, columns * sizeof *regression->factor);
    regression->pulled = vw_allocate(columns, sizeof *regression->pulled);
    regression->solutions = vw_allocate(FITS, columns * sizeof *regression->solutions);
    regression->variances = vw_allocate(FITS, players * sizeof *regression->variances);
    if (!regression->contrasts || !regression->gram || !regression->factor || !regression->pulled ||
        !regression->solutions || !regression->variances)
        return VW_ERROR_MEMORY;
    regression->moments = regression->gram + columns * columns;
    return VW_OK;
}

// Takes the mean off the outcomes, and deals the subsets to random folds of equal sizes.
static void centre_and_divide(struct regression *regression) {
    uint32_t count = regression->outcomes.count;
    for (uint32_t i = 0; i < count; i++) regression->centre += regression->outcomes.means[i] / count;
    for (uint32_t i = 0; i < count; i++) regression->outcomes.means[i] -= regression->centre;
    vw_random_order(FOLD_SEED, 0, count, regression->folds);
    for (uint32_t i = 0; i < count; i++) regression->folds[i] %= VW_WORTH_FOLDS;
}

static enum vw_status open_regression(const struct vw_worth_params *params, struct regression *regression) {
    const struct vw_subsets *subsets = params->subsets;
    *regression = (struct regression){.params = params,
                                      .first_player = FIRST_FEATURE + params->feature_count,
                                      .columns = FIRST_FEATURE + params->feature_count + subsets->photo_count};
    enum vw_status status = vw_outcomes_of_subsets(subsets, (struct vw_subset_range){0, subsets->count},
                                                   params->outcome, &regression->outcomes);
    if (!status) status = allocate_rows(regression);
    if (!status) status = make_rows(regression);
    if (!status) status = choose_columns(regression);
    if (!status) status = allocate_fits(regression);
    if (!status) status = make_contrasts(regression);
    if (!status) centre_and_divide(regression);
    return status;
}

static void close_regression(struct regression *regression) {
    vw_outcomes_free(&regression->outcomes);
    free(regression->folds);
    free(regression->rows);
    free(regression->basis);
    free(regression->contrasts);
    free(regression->unseen);
    free(regression->gram);
    free(regression->factor);
    free(regression->scratch);
    free(regression->pulled);
    free(regression->solutions);
    free(regression->variances);
}

static enum vw_status open_worths(const struct vw_worth_params *params, struct vw_worths *worths) {
    size_t players = params->subsets->photo_count, subsets = params->subsets->count;
    size_t resampled = params->resample ? (1 + (size_t)VW_RESAMPLES) * players : 0;
    size_t drawn = params->draw ? (size_t)VW_RESAMPLES * players : 0;
    *worths = (struct vw_worths){.photo_count = params->subsets->photo_count, .pearson = NAN, .r2 = NAN};
    worths->values = vw_allocate(players, 4 * sizeof *worths->values);
    worths->predicted = vw_allocate(subsets, 2 * sizeof *worths->predicted);
    if (resampled) worths->resampled = vw_allocate(resampled, sizeof *worths->resampled);
    if (drawn) worths->drawn = vw_allocate(drawn, sizeof *worths->drawn);
    if (!worths->values || !worths->predicted || (resampled && !worths->resampled) || (drawn && !worths->drawn))
        return VW_ERROR_MEMORY;
    worths->ci_low = worths->values + players;
    worths->ci_high = worths->ci_low + players;
    worths->standard_errors = worths->ci_high + players;
    worths->by_size = worths->predicted + subsets;
    for (size_t i = 0; i < 4 * players; i++) worths->values[i] = NAN;
    for (size_t i = 0; i < resampled; i++) worths->resampled[i] = NAN;
    for (size_t i = 0; i < drawn; i++) worths->drawn[i] = NAN;
    for (size_t i = 0; i < 2 * subsets; i++) worths->predicted[i] = NAN;
    return VW_OK;
}

enum vw_status vw_worths_fit(const struct vw_worth_params *params, struct vw_worths *worths) {
    struct regression regression = {0};
    enum vw_status status = open_worths(params, worths);
    if (!status) status = open_regression(params, &regression);
    if (!status && regression.outcomes.count >= VW_WORTH_FOLDS) {
        worths->count = regression.outcomes.count;
        if (params->predict) predict_left_out(&regression, worths);
        if (params->predict) status = compare_left_out(&regression, worths);
        if (!status) fit_all(&regression, VW_WORTH_FOLDS);
        if (!status) take_worths(&regression, worths);
        if (!status && params->draw) status = draw_worths(&regression, worths); // before resample() takes the sums
        if (!status && params->resample) status = resample(&regression, worths);
    }
    close_regression(&regression);
    return status;
}

void vw_worths_free(struct vw_worths *worths) {
    free(worths->values);
    free(worths->resampled);
    free(worths->drawn);
    free(worths->predicted);
}

#include "value/worth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "value/evaluation/outcomes.h"
#include "value/evaluation/resampling.h"
#include "viewworth/value.h"

const char vw_worth_method[] = "worth_psnr";
const char *const vw_worth_prior_methods[VW_WORTH_PRIORS] = {"lasting_psnr", "dv_psnr", "lasting_loss", "dv_loss",
                                                             "quality"};
static const double FEATURE_MOST = 3; // standard deviations: an outlier's score does not measure its worth

bool vw_worth_is_of_all(uint32_t number) { return number % VW_WORTH_REPEAT_EVERY == 0; }

uint32_t vw_worth_place(uint32_t number) { return number - number / VW_WORTH_REPEAT_EVERY - 1; }

// ---- The game: photos that train are its players --------------------------------------------------------------------

struct game {
    uint32_t *players; // owned; [image]: its player; NO_PLAYER: it does not train
    uint32_t player_count;
    struct vw_subsets subsets;
    double *features;                 // owned; [feature][player]
    double expected[VW_WORTH_PRIORS]; // [feature], dB
    uint32_t feature_count;
    const char *feature_methods[VW_WORTH_PRIORS];
};
enum { NO_PLAYER = UINT32_MAX };

static enum vw_status open_game(const struct vw_worth_input *input, struct game *game) {
    *game = (struct game){.players = vw_allocate(input->image_count, sizeof *game->players)};
    if (!game->players) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++)
        game->players[i] = strcmp(input->images[i].split, "train") != 0 ? (uint32_t)NO_PLAYER : game->player_count++;
    return VW_OK;
}

static void close_game(struct game *game) {
    vw_subsets_free(&game->subsets);
    free(game->players);
    free(game->features);
}

static uint32_t player_of(const struct vw_worth_input *input, const struct game *game, uint32_t image_id) {
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, image_id);
    return image ? game->players[image - input->images] : (uint32_t)NO_PLAYER;
}

// Adds a retraining as a subset, its players ascending.
static void add_subset(const struct vw_worth_input *input, const struct vw_ledger_retraining *retraining, bool *is_in,
                       struct game *game) {
    struct vw_subsets *subsets = &game->subsets;
    uint32_t end = subsets->offsets[subsets->count];
    memset(is_in, 0, game->player_count * sizeof *is_in);
    for (uint32_t i = 0; i < retraining->image_count; i++) {
        uint32_t player = player_of(input, game, retraining->image_ids[i]);
        if (player != NO_PLAYER) is_in[player] = true;
    }
    for (uint32_t i = 0; i < game->player_count; i++)
        if (is_in[i]) subsets->places[end++] = i;
    subsets->results[subsets->count] = (struct vw_retrain_result){.val_psnr = retraining->val_psnr};
    subsets->offsets[++subsets->count] = end;
}

static enum vw_status list_subsets(const struct vw_worth_input *input, struct game *game) {
    struct vw_subsets *subsets = &game->subsets;
    bool *is_in = vw_allocate(game->player_count, sizeof *is_in);
    *subsets = (struct vw_subsets){.photo_count = game->player_count, .seed_count = 1};
    subsets->offsets = vw_allocate((size_t)input->retraining_count + 1, sizeof *subsets->offsets);
    subsets->places = vw_allocate(input->retraining_count, game->player_count * sizeof *subsets->places);
    subsets->results = vw_allocate(input->retraining_count, sizeof *subsets->results);
    bool enough = is_in && subsets->offsets && subsets->places && subsets->results;
    for (uint32_t i = 0; enough && i < input->retraining_count; i++)
        add_subset(input, &input->retrainings[i], is_in, game);
    free(is_in);
    return enough ? VW_OK : VW_ERROR_MEMORY;
}

// ---- The prior -----------------------------------------------------------------------------------------------------

// Reads the scores of all players; false if one has none.
static bool read_scores(const struct vw_worth_input *input, const struct game *game, const char *method,
                        double *values) {
    uint32_t found = 0;
    for (uint32_t i = 0; i < game->player_count; i++) values[i] = 0;
    for (uint32_t i = 0; i < input->score_count; i++) {
        const struct vw_ledger_score *score = &input->scores[i];
        if (strcmp(score->method, method) != 0 || !score->visits || !isfinite(score->value)) continue;
        uint32_t player = player_of(input, game, score->image_id);
        if (player == NO_PLAYER) continue;
        values[player] = score->value;
        found++;
    }
    return found == game->player_count;
}

// Scales to mean 0 and variance 1 over the photos, with limits; false if they do not vary. `*deviation` is the divisor.
static bool standardise(const struct game *game, double *values, double *deviation) {
    double mean = 0, variance = 0, rest = 0;
    for (uint32_t i = 0; i < game->player_count; i++) mean += values[i] / game->player_count;
    for (uint32_t i = 0; i < game->player_count; i++) variance += pow(values[i] - mean, 2) / game->player_count;
    if (!(variance > 0) || !isfinite(variance)) return false;
    *deviation = sqrt(variance);
    for (uint32_t i = 0; i < game->player_count; i++) {
        values[i] = fmax(-FEATURE_MOST, fmin(FEATURE_MOST, (values[i] - mean) / sqrt(variance)));
        rest += values[i] / game->player_count;
    }
    for (uint32_t i = 0; i < game->player_count; i++) values[i] -= rest;
    return true;
}

// Lists the features. Lasting credit, which predicts in dB, enters as it is; the others are scaled by any factor, 0 if
// they show no effect.
static enum vw_status list_features(const struct vw_worth_input *input, struct game *game) {
    game->features = vw_allocate(VW_WORTH_PRIORS, game->player_count * sizeof *game->features);
    if (!game->features) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < VW_WORTH_PRIORS; i++) {
        const char *method = vw_worth_prior_methods[i];
        double *values = game->features + (size_t)game->feature_count * game->player_count;
        double deviation = 0;
        if (!read_scores(input, game, method, values) || !standardise(game, values, &deviation)) continue;
        game->expected[game->feature_count] = i == 0 ? deviation : 0;
        game->feature_methods[game->feature_count++] = method;
    }
    return VW_OK;
}

const char *vw_worth_first_prior(const struct vw_ledger_score *scores, uint32_t score_count) {
    for (uint32_t m = 0; m < VW_WORTH_PRIORS; m++)
        for (uint32_t i = 0; i < score_count; i++)
            if (strcmp(scores[i].method, vw_worth_prior_methods[m]) == 0) return vw_worth_prior_methods[m];
    return NULL;
}

// ---- Fits ----------------------------------------------------------------------------------------------------------

enum asked { ASK_WORTHS, ASK_PREDICTIONS, ASK_DRAWS };

static struct vw_worth_params params_of(const struct game *game, enum asked asked) {
    return (struct vw_worth_params){.subsets = &game->subsets,
                                    .outcome = VW_OUTCOME_VAL_PSNR,
                                    .form = VW_WORTH_MEAN,
                                    .features = game->features,
                                    .expected = game->expected,
                                    .feature_count = game->feature_count,
                                    .predict = asked == ASK_PREDICTIONS,
                                    .draw = asked == ASK_DRAWS};
}

static enum vw_status fit(const struct vw_worth_input *input, enum asked asked, struct game *game,
                          struct vw_worths *worths) {
    *worths = (struct vw_worths){0};
    enum vw_status status = open_game(input, game);
    if (status || game->player_count < 2) return status;
    status = list_subsets(input, game);
    if (!status) status = list_features(input, game);
    const struct vw_worth_params params = params_of(game, asked);
    return status ? status : vw_worths_fit(&params, worths);
}

static uint32_t count_trainings(const struct game *game, uint32_t player) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < game->subsets.offsets[game->subsets.count]; i++)
        count += game->subsets.places[i] == player;
    return count;
}

// Finds the ranks that a photo may have: after all whose intervals lie above its own, before all whose lie below.
static void rank(const struct vw_worths *worths, uint32_t player, struct vw_ledger_score *score) {
    score->rank_ci_low = 1;
    score->rank_ci_high = worths->photo_count;
    for (uint32_t i = 0; i < worths->photo_count; i++) {
        score->rank_ci_low += worths->ci_low[i] > worths->ci_high[player];
        score->rank_ci_high -= worths->ci_high[i] < worths->ci_low[player];
    }
}

enum vw_status vw_worth_append(const struct vw_worth_input *input, struct vw_ledger_score *scores,
                               uint32_t *score_count) {
    struct game game;
    struct vw_worths worths;
    enum vw_status status = fit(input, ASK_WORTHS, &game, &worths);
    for (uint32_t i = 0; !status && worths.count && i < input->image_count; i++) {
        uint32_t player = game.players[i];
        if (player == NO_PLAYER) continue;
        struct vw_ledger_score *score = &scores[(*score_count)++];
        *score = (struct vw_ledger_score){.image_id = input->images[i].image_id,
                                          .method = vw_worth_method,
                                          .value = worths.values[player],
                                          .unit = "dB",
                                          .standard_error = worths.standard_errors[player],
                                          .visits = count_trainings(&game, player),
                                          .ci_low = worths.ci_low[player],
                                          .ci_high = worths.ci_high[player]};
        rank(&worths, player, score);
    }
    vw_worths_free(&worths);
    close_game(&game);
    return status;
}

// ---- Draws ---------------------------------------------------------------------------------------------------------

enum vw_status vw_worth_draw(const struct vw_worth_input *input, double *draws) {
    struct game game;
    struct vw_worths worths;
    enum vw_status status = fit(input, ASK_DRAWS, &game, &worths);
    for (size_t r = 0; !status && r < VW_RESAMPLES; r++)
        for (uint32_t i = 0; i < input->image_count; i++) {
            bool known = worths.count && game.players[i] != NO_PLAYER;
            draws[r * input->image_count + i] = known ? worths.drawn[r * worths.photo_count + game.players[i]] : NAN;
        }
    vw_worths_free(&worths);
    close_game(&game);
    return status;
}

// ---- Accuracy ------------------------------------------------------------------------------------------------------

static void measure_noise(const struct vw_worth_input *input, uint32_t photo_count, struct vw_worth_summary *summary) {
    double mean = 0, squares = 0;
    uint32_t valued = 0;
    for (uint32_t pass = 0; pass < 2; pass++)
        for (uint32_t i = 0; i < input->retraining_count; i++) {
            const struct vw_ledger_retraining *retraining = &input->retrainings[i];
            if (retraining->image_count != photo_count || !isfinite(retraining->val_psnr)) continue;
            if (pass) squares += pow(retraining->val_psnr - mean / valued, 2);
            else mean += retraining->val_psnr, valued++;
        }
    summary->repeat_count = valued;
    summary->noise_db = valued > 1 ? sqrt(squares / (valued - 1)) : NAN;
}

static enum vw_status claim(const struct vw_worth_params *params, const struct vw_worths *worths,
                            const struct game *game, struct vw_worth_summary *summary) {
    struct vw_worth_claim *claims = summary->claims;
    claims[0].method = vw_worth_method;
    enum vw_status status = vw_worths_accuracy(params, worths, &claims[0].accuracy);
    for (uint32_t i = 0; !status && i < game->feature_count; i++) {
        claims[1 + i].method = game->feature_methods[i];
        status = vw_worths_score_accuracy(params, worths, game->features + (size_t)i * game->player_count,
                                          &claims[1 + i].accuracy);
    }
    summary->claim_count = 1 + game->feature_count;
    double left = claims[0].accuracy.variance - summary->noise_db * summary->noise_db;
    summary->ceiling = left > 0 ? sqrt(left / claims[0].accuracy.variance) : isnan(left) ? NAN : 0;
    return status;
}

enum vw_status vw_worth_summarise(const struct vw_worth_input *input, struct vw_worth_summary *summary) {
    struct game game;
    struct vw_worths worths;
    *summary = (struct vw_worth_summary){
        .retraining_count = input->retraining_count, .r2 = NAN, .noise_db = NAN, .ceiling = NAN};
    enum vw_status status = fit(input, ASK_PREDICTIONS, &game, &worths);
    if (!status) measure_noise(input, game.player_count, summary);
    if (!status && worths.count) {
        const struct vw_worth_params params = params_of(&game, ASK_PREDICTIONS);
        summary->r2 = worths.r2;
        status = claim(&params, &worths, &game, summary);
    }
    vw_worths_free(&worths);
    close_game(&game);
    return status;
}

const char *vw_value_main_method(const struct vw_ledger_score *scores, uint32_t score_count) {
    static const char *const best_first[] = {vw_worth_method, "lasting_psnr"};
    for (size_t m = 0; m < VW_ARRAY_COUNT(best_first); m++)
        for (uint32_t i = 0; i < score_count; i++)
            if (scores[i].visits && isfinite(scores[i].value) && strcmp(scores[i].method, best_first[m]) == 0)
                return best_first[m];
    return vw_value_default_method;
}

// Games whose values are known: fake trainings whose photos move the validation measures by rule. PSNR starts at 12 dB;
// the pooled PSNR moves by twice as much, L1 by a hundredth of it the other way.
#ifndef VIEWWORTH_TESTS_SUPPORT_VALUE_GAME_H
#define VIEWWORTH_TESTS_SUPPORT_VALUE_GAME_H

#include "support/draws.h"
#include "support/ledger_fixture.h"

// The dB by which a step moves PSNR: `order` has the photos of the steps so far, of which `first` began the epoch;
// steps count from 1.
typedef double test_rule(const uint32_t *order, uint32_t first, uint32_t step, uint64_t seed);

struct test_game {
    struct vw_step_record records[TEST_RECORDS_MOST];
    uint32_t order[TEST_RECORDS_MOST]; // the train photo (0 to TEST_TRAIN_COUNT - 1) of each step
    uint32_t count;
};

// Returns -1 to 1 for a step; draws of different steps and seeds are independent.
static inline double test_noise(uint64_t seed, uint32_t step) { return test_draw(seed, step, 0); }

static inline void test_set_psnr(struct vw_step_record *record, double psnr) {
    record->val_psnr = psnr;
    record->val_psnr_pooled = 2 * psnr;
    record->val_l1 = 0.5 - psnr / 100;
}

// Worths of photos by the rule test_additive, in which none changes another's.
static const double test_worth_db[TEST_TRAIN_COUNT] = {0.5, -0.2, 0.1, -0.3, 0.2};

static inline double test_additive(const uint32_t *order, uint32_t first, uint32_t step, uint64_t seed) {
    (void)first;
    (void)seed;
    return test_worth_db[order[step]];
}

// Plays `epochs` epochs in which the photos of `subset` (bit i: photo i) take their turns in an order drawn anew. To be
// freed.
static inline struct test_game *test_play_subset(test_rule *rule, uint32_t subset, uint32_t epochs, uint64_t seed) {
    struct test_game *game = vw_allocate(1, sizeof *game);
    assert_non_null(game);
    game->count = 1;
    game->records[0] = (struct vw_step_record){.view = VW_RECORD_UNTRAINED, .validated = true};
    double psnr = 12;
    test_set_psnr(&game->records[0], psnr);
    for (uint32_t epoch = 0; epoch < epochs; epoch++) {
        uint32_t order[TEST_TRAIN_COUNT];
        const uint32_t first = game->count;
        vw_random_order(seed, epoch, TEST_TRAIN_COUNT, order);
        for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) {
            if (!(subset >> order[i] & 1)) continue;
            uint32_t step = game->count++;
            game->order[step] = order[i];
            psnr += rule(game->order, first, step, seed);
            game->records[step] = (struct vw_step_record){
                .step = step, .epoch = epoch, .view = test_train_views[order[i]], .validated = true};
            test_set_psnr(&game->records[step], psnr);
        }
    }
    return game;
}

static inline struct test_game *test_play(test_rule *rule, uint32_t epochs, uint64_t seed) {
    return test_play_subset(rule, (1u << TEST_TRAIN_COUNT) - 1, epochs, seed);
}

static inline void test_flag(struct test_game *game, uint32_t step) {
    struct vw_step_record *record = &game->records[step];
    record->nonfinite = true;
    record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
}

static inline struct vw_value_input test_input_of(const struct test_game *game, uint32_t burn_in_epochs, double beta1) {
    struct vw_value_input input = test_value_input(game->records, game->count);
    input.burn_in_epochs = burn_in_epochs;
    input.beta1 = beta1;
    return input;
}

#endif

// The settings of a training: their JSON, which of them are part of what a run is, and what is refused by name.
// label: host
#include "support/config_text.h"
#include "support/plain_config.h"

static bool same_identity(const struct vw_config *a, const struct vw_config *b) {
    AUTO_FREE char *one = vw_config_to_json(a, true), *other = vw_config_to_json(b, true);
    return strcmp(one, other) == 0;
}

TEST(settings_survive_json) {
    static const struct {
        const char *settings;
        bool identity; // part of what a run is, so that one with others is another run
    } cases[] = {
        {"'epochs':99", false},
        {"'effects':'none'", false},
        {"'pilot_steps':8", false},
        {"'seed':9223372036854775807", true},
        {"'vary':'order','base_seed':9223372036854775807", true},
        {"'vary':'pixels'", true},
        {"'vary':'init'", true},
        {"'vary':'validation'", true},
        {"'vary':'all,validation'", true},
        {"'burn_in_epochs':7", true},
        {"'rays':1", true},
        {"'importance_samples':24", true},
        {"'loss':'l1'", true},
        {"'loss':'huber'", true},
        {"'loss':'huber','huber_length':0.03", true},
        {"'optimizer':'sgd'", true},
        {"'learning_rate':0.30000000000000004", true},
        {"'learning_rate_decay':0.3", true},
        {"'background':'random'", true},
        {"'field':'mlp'", true},
        {"'field':'mlp','mlp_depth':6", true},
        {"'field':'mlp','frequencies':4", true},
        {"'field':'mlp','importance_samples':12", true},
        {"'field':'mlp','importance_samples':12,'coarse_network':'own'", true},
        {"'field':'splats','rays':512", true},
        {"'field':'splats','rays':512,'splats':1048576", true},
        {"'field':'splats','rays':512,'harmonics':3", true},
        {"'field':'splats','rays':512,'ssim_weight':0.2", true},
    };
    const struct vw_config plain = plain_config();
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct vw_config config = config_with(&plain, cases[i].settings);
        AUTO_FREE char *json = config_json_with(&plain, cases[i].settings), *again = vw_config_to_json(&config, false);
        assert_string_equal(again, json);
        if (same_identity(&config, &plain) == cases[i].identity)
            fail_msg("%s is%s part of what a run is", cases[i].settings, cases[i].identity ? " not" : "");
        for (size_t k = 0; k < i && cases[i].identity; k++) {
            const struct vw_config other = config_with(&plain, cases[k].settings);
            if (same_identity(&config, &other)) fail_msg("%s and %s are one run", cases[i].settings, cases[k].settings);
        }
    }
}

TEST(choices_have_their_names) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    const struct vw_config config =
        config_with(&hash, "'field':'mlp','importance_samples':8,'coarse_network':'own','loss':'huber',"
                           "'optimizer':'dense-adam','background':'random','vary':'init'");
    assert_int_equal(config.field, VW_FIELD_MLP);
    assert_int_equal(config.coarse_network, VW_COARSE_NETWORK_OWN);
    assert_int_equal(config.loss, VW_LOSS_HUBER);
    assert_int_equal(config.optimizer, VW_OPTIMIZER_DENSE_ADAM);
    assert_int_equal(config.background, VW_BACKGROUND_RANDOM);
    assert_int_equal(config.vary, VW_VARY_INIT);
    assert_int_equal(config_with(&hash, "'vary':'all,validation'").vary, VW_VARY_ALL_VALIDATION);
}

TEST(defaults_are_in_the_identity) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    static const char *const parts[] = {"\"vary\":\"all\"",
                                        "\"base_seed\":0",
                                        "\"huber_length\":0.1",
                                        "\"importance_samples\":16",
                                        "\"ssim_weight\":0.0",
                                        "\"learning_rate_decay\":0.1",
                                        "\"coarse_network\":\"shared\"",
                                        "\"field\":\"hash\"",
                                        "\"splats\":0",
                                        "\"harmonics\":1"};
    AUTO_FREE char *json = vw_config_to_json(&hash, true);
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); i++)
        if (!strstr(json, parts[i])) fail_msg("%s lacks %s", json, parts[i]);
}

// Otherwise a run may be extended.
TEST(the_planned_epochs_count_where_the_rate_decays) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    struct vw_config config = config_with(&hash, "'learning_rate_decay':0.05"), longer = config;
    longer.epochs++;
    assert_false(same_identity(&config, &longer));
    longer.decay_epochs = config.epochs; // it is what counts, once it is settled
    assert_true(same_identity(&config, &longer));
    config.decay_epochs = config.epochs;
    assert_true(same_identity(&config, &longer));
    longer.decay_epochs++;
    assert_false(same_identity(&config, &longer));
}

// Half as many photos take twice the epochs for as many steps, over which the rate falls as before.
TEST(a_decay_keeps_its_share_of_the_epochs) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    struct vw_config config = config_with(&hash, "'epochs':10,'decay_epochs':8");
    vw_config_set_epochs(&config, 20);
    assert_int_equal(config.epochs, 20);
    assert_int_equal(config.decay_epochs, 16);
    config.decay_epochs = 0; // all of them
    vw_config_set_epochs(&config, 5);
    assert_int_equal(config.decay_epochs, 0);
}

TEST(what_cannot_be_is_refused_by_name) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    static const struct {
        const char *settings, *message;
    } cases[] = {
        {"'rays':0", "--rays"},
        {"'samples':4097", "--samples"},
        {"'levels':17", "--levels"},
        {"'levels':3", "--levels"},
        {"'features':3", "--features"},
        {"'width':48", "--width"},
        {"'width':24", "16, 32 or 64 with --field hash"},
        {"'log2_table':23", "--log2-table"},
        {"'learning_rate_decay':1.5", "--learning-rate-decay takes"},
        {"'learning_rate_decay':1.0,'decay_epochs':3", "--decay-epochs: needs --learning-rate-decay"},
        {"'rays':4097,'importance_samples':4096", "--rays times --importance-samples is 16781312"},
        {"'base_seed':1", "0 where everything varies"}, // it would be lost
        {"'huber_length':0.3", "needs --loss huber, not l2"},
        {"'ssim_weight':0.2", "--ssim-weight: needs --field splats, not hash"},
        {"'field':'mlp','ssim_weight':0.2", "--ssim-weight: needs --field splats, not mlp"},
        {"'field':'splats','rays':512,'importance_samples':0,'width':64",
         "--width: needs --field hash or mlp, not splats"},
        {"'field':'splats','rays':512,'ssim_weight':1.1", "--ssim-weight takes 0 to 1, not 1.1"},
        {"'mlp_depth':3", "--mlp-depth: needs --field mlp, not hash"},
        {"'field':'mlp','levels':4", "--levels: needs --field hash, not mlp"},
        {"'field':'mlp','importance_samples':0,'coarse_network':'own'",
         "--coarse-network own: needs --importance-samples above 0"},
        {"'importance_samples':8,'coarse_network':'own'", "--coarse-network own: needs --field mlp, not hash"},
        {"'vary':'ordre'", "vary: \"ordre\" is not known"},
        {"'loss':'l3'", "loss: \"l3\" is not known"},
        {"'loss':null", "loss: \"(none)\" is not known"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config;
        AUTO_FREE char *json = config_json_with(&hash, cases[i].settings);
        enum vw_status status = vw_config_from_json(json, &config);
        ASSERT_FAILS(status, strstr(cases[i].message, "known") ? VW_ERROR_INPUT : VW_ERROR_USAGE, cases[i].message);
        assert_null(strchr(vw_error_message(), '\n'));
    }
    struct vw_config seed = hash, base = config_with(&hash, "'vary':'order'"), rate = hash;
    seed.seed = UINT64_C(1) << 63; // JSON has no such numbers
    base.base_seed = UINT64_MAX;
    rate.learning_rate = NAN;
    ASSERT_FAILS(vw_config_check(&seed), VW_ERROR_USAGE, "--seed");
    ASSERT_FAILS(vw_config_check(&base), VW_ERROR_USAGE, "base_seed");
    ASSERT_FAILS(vw_config_check(&rate), VW_ERROR_USAGE, "--lr");
}

TEST(a_seed_is_of_the_draws_that_vary) {
    const struct vw_config hash = vw_config_of_field(VW_FIELD_HASH);
    const struct vw_config all = config_with(&hash, "'seed':5"),
                           order = config_with(&hash, "'seed':6,'vary':'order','base_seed':5");
    for (enum vw_vary draws = VW_VARY_ORDER; draws <= VW_VARY_INIT; draws++) {
        assert_int_equal(vw_config_seed_of(&all, draws), 5);
        assert_int_equal(vw_config_seed_of(&order, draws), draws == VW_VARY_ORDER ? 6 : 5);
    }
    assert_int_equal(vw_config_seed_of(&all, VW_VARY_VALIDATION), 0); // all runs validate on the same pixels
}

TEST(a_config_without_a_field_takes_one) {
    struct vw_config config = vw_config_default;
    AUTO_FREE char *json = vw_config_to_json(&config, false);
    ASSERT_OK(vw_config_check(&config));
    ASSERT_FAILS(vw_config_from_json(json, &config), VW_ERROR_INPUT, "config: field: none is chosen");
    config.seed = 7;
    config.epochs = 5;
    vw_config_take_field(VW_FIELD_SPLATS, vw_config_explicit("harmonics") | vw_config_explicit("val-rays"), &config);
    struct vw_config expected = vw_config_of_field(VW_FIELD_SPLATS);
    expected.seed = 7;
    expected.epochs = 5;                            // differs from the default
    expected.val_rays = vw_config_default.val_rays; // is explicit
    assert_int_equal(config.val_rays, expected.val_rays);
    assert_true(same_identity(&config, &expected) && config.epochs == 5);
}

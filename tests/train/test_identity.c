// A run's id covers everything that may change a bit of it, so that no other run's rows can be taken for its own
// (decision 11).
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// Parts of a run's identity, one of which a test changes: the device for a moment only.
struct parts {
    struct vw_scene *scene;
    struct vw_config config;
    bool validate;
    struct vw_gpu_info *device;
};

static void identify(const struct parts *parts, uint8_t run_id[VW_HASH_BYTES]) {
    struct vw_trainer *trainer = test_trainer_create(parts->scene, &parts->config, parts->validate, 0);
    ASSERT_OK(vw_trainer_run_id(trainer, run_id));
}

static void change_scene(struct parts *parts) { parts->scene->hash[7] ^= 1; }
static void change_seed(struct parts *parts) { parts->config.seed ^= UINT64_C(1) << 40; }
static void change_vary(struct parts *parts) { parts->config.vary = VW_VARY_ORDER; }
static void change_vary_to_pixels(struct parts *parts) { parts->config.vary = VW_VARY_PIXELS; }
static void change_base_seed(struct parts *parts) {
    change_vary(parts);
    parts->config.base_seed = 1;
}
static void change_rays(struct parts *parts) { parts->config.rays++; }
static void change_learning_rate(struct parts *parts) { parts->config.learning_rate *= 1.0 + 0x1p-52; }
static void change_decay(struct parts *parts) { parts->config.learning_rate_decay = 0.5; }
static void change_epochs_of_decay(struct parts *parts) {
    change_decay(parts);
    parts->config.epochs++;
}
static void change_importance_samples(struct parts *parts) { parts->config.importance_samples = 16; }
static void change_field(struct parts *parts) { parts->config = test_config_of(VW_FIELD_MLP); }
static void change_importance_samples_of_mlp(struct parts *parts) {
    change_field(parts);
    change_importance_samples(parts);
}
static void change_coarse_network(struct parts *parts) {
    change_importance_samples_of_mlp(parts);
    parts->config.coarse_network = VW_COARSE_NETWORK_OWN;
}
static void change_burn_in(struct parts *parts) { parts->config.burn_in_epochs++; }
static void change_validation(struct parts *parts) { parts->validate = false; }
static void change_effects(struct parts *parts) { strcpy(parts->config.effects, "+background"); }
static void change_table_precision(struct parts *parts) { parts->config.table_precision = VW_TABLE_FLOAT16; }
static void change_mlp_depth(struct parts *parts) {
    change_field(parts);
    parts->config.mlp_depth = 2;
}
static void change_frequencies(struct parts *parts) {
    change_field(parts);
    parts->config.frequencies = 2;
}
static void change_loss(struct parts *parts) { parts->config.loss = VW_LOSS_HUBER; }
static void change_huber_length(struct parts *parts) {
    change_loss(parts);
    parts->config.huber_length = 0.3;
}
static void change_background(struct parts *parts) { parts->config.background = VW_BACKGROUND_RANDOM; }
static void change_to_unbounded(struct parts *parts) { strcpy(parts->config.effects, "+unbounded"); }
static void change_box(struct parts *parts) { // which depends on points, that the scene's hash does not cover
    change_to_unbounded(parts);
    parts->scene->box.half_extent_world *= 0.5;
}
static void change_device(struct parts *parts) { parts->device->name[0] ^= 1; }
static void change_driver(struct parts *parts) { parts->device->driver[0] ^= 1; }
static void change_subset(struct parts *parts) {
    parts->scene->views[0].split = VW_SPLIT_EXCLUDED;
    parts->scene->split_count[VW_SPLIT_TRAIN]--;
    parts->scene->split_count[VW_SPLIT_EXCLUDED]++;
}

TEST(every_part_of_a_run_names_it) {
    static void (*const changes[])(struct parts *) = {change_scene,
                                                      change_subset,
                                                      change_seed,
                                                      change_rays,
                                                      change_learning_rate,
                                                      change_burn_in,
                                                      change_validation,
                                                      change_effects,
                                                      change_background,
                                                      change_device,
                                                      change_driver,
                                                      change_to_unbounded,
                                                      change_box,
                                                      change_vary,
                                                      change_vary_to_pixels,
                                                      change_base_seed,
                                                      change_table_precision,
                                                      change_loss,
                                                      change_huber_length,
                                                      change_field,
                                                      change_mlp_depth,
                                                      change_frequencies,
                                                      change_decay,
                                                      change_epochs_of_decay,
                                                      change_importance_samples,
                                                      change_importance_samples_of_mlp,
                                                      change_coarse_network};
    struct vw_gpu_info *device = (struct vw_gpu_info *)vw_gpu_get_info(test_gpu()), kept = *device;
    uint8_t ids[VW_ARRAY_COUNT(changes) + 1][VW_HASH_BYTES];
    for (size_t i = 0; i <= VW_ARRAY_COUNT(changes); i++) {
        struct parts parts = {test_scene(), test_config(), true, device};
        if (i > 0) changes[i - 1](&parts);
        identify(&parts, ids[i]);
        *device = kept;
        for (size_t k = 0; k < i; k++)
            if (!memcmp(ids[k], ids[i], sizeof ids[i]))
                fail_msg("change %zu gives the same id as change %zu (0: none)", i, k);
    }
}

TEST_GROUP(NULL, test_gpu_close)

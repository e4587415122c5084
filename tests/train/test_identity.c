// A run's id covers everything that may change a bit of it, so that no other run's rows can be taken for its own, and
// neither epochs nor how effects were asked for (decision 11).
#include "support/config_text.h"
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
    test_release(trainer);
}

enum { SAME = 3 }; // the first settings leave a run what it is; test_config has all that change it
static const char *const settings[] = {
    "",
    "'epochs':99",
    "'effects':'none'", // as `auto` decides for this scene
    "'seed':1099511627776",
    "'learning_rate_decay':0.5",
    "'learning_rate_decay':0.5,'epochs':4",
    "'field':'splats','levels':10,'log2_table':14,'width':32,'rays':256",
    "'effects':'+background'",
    "'effects':'+unbounded'",
};

enum other { OTHER_SCENE, OTHER_SUBSET, OTHER_BOX, OTHER_DEVICE, OTHER_DRIVER, NO_VALIDATION, OTHERS };

static void change(struct parts *parts, enum other other) {
    switch (other) {
    case OTHER_SCENE: parts->scene->hash[7] ^= 1; break;
    case OTHER_SUBSET: test_exclude(parts->scene, 0); break;
    case OTHER_BOX: // which depends on points, that the scene's hash does not cover
        strcpy(parts->config.effects, "+unbounded");
        parts->scene->box.half_extent_world *= 0.5;
        break;
    case OTHER_DEVICE: parts->device->name[0] ^= 1; break;
    case OTHER_DRIVER: parts->device->driver[0] ^= 1; break;
    default: parts->validate = false;
    }
}

TEST(every_part_of_a_run_names_it) {
    enum { SETTINGS = VW_ARRAY_COUNT(settings) };
    struct vw_gpu_info *device = (struct vw_gpu_info *)vw_gpu_get_info(test_gpu()), kept = *device;
    const struct vw_config usual = test_config();
    uint8_t ids[SETTINGS + OTHERS][VW_HASH_BYTES];
    for (uint32_t i = 0; i < SETTINGS + OTHERS; i++) {
        struct parts parts = {test_scene(), config_with(&usual, i < SETTINGS ? settings[i] : ""), true, device};
        if (i >= SETTINGS) change(&parts, (enum other)(i - SETTINGS));
        identify(&parts, ids[i]);
        *device = kept;
        for (uint32_t k = 0; k < i; k++)
            if ((memcmp(ids[k], ids[i], sizeof ids[i]) == 0) != (i < SAME))
                fail_msg("changes %u and %u give %s", i, k, i < SAME ? "other ids" : "the same id");
    }
}

TEST_GROUP(NULL, test_gpu_close)

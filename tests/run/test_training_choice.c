// The choice of field and size, where a training leaves them open.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "run/plan/training_choice.h"
#include "support/gpu_fixture.h"

#define COURTYARD VW_SOURCE_FOLDER "/scenes/courtyard.json" // 96 x 72
#define TINY VW_SOURCE_FOLDER "/tests/support/tiny.json"    // 16 x 12

static struct vw_training_choice choose(const char *path, uint32_t downscale, const char *option, bool lasting,
                                        struct vw_config *config, uint32_t *chosen) {
    struct vw_scene_params scene = {.path = path, .downscale = downscale};
    const struct vw_training_choice_params params = {
        .gpu = test_gpu(), .explicit_fields = vw_config_explicit(option), .lasting = lasting};
    struct vw_training_choice choice;
    ASSERT_OK(vw_training_choose(&params, &scene, config, &choice));
    *chosen = scene.downscale;
    return choice;
}

TEST(a_field_is_chosen_by_what_is_asked_for) {
    static const struct {
        const char *path, *option, *effects, *why;
        bool lasting;
        enum vw_field field;
    } cases[] = {
        {COURTYARD, "", "auto", "splats, which are crisper", false, VW_FIELD_SPLATS},
        {TINY, "", "auto", "splats, which are crisper", false, VW_FIELD_SPLATS},
        {COURTYARD, "samples", "auto", "hash, since --samples as given is not for splats", false, VW_FIELD_HASH},
        {COURTYARD, "mlp-depth", "auto", "mlp, since --mlp-depth as given", false, VW_FIELD_MLP},
        {COURTYARD, "rays", "auto", "hash, since --rays as given", false, VW_FIELD_HASH},
        {TINY, "ssim-weight", "auto", "splats, since --ssim-weight as given is not for a hash grid", false,
         VW_FIELD_SPLATS},
        {COURTYARD, "", "+transient", "hash, since --effects as given", false, VW_FIELD_HASH},
        {COURTYARD, "", "-transient", "splats, which are crisper", false, VW_FIELD_SPLATS},
        {COURTYARD, "", "auto", "hash, since splats have no lasting credit", true, VW_FIELD_HASH},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config = vw_config_default;
        uint32_t downscale;
        strcpy(config.effects, cases[i].effects);
        if (!strcmp(cases[i].option, "samples")) config.samples = 24;
        if (!strcmp(cases[i].option, "mlp-depth")) config.mlp_depth = 3;
        if (!strcmp(cases[i].option, "rays")) config.rays = 100;
        if (!strcmp(cases[i].option, "ssim-weight")) config.ssim_weight = 0.3;
        const struct vw_training_choice choice =
            choose(cases[i].path, 0, cases[i].option, cases[i].lasting, &config, &downscale);
        if (config.field != cases[i].field || strncmp(choice.field, cases[i].why, strlen(cases[i].why)) != 0)
            fail_msg("case %zu: %s", i, choice.field);
        assert_int_equal(downscale, 1);
    }
}

TEST(what_is_given_is_not_chosen) {
    struct vw_config config = vw_config_of_field(VW_FIELD_MLP);
    uint32_t downscale;
    const struct vw_training_choice choice = choose("no scene is opened", 3, "", false, &config, &downscale);
    assert_true(config.field == VW_FIELD_MLP && downscale == 3 && !*choice.field && !*choice.size);
}

TEST(a_cpu_trains_at_a_size_that_it_sees_often_enough) {
    static const struct {
        const char *accuracy;
        enum vw_gpu_kind device;
        double pixels;
        uint32_t downscale;
    } cases[] = {
        {NULL, VW_GPU_CPU, 64 * 48, 1},          {NULL, VW_GPU_CPU, 256 * 384, 2},
        {NULL, VW_GPU_CPU, 270 * 480, 3},        {NULL, VW_GPU_CPU, 1e9, 64},
        {"draft", VW_GPU_CPU, 270 * 480, 4},     {"reference", VW_GPU_CPU, 270 * 480, 1},
        {NULL, VW_GPU_DISCRETE, 1920 * 1080, 1}, {NULL, VW_GPU_DISCRETE, 4000 * 3000, 3},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++)
        if (vw_training_downscale(cases[i].accuracy, cases[i].device, cases[i].pixels) != cases[i].downscale)
            fail_msg("case %zu", i);
}

// The effect transient in whole trainings: what hides photos harms less. (What all effects promise:
// test_effect_promises; a run in parts: test_fields.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"

static struct vw_config config_with(enum vw_field field, const char *effects) {
    struct vw_config config = test_config_of(field);
    strcpy(config.effects, effects);
    return config;
}

// Trains with photos partly hidden, and returns the mean validation PSNR of the last 10 steps.
static double psnr_with(const struct vw_scene *scene, const char *effects) {
    struct vw_config config = config_with(VW_FIELD_HASH, effects);
    config.epochs = 40;
    struct test_run *run = test_run(scene, &config, true, 0);
    double psnr = 0.0;
    for (uint32_t i = run->count - 10; i < run->count; i++) psnr += run->records[i].val_psnr / 10.0;
    assert_int_equal(run->stats.nonfinite_steps, 0);
    return psnr;
}

TEST(what_hides_photos_harms_less) {
    struct vw_scene *scene = test_scene();
    for (uint32_t view = 0; view < 5; view++) { // another quarter of each, in a colour of its own
        struct vw_image *image = &scene->views[view].image;
        for (uint32_t y = 0; y < image->height_px / 2; y++)
            for (uint32_t x = 0; x < image->width_px / 2; x++) {
                uint32_t left = view % 2 * image->width_px / 2, top = view / 2 % 2 * image->height_px / 2;
                uint8_t *pixel = (uint8_t *)image->pixels + 4 * ((y + top) * image->width_px + x + left);
                for (uint32_t c = 0; c < 3; c++) pixel[c] = (view + 1) >> c & 1 ? 255 : 0;
            }
    }
    double without = psnr_with(scene, "none"), with = psnr_with(scene, "transient");
    print_message("photos hidden by a quarter: %.2f dB without, %.2f dB with transient\n", without, with);
    assert_true(with > without);
}

TEST_GROUP(NULL, test_gpu_close)

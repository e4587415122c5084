// Structural similarity: known values, another program's, and an independent implementation that filters nothing
// separably.
#include "image/image.h"
#include "support/cmocka_test.h"

enum { WIDTH = 24, HEIGHT = 17, VALUES = 3 * WIDTH * HEIGHT };

// Sums of some hundred terms near 1 in double, in another order.
#define ROUNDING 1e-12

static double ssim_of(const float *a, const float *b, const uint8_t *usable, uint32_t width_px, uint32_t height_px) {
    double ssim = 0;
    ASSERT_OK(vw_ssim(a, b, usable, width_px, height_px, &ssim));
    return ssim;
}

// Compares two whole pictures.
#define SSIM(a, b) ssim_of(a, b, NULL, WIDTH, HEIGHT)

// Draws noise by the generator of Numerical Recipes, so that other programs make the same pictures: the top 24 bits in
// [0,1).
static void draw_noise(uint32_t *state, float *values) {
    for (int i = 0; i < VALUES; i++) {
        *state = *state * 1664525u + 1013904223u;
        values[i] = (float)(*state >> 8) / 16777216.0f;
    }
}

struct pictures {
    float noise[VALUES], blend[VALUES], ramp[VALUES], grainy[VALUES];
};

static struct pictures draw_pictures(void) {
    static float other[VALUES];
    struct pictures pictures;
    uint32_t state = 7;
    draw_noise(&state, pictures.noise);
    draw_noise(&state, other);
    for (int i = 0; i < VALUES; i++) {
        int x = i / 3 % WIDTH, y = i / 3 / WIDTH;
        pictures.blend[i] = 0.75f * pictures.noise[i] + 0.25f * other[i];
        pictures.ramp[i] = i % 3 == 0 ? (float)x / 32 : i % 3 == 1 ? (float)y / 32 : (float)(x + y) / 64;
        pictures.grainy[i] = pictures.ramp[i] + 0.125f * other[i];
    }
    return pictures;
}

// Returns the definition, window by window, with central moments.
static double slow_ssim(const float *a, const float *b, const uint8_t *usable, uint32_t width_px, uint32_t height_px) {
    double total = 0, windows = 0;
    for (uint32_t channel = 0; channel < 3; channel++)
        for (uint32_t top = 0; top + 11 <= height_px; top++)
            for (uint32_t left = 0; left + 11 <= width_px; left++) {
                double weight_sum = 0, mean_a = 0, mean_b = 0, var_a = 0, var_b = 0, cov = 0;
                int hidden = 0;
                for (int pass = 0; pass < 2; pass++)
                    for (uint32_t i = 0; i < 121; i++) {
                        double dx = (double)(i % 11) - 5, dy = (double)(i / 11) - 5,
                               weight = exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
                        size_t pixel = (size_t)(top + i / 11) * width_px + left + i % 11;
                        double va = a[3 * pixel + channel], vb = b[3 * pixel + channel];
                        if (pass == 0) weight_sum += weight, mean_a += weight * va, mean_b += weight * vb;
                        else
                            var_a += weight * (va - mean_a) * (va - mean_a),
                                var_b += weight * (vb - mean_b) * (vb - mean_b);
                        if (pass == 1) cov += weight * (va - mean_a) * (vb - mean_b);
                        if (pass == 0 && i == 120) mean_a /= weight_sum, mean_b /= weight_sum;
                        hidden += usable && !usable[pixel];
                    }
                if (hidden) continue;
                windows++;
                total += (2 * mean_a * mean_b + 1e-4) * (2 * cov / weight_sum + 9e-4) /
                         ((mean_a * mean_a + mean_b * mean_b + 1e-4) * ((var_a + var_b) / weight_sum + 9e-4));
            }
    return total / windows;
}

TEST(an_image_is_like_itself) {
    struct pictures p = draw_pictures();
    assert_near(SSIM(p.noise, p.noise), 1, ROUNDING);
    assert_near(SSIM(p.ramp, p.ramp), 1, ROUNDING);
}

// Without variance the second factor is C2 / C2.
TEST(constant_images_differ_by_their_means) {
    static const float levels[][2] = {{0.2f, 0.6f}, {0, 1}, {1, 1}, {0.5f, 0.25f}};
    for (size_t l = 0; l < sizeof levels / sizeof levels[0]; l++) {
        float a[VALUES], b[VALUES];
        double left = levels[l][0], right = levels[l][1];
        for (int i = 0; i < VALUES; i++) a[i] = levels[l][0], b[i] = levels[l][1];
        assert_near(SSIM(a, b), (2 * left * right + 1e-4) / (left * left + right * right + 1e-4), ROUNDING);
    }
}

// Each channel is evaluated separately: two that are the same and one that is not.
TEST(channels_are_averaged) {
    float a[VALUES], b[VALUES];
    for (int i = 0; i < VALUES; i++) a[i] = 0.5f, b[i] = i % 3 == 1 ? 0.25f : 0.5f;
    double green = (2 * 0.5 * 0.25 + 1e-4) / (0.25 + 0.0625 + 1e-4);
    assert_near(SSIM(a, b), (2 + green) / 3, ROUNDING);
}

// scikit-image 0.19.3: skimage.metrics.structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
// use_sample_covariance=False, data_range=1, channel_axis=2) of the pictures as doubles, whose mean is over whole
// windows as well.
TEST(values_of_another_program) {
    struct pictures p = draw_pictures();
    assert_near(SSIM(p.noise, p.blend), 0.92875996046330567, 1e-9);
    assert_near(SSIM(p.ramp, p.grainy), 0.76352575799332845, 1e-9);
    assert_near(SSIM(p.noise, p.ramp), 0.0055176673707754047, 1e-9);
}

TEST(values_of_the_definition) {
    struct pictures p = draw_pictures();
    assert_near(SSIM(p.noise, p.blend), slow_ssim(p.noise, p.blend, NULL, WIDTH, HEIGHT), ROUNDING);
    assert_near(SSIM(p.ramp, p.grainy), slow_ssim(p.ramp, p.grainy, NULL, WIDTH, HEIGHT), ROUNDING);
    assert_near(ssim_of(p.ramp, p.grainy, NULL, 11, 11), slow_ssim(p.ramp, p.grainy, NULL, 11, 11),
                ROUNDING); // a single window
}

// The value under a hidden pixel does not matter, and which windows count is that of the definition: with a pixel, a
// row, the left half.
TEST(hidden_pixels_have_no_say) {
    for (int form = 0; form < 3; form++) {
        struct pictures p = draw_pictures();
        uint8_t usable[WIDTH * HEIGHT];
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            usable[i] = form == 0 ? i != 12 * WIDTH + 3 : form == 1 ? i / WIDTH != 2 : i % WIDTH >= WIDTH / 2;
        double expected = slow_ssim(p.noise, p.blend, usable, WIDTH, HEIGHT);
        assert_true(isfinite(expected));
        assert_near(ssim_of(p.noise, p.blend, usable, WIDTH, HEIGHT), expected, ROUNDING);
        for (int i = 0; i < VALUES; i++)
            if (!usable[i / 3]) p.blend[i] = 7;
        assert_near(ssim_of(p.noise, p.blend, usable, WIDTH, HEIGHT), expected, ROUNDING);
    }
}

TEST(without_a_window_there_is_no_value) {
    struct pictures p = draw_pictures();
    uint8_t usable[WIDTH * HEIGHT];
    assert_true(isnan(ssim_of(p.noise, p.noise, NULL, 10, HEIGHT)));
    assert_true(isnan(ssim_of(p.noise, p.noise, NULL, WIDTH, 10)));
    assert_true(isnan(ssim_of(p.noise, p.noise, NULL, 0, 0)));
    for (int i = 0; i < WIDTH * HEIGHT; i++) usable[i] = i % WIDTH % 11 != 10; // eleven in a row never
    assert_true(isnan(ssim_of(p.noise, p.noise, usable, WIDTH, HEIGHT)));
}

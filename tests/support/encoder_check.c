#include "support/encoder_check.h"
#include "support/cmocka_test.h"

#include "base/memory.h"

static const double FORWARD_TOLERANCE = 2e-5;  // share of the largest: sums of up to 148 products
static const double GRADIENT_TOLERANCE = 5e-4; // likewise; a unit near the kink may fall to either side
static const double LEAST = 1e-30;             // below, products are denormal floats on their way

double *encoder_network(const struct step_bench *bench, const float *params) {
    size_t count = vw_encoder_network(&bench->model).size_bytes / sizeof(float);
    const float *first = params + vw_encoder_network(&bench->model).offset_bytes / sizeof(float);
    double *network = test_allocate(count, sizeof *network);
    for (size_t i = 0; i < count; i++) network[i] = first[i];
    return network;
}

struct reference_photo_encoding *encoder_reference(struct step_bench *bench, const double *network, uint32_t view) {
    struct reference_photo_encoding *encoding = test_allocate(1, sizeof *encoding);
    const vw_float4 *thumbnails = test_read(bench->field.effect_buffers[VW_SLOT_THUMBNAILS]);
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
        vw_float4 pixel = thumbnails[(size_t)THUMBNAIL_PIXELS * view + i];
        const double values[4] = {pixel.x, pixel.y, pixel.z, pixel.w};
        for (int c = 0; c < 4; c++) encoding->thumbnail[i][c] = values[c];
    }
    reference_encode_photo(network, 4 * bench->model.specialization.width4, encoding);
    return encoding;
}

static void compare(struct hard_finding *finding, const char *what, const float *found, const double *expected,
                    size_t count, double tolerance) {
    double scale = fmax(largest(expected, count), LEAST);
    for (size_t i = 0; i < count; i++) hard_compare(finding, what, i, found[i], expected[i], scale, tolerance);
}

static void compare_forward(struct hard_finding *finding, struct step_bench *bench,
                            const struct reference_photo_encoding *expected) {
    static const uint32_t first[] = {0, 4 * ENCODER_ROW_LAYER2, 4 * ENCODER_ROW_LAYER3};
    float *rows = test_read(bench->field.effect_buffers[VW_SLOT_ENCODER_ROWS]),
          *shift = test_read(bench->field.effect_buffers[VW_SLOT_CODE_SHIFT]);
    for (uint32_t layer = 0; layer < ENCODER_LAYERS; layer++)
        compare(finding, "activation", rows + first[layer], expected->outputs[layer],
                (uint32_t)REFERENCE_ENCODER_OUTPUTS >> 2 * layer, FORWARD_TOLERANCE);
    compare(finding, "mean", rows + 4 * ENCODER_ROW_MEAN, expected->mean, 4 * ENCODER4, FORWARD_TOLERANCE);
    compare(finding, "code", rows + 4 * ENCODER_ROW_CODE, expected->code, REFERENCE_CODE, FORWARD_TOLERANCE);
    compare(finding, "shift", shift, expected->shift, 4 * bench->model.specialization.width4, FORWARD_TOLERANCE);
}

// Compares the gradients, given the one that the device has found for the weights that the code shifts.
static void compare_gradients(struct hard_finding *finding, struct step_bench *bench, const double *network,
                              const struct reference_photo_encoding *encoding) {
    const uint32_t columns[] = {0,
                                ENCODER_LAYER2,
                                ENCODER_LAYER3,
                                ENCODER_CODE,
                                ENCODER_SHIFT,
                                VW_ENCODER_COLUMNS(bench->model.specialization.width4)};
    const struct vw_specialization *s = &bench->model.specialization;
    float *d_weights = test_read(bench->step.d_weights), *own = d_weights + 4 * (size_t)s->encoder_column;
    double d_shift[REFERENCE_WIDTH_MAX], *expected = test_allocate(4 * (size_t)columns[5], sizeof *expected);
    for (uint32_t unit = 0; unit < 4 * s->width4; unit++)
        d_shift[unit] = d_weights[4 * (s->shift_column + s->shift_stride * (unit / 4)) + unit % 4];
    reference_encode_photo_gradient(network, 4 * s->width4, encoding, d_shift, expected);
    for (int part = 0; part < 5; part++)
        compare(finding, "gradient", own + 4 * (size_t)columns[part], expected + 4 * (size_t)columns[part],
                4 * (columns[part + 1] - columns[part]), GRADIENT_TOLERANCE);
}

void encoder_check(struct hard_finding *finding, struct step_bench *bench, uint64_t number) {
    step_bench_gradients(bench, number);
    float *params = test_read(bench->field.params);
    struct vw_step_state *flags = test_read(bench->field.step_state);
    double *network = encoder_network(bench, params);
    struct reference_photo_encoding *encoding = encoder_reference(bench, network, bench->view);
    hard_require(finding, !flags->skipped, "the step is finite");
    compare_forward(finding, bench, encoding);
    compare_gradients(finding, bench, network, encoding);
}

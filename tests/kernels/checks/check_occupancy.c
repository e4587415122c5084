// The passes that skip empty space against the reference: what is believed of the cells, which samples are kept, and
// where they go. On benches without the effect there is nothing to check.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "kernels/checks/check.h"

static const double POSITION_TOLERANCE = 1e-6;      // box edges, as for forward_field
static const double ENCODING_ROUNDINGS = 16.0;      // likewise
static const double EXP_TOLERANCE = 0x1p-20;        // relative, beside what Vulkan allows at large arguments
static const uint64_t STEP = UINT64_C(0x300000005); // needs both words

// ---- refresh_occupancy ----------------------------------------------------------------------------------------------

// Bounds a cell's density on the device, from the reference's raw density and the roundings on the way to it.
static void density_bounds(const struct step_bench *bench, struct reference_params *params, uint32_t cell,
                           double grid_largest, double *low, double *high) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    double encoding[REFERENCE_ENCODING_MAX], encoding_error[REFERENCE_ENCODING_MAX], hidden[REFERENCE_WIDTH_MAX],
        hidden_error[REFERENCE_WIDTH_MAX], raw = 0.0, position[3];
    double expected = reference_cell_density(s, params, cell, vw_model_key_of_step(&bench->model, STEP), position);
    reference_matrices(s, &params->weights, matrices);
    reference_grid_encode(s, params->grid, position, encoding);
    for (uint32_t i = 0; i < REFERENCE_ENCODING_MAX; i++)
        encoding_error[i] =
            grid_largest * (6.0 * POSITION_TOLERANCE * s->resolution[i / (2 * s->feature_pairs) % VW_LEVELS_MAX] +
                            ENCODING_ROUNDINGS * FLOAT_ROUNDING) +
            ENCODING_ROUNDINGS * FLOAT_LEAST;
    for (uint32_t i = 0; i < matrices[0].out; i++) {
        double sum = 0.0;
        for (uint32_t k = 0; k < matrices[0].in; k++) sum += matrices[0].values[i * matrices[0].in + k] * encoding[k];
        hidden[i] = fmax(sum, 0.0);
        hidden_error[i] = product_error(&matrices[0], false, i, encoding, encoding_error);
    }
    for (uint32_t k = 0; k < matrices[1].in; k++) raw += matrices[1].values[k] * hidden[k];
    double error = product_error(&matrices[1], false, 0, hidden, hidden_error), most = log(reference_density_max);
    double relative = EXP_TOLERANCE + 2.0 * fmin(fabs(raw), 88.0) * 0x1p-23;
    check_value(bench->where, "the reference's density", cell, expected, exp(fmin(raw, most)), 1e-9 * expected);
    *low = exp(fmin(raw - error, most)) * (1.0 - relative) - FLOAT_LEAST;
    *high = fmin(exp(fmin(raw + error, most)) * (1.0 + relative) + FLOAT_LEAST, reference_density_max);
}

void check_refresh_occupancy(struct step_bench *bench, enum input_kind kind) {
    struct vw_push_refresh push = {.key = vw_model_key_of_step(&bench->model, STEP), .remains = 0.75f};
    struct test_random random = {.seed = bench->config.seed + 3};
    if (!bench->field.effect_buffers[VW_SLOT_OCCUPANCY]) return;
    float *before = step_bench_read(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY]),
          *old = test_allocate(VW_OCCUPANCY_CELLS, sizeof *old);
    for (uint32_t i = 0; i < VW_OCCUPANCY_CELLS; i++) old[i] = fabsf(input_draw(kind, &random));
    old[77] = NAN; // is forgotten once the field has a number there
    step_bench_write(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY], old);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "refresh_occupancy"), &push, sizeof push,
                        VW_OCCUPANCY_CELLS);
    float *device = step_bench_read(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY]);
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    double grid_largest = largest(params->grid, 2 * (size_t)bench->model.pair_count);
    for (uint32_t cell = 0; cell < VW_OCCUPANCY_CELLS; cell++) {
        double low, high, remaining = isnan(old[cell]) ? 0.0 : 0.75 * old[cell];
        density_bounds(bench, params, cell, grid_largest, &low, &high);
        check_between(bench->where, "density of a cell", cell, device[cell], fmax(low, remaining * (1.0 - 0x1p-23)),
                      fmax(high, remaining * (1.0 + 0x1p-23)));
    }
    step_bench_write(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY], before);
}

// ---- mark_samples ---------------------------------------------------------------------------------------------------

static bool bit_of(const uint32_t *bits, uint32_t ray, uint32_t samples, uint32_t i) {
    return bits[ray * ((samples + 31) / 32) + i / 32] >> i % 32 & 1;
}

// Positions so near a cell's face that either cell may be meant are not evaluated.
static bool near_a_face(const double position[3]) {
    for (int axis = 0; axis < 3; axis++) {
        double scaled = 32.0 * position[axis], face = round(scaled);
        if (face > 0.0 && face < 32.0 && fabs(scaled - face) < 32.0 * POSITION_TOLERANCE) return true;
    }
    return false;
}

// Returns how many samples are kept.
static uint32_t check_marks(struct step_bench *bench, const struct vw_ray *rays, const float *densities,
                            uint64_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct vw_push_samples push = step_bench_push(bench, number);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "mark_samples"), &push, sizeof push, push.ray_count);
    uint32_t *bits = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BITS]),
             *counts = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BEGINS]);
    uint32_t all = 0;
    for (uint32_t r = 0; r < push.ray_count; r++) {
        struct reference_ray ray = reference_ray_of(&rays[r]);
        uint32_t count = 0;
        for (uint32_t i = 0; i < s->samples; i++) {
            double position[3];
            reference_sample_position(s, &ray, i, reference_stratum_offset(s, r, i, push.key), position);
            float density = densities[reference_cell(position)];
            bool keeps = bit_of(bits, r, s->samples, i),
                 expected = number <= 256 || isnan(density) || density > reference_empty_density(s);
            if (keeps != expected && (number <= 256 || !near_a_face(position)))
                fail_msg("%s: step %llu: sample %u of ray %u is %s, density %g", bench->where,
                         (unsigned long long)number, i, r, keeps ? "kept" : "skipped", density);
            count += keeps;
        }
        if (counts[r] != count) fail_msg("%s: ray %u keeps %u samples, not %u", bench->where, r, count, counts[r]);
        all += count;
    }
    return all;
}

void check_mark_samples(struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed + 4};
    if (!bench->field.effect_buffers[VW_SLOT_OCCUPANCY]) return;
    float *before = step_bench_read(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY]),
          *densities = test_allocate(VW_OCCUPANCY_CELLS, sizeof *densities);
    for (uint32_t i = 0; i < VW_OCCUPANCY_CELLS; i++) densities[i] = input_draw(kind, &random);
    for (uint32_t i = 5; i < VW_OCCUPANCY_CELLS; i += 50) densities[i] = i % 100 == 5 ? NAN : 1e-3f;
    step_bench_write(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY], densities);
    struct vw_ray *rays = rays_make(bench);
    uint32_t kept = check_marks(bench, rays, densities, STEP);
    if (kind == INPUT_ORDINARY) assert_true(kept > bench->padded_samples / 8 && kept < bench->padded_samples / 8 * 7);
    assert_int_equal(check_marks(bench, rays, densities, 1), bench->padded_samples);
    assert_int_equal(check_marks(bench, rays, densities, 256), bench->padded_samples);
    assert_true(check_marks(bench, rays, densities, 257) < bench->padded_samples);
    assert_true(check_marks(bench, rays, densities, UINT64_C(1) << 32) < bench->padded_samples);
    step_bench_write(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY], before);
}

// ---- place_rays -----------------------------------------------------------------------------------------------------

// Draws counts of many kinds: any, all, none, one in all, and filling the last workgroup exactly.
static void draw_counts(const struct step_bench *bench, enum input_kind kind, uint32_t *counts) {
    struct test_random random = {.seed = bench->config.seed + (uint64_t)kind};
    uint32_t rays = bench->step.padded_rays, samples = bench->config.samples, left = VW_FIELD_GROUP;
    for (uint32_t r = 0; r < rays; r++) {
        uint32_t drawn = (uint32_t)((0.5f + 0.5f * test_random_next(&random)) * (float)(samples + 1));
        counts[r] = kind == INPUT_LARGE ? samples : kind == INPUT_ZERO ? 0 : kind == INPUT_TINY ? r == rays / 2 : drawn;
        if (kind == INPUT_DENORMAL) counts[r] = left < drawn || r == rays - 1 ? left : drawn;
        left -= kind == INPUT_DENORMAL ? counts[r] : 0;
    }
}

static void check_groups(const struct step_bench *bench, const struct vw_kept *kept, uint32_t total) {
    uint32_t groups = (total + 255) / 256, slices = groups * (256 / bench->model.specialization.slice_samples),
             tiles = slices * bench->model.weight_tiles * bench->model.specialization.slice_parts;
    assert_int_equal(kept->slots, 256 * groups);
    assert_memory_equal(&kept->field_groups, &((vw_uint3){groups, 1, 1}), sizeof kept->field_groups);
    assert_memory_equal(&kept->weight_groups, &((vw_uint3){(tiles + 63) / 64, 1, 1}), sizeof kept->weight_groups);
    for (uint32_t i = 0; i < VW_LEVELS_MAX; i++)
        assert_memory_equal(&kept->scatter_groups[i], &((vw_uint3){4 * groups, i + 1, 1}),
                            sizeof kept->scatter_groups[i]);
}

void check_place_rays(struct step_bench *bench, enum input_kind kind) {
    struct vw_push_samples push = step_bench_push(bench, 1);
    uint32_t rays = push.ray_count, total = 0, slots = bench->padded_samples;
    if (!bench->step.effect_buffers[VW_SLOT_KEPT]) return;
    uint32_t *counts = test_allocate(rays + 1, sizeof *counts), *samples = test_allocate(slots, sizeof *samples);
    float *d_field = test_allocate(4 * (size_t)slots, sizeof *d_field);
    for (uint32_t i = 0; i < slots; i++) samples[i] = d_field[4 * i] = d_field[4 * i + 3] = 7;
    draw_counts(bench, kind, counts);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BEGINS], counts);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_KEPT_SAMPLES], samples);
    step_bench_write(bench, bench->step.d_samples, d_field);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "place_rays"), &push, sizeof push, 1);
    uint32_t *begins = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BEGINS]),
             *padded = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_SAMPLES]);
    float *d_padded = step_bench_read(bench, bench->step.d_samples);
    struct vw_kept *kept = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT]);
    for (uint32_t r = 0; r < rays; total += counts[r++]) assert_int_equal(begins[r], total);
    assert_int_equal(begins[rays], total);
    check_groups(bench, kept, total);
    for (uint32_t i = 0; i < slots; i++) {
        bool pad = i >= total && i < kept->slots;
        assert_int_equal(padded[i], pad ? 0 : 7);
        assert_true(d_padded[4 * i] == (pad ? 0.0f : 7.0f) && d_padded[4 * i + 3] == (pad ? 0.0f : 7.0f));
    }
}

// ---- list_samples ---------------------------------------------------------------------------------------------------

static uint32_t draw_bits(enum input_kind kind, struct test_random *random) {
    uint32_t drawn = (uint32_t)((0.5f + 0.5f * test_random_next(random)) * 0x1p32f);
    return kind == INPUT_LARGE ? UINT32_MAX : kind == INPUT_ZERO ? 0 : kind == INPUT_TINY ? drawn & 1 : drawn;
}

void check_list_samples(struct step_bench *bench, enum input_kind kind) {
    struct vw_push_samples push = step_bench_push(bench, 1);
    struct test_random random = {.seed = bench->config.seed + 5};
    uint32_t rays = push.ray_count, per_ray = bench->config.samples, words = (per_ray + 31) / 32, next = 0;
    if (!bench->step.effect_buffers[VW_SLOT_KEPT]) return;
    uint32_t *bits = test_allocate((size_t)rays * words, sizeof *bits),
             *begins = test_allocate(rays + 1, sizeof *begins);
    uint32_t *expected = test_allocate(bench->padded_samples, sizeof *expected);
    for (uint32_t r = 0; r < rays; r++) {
        for (uint32_t w = 0; w < words; w++)
            bits[r * words + w] = draw_bits(kind, &random); // bits beyond the last sample mean nothing
        begins[r] = next;
        for (uint32_t i = 0; i < per_ray; i++)
            if (bit_of(bits, r, per_ray, i)) expected[next++] = r * per_ray + i;
    }
    begins[rays] = next;
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BITS], bits);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BEGINS], begins);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "list_samples"), &push, sizeof push, rays);
    uint32_t *device = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_SAMPLES]);
    check_same_bits(bench->where, "listed samples", device, expected, 4 * (size_t)next);
}

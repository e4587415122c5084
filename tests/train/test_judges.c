// Train photos that judge each other: what they keep out of their training, who judges when, and what a step's row
// says.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "support/trainer_fixture.h"
#include "train/validation/validation.h"

enum { PHOTOS = 23, JUDGES = 4, ROUNDS = 3 };

static struct vw_judges choose(uint32_t train_count, uint32_t per_epoch, uint32_t **views) {
    const struct vw_scene *scene =
        synthetic_scene(&(struct synthetic_scene_params){.train_views = train_count, .width_px = 8, .height_px = 8});
    struct vw_judges judges = {0};
    uint32_t *train = test_allocate(train_count, sizeof *train);
    for (uint32_t i = 0; i < train_count; i++) train[i] = i;
    ASSERT_OK(vw_judges_choose(scene, train, train_count, per_epoch, &judges, views));
    return judges;
}

TEST(in_a_round_each_photo_judges_once) {
    uint32_t *views = NULL;
    AUTO(vw_judges_free) struct vw_judges judges = choose(PHOTOS, JUDGES, &views);
    bool first_differs = false;
    assert_int_equal(judges.group_count, PHOTOS / JUDGES);
    for (uint32_t round = 0; round < ROUNDS; round++) {
        uint32_t served[PHOTOS] = {0};
        for (uint32_t e = 0; e < judges.group_count; e++) {
            uint32_t group = vw_judges_group_of_epoch(&judges, round * judges.group_count + e);
            assert_in_range(vw_judges_in_group(&judges, group), JUDGES, judges.group_most);
            for (uint32_t i = judges.group_starts[group]; i < judges.group_starts[group + 1]; i++) {
                served[views[i]]++;
                if (i > judges.group_starts[group]) assert_true(views[i] > views[i - 1] + 1); // neighbours are apart
            }
        }
        for (uint32_t i = 0; i < PHOTOS; i++) assert_int_equal(served[i], 1);
        first_differs |=
            vw_judges_group_of_epoch(&judges, 0) != vw_judges_group_of_epoch(&judges, round * judges.group_count);
    }
    assert_true(first_differs);
    free(views);
}

TEST(of_many_photos_some_judge) {
    enum { MANY = 1400 };
    uint32_t *views = NULL, served = 0;
    AUTO(vw_judges_free) struct vw_judges judges = choose(MANY, 8, &views);
    uint32_t count = judges.group_starts[judges.group_count];
    bool *judged = test_allocate(MANY, sizeof *judged);
    assert_int_equal(count, VW_JUDGES_MOST);
    for (uint32_t i = 0; i < count; i++) judged[views[i]] = true;
    for (uint32_t i = 0; i < MANY; i++) served += judged[i];
    assert_int_equal(served, VW_JUDGES_MOST);
    for (uint32_t i = 0, apart = 0; i < MANY; i++, apart++) { // spread evenly
        if (judged[i]) apart = 0;
        assert_in_range(apart, 0, MANY / VW_JUDGES_MOST + 1);
    }
    free(views);
}

TEST(a_photo_alone_has_no_judge) {
    struct vw_judges judges = {0};
    uint32_t view = 0, *views = NULL;
    ASSERT_FAILS(vw_judges_choose(test_scene(), &view, 1, JUDGES, &judges, &views), VW_ERROR_USAGE, "--judges");
}

// ---- Training -------------------------------------------------------------------------------------------------------

static const enum vw_field fields[] = {VW_FIELD_HASH, VW_FIELD_SPLATS};

static struct vw_config judged_config(enum vw_field field) {
    struct vw_config config = test_config_of(field);
    config.judges = 2;
    return config;
}

// Returns whether the pixel is in a square that is kept out.
static bool is_out(const struct vw_kept_out *out, const struct vw_pixel *pixel) {
    uint32_t x = (uint32_t)pixel->x_px / VW_JUDGE_SQUARE_PX, y = (uint32_t)pixel->y_px / VW_JUDGE_SQUARE_PX;
    return out->squares[y * out->columns + x];
}

// Draws all of the photo's pixels as the tiles of splats and many as those of rays.
TEST(photos_train_without_the_squares_that_they_judge_by) {
    enum { DRAWN = 4096, TILE = 8 };
    struct vw_pixel pixels[TILE * TILE], *drawn = test_allocate(DRAWN, sizeof *drawn);
    for (size_t f = 0; f < VW_ARRAY_COUNT(fields); f++) {
        const struct vw_config config = judged_config(fields[f]);
        struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 0);
        for (uint32_t i = 0; i < trainer->photo_order.train_count; i++) {
            uint32_t view = trainer->photo_order.train_views[i], out = 0, kept = 0;
            struct vw_pixel_draw draw = {
                .seed = 5, .step = 1, .kept_out = vw_judges_kept_out(trainer->step.judges, view)};
            assert_non_null(draw.kept_out.squares);
            vw_pixels_draw(trainer->scene, view, &draw, DRAWN, drawn);
            for (uint32_t p = 0; p < DRAWN; p++)
                assert_int_equal(drawn[p].weight == 0.0f, is_out(&draw.kept_out, &drawn[p]));
            for (uint32_t y = 0; y < 18; y += TILE)
                for (uint32_t x = 0; x < 24; x += TILE) {
                    vw_pixels_take_tile(trainer->scene, view, &draw, (struct vw_photo_tile){x, y}, TILE, pixels);
                    for (uint32_t p = 0; p < TILE * TILE; p++) {
                        if (pixels[p].x_px > 24 || pixels[p].y_px > 18) continue; // beyond the photo
                        out += pixels[p].weight == 0.0f;
                        kept += pixels[p].weight != 0.0f;
                    }
                }
            assert_int_equal(out + kept, 24 * 18);
            assert_in_range(out, 1, TILE * TILE); // one square
        }
    }
}

// The means over the epoch's judges but the photo itself, by what the rows said of each.
struct means {
    double psnr_db, l1;
    bool own; // the photo judges in this epoch
};

static struct means mean_of(const struct vw_trainer *trainer, const struct vw_step_record *record,
                            const struct vw_view_error *of_views) {
    const struct vw_validation *validation = &trainer->validation;
    uint32_t group = vw_judges_group_of_epoch(&validation->judges, record->epoch), count = 0;
    struct means means = {0};
    double absolute = 0, values = 0;
    for (uint32_t i = validation->judges.group_starts[group]; i < validation->judges.group_starts[group + 1]; i++) {
        uint32_t view = validation->views[i];
        means.own |= view == record->view;
        if (view == record->view) continue;
        means.psnr_db += vw_psnr_db(of_views[view].mse);
        absolute += of_views[view].l1 * validation->pixel_counts[i];
        values += validation->pixel_counts[i];
        count++;
    }
    means.psnr_db /= count;
    means.l1 = absolute / values;
    return means;
}

static void check_rows(const struct vw_trainer *trainer, const struct vw_step_record *record,
                       struct vw_view_error *of_views, uint32_t *own) {
    const struct means before = mean_of(trainer, record, of_views);
    for (uint32_t i = 0; i < record->view_count; i++) {
        if (i > 0) assert_true(record->views[i].view > record->views[i - 1].view);
        of_views[record->views[i].view] = record->views[i];
    }
    const struct means after = mean_of(trainer, record, of_views);
    assert_int_equal(record->judged, record->step > 0);
    if (!record->step) return;
    *own += after.own;
    assert_true(fabs(record->val_psnr - after.psnr_db) <= 1e-9); // two ways to add doubles
    assert_true(fabs(record->val_l1 - after.l1) <= 1e-12);
    assert_true(fabs(record->val_psnr_before - before.psnr_db) <= 1e-9);
    assert_true(fabs(record->val_l1_before - before.l1) <= 1e-12);
}

TEST(a_row_has_what_all_judges_but_its_photo_had_before_and_after) {
    for (size_t f = 0; f < VW_ARRAY_COUNT(fields); f++) {
        struct vw_config config = judged_config(fields[f]);
        config.epochs = 6;
        struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 3);
        const struct vw_step_record *records = NULL;
        struct vw_view_error of_views[16] = {0};
        uint32_t count = 0, own = 0, steps = 0;
        do {
            ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
            for (uint32_t i = 0; i < count; i++, steps++) check_rows(trainer, &records[i], of_views, &own);
        } while (count);
        assert_int_equal(steps, 1 + 6 * 5);
        assert_in_range(own, 6 * 2, 6 * 3); // each judge trains once in its epoch
    }
}

TEST(judged_bits_depend_neither_on_submissions_nor_on_stops) {
    for (size_t f = 0; f < VW_ARRAY_COUNT(fields); f++) {
        const struct vw_config config = judged_config(fields[f]);
        const struct test_run *whole = test_run(test_scene(), &config, true, 0);
        test_run_assert_same(whole, test_run(test_scene(), &config, true, 1));
        test_run_assert_same(whole, test_run(test_scene(), &config, true, 4));
        test_run_assert_same(whole, test_run_in_parts(test_scene(), &config));
    }
}

TEST_GROUP(NULL, test_gpu_close)

// Bounds on one drawing of splats: its room for pairs, and how many views of an evaluation share it. Many views are
// drawn in several parts and show what they show in one.
// wrap: vw_gpu_get_limits
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/renderers/splats/splats.h"

static const struct vw_gpu_limits *pretended; // limits in place of the device's; NULL: its own

WRAPS(vw_gpu_get_limits);

const struct vw_gpu_limits *__wrap_vw_gpu_get_limits(const struct vw_gpu *gpu) {
    return pretended ? pretended : __real_vw_gpu_get_limits(gpu);
}

// ---- Room for pairs -------------------------------------------------------------------------------------------------

enum { PAIR_BYTES = 48, MILLION = 1000000 }; // a pair has VW_SPLAT_PAIR4 vec4 in its largest buffer

static const struct {
    const char *bound;
    uint32_t splats, views, tiles, bindable, pairs; // bindable: pairs in one binding
} rooms[] = {
    {"2048 per tile", 10000, 1, 100, 4 * MILLION, 204800},
    {"4 per sighting", 100000, 1, 10, 4 * MILLION, 400000},
    {"4 per sighting, three views", 100000, 3, 20, 4 * MILLION, 1200000},
    {"all splats on all tiles, few splats", 1000, 1, 10, 4 * MILLION, 10000},
    {"all splats on all tiles, few tiles", 1000, 8, 2, 4 * MILLION, 2000},
    {"one binding", 100000, 1, 10, 1000, 1000},
    {"2^22", 1 << 20, 2, 1024, 80 * MILLION, 1 << 22},
    {"2^22, of more sightings than 32 bits count", 1 << 20, 4096, 16, 80 * MILLION, 1 << 22},
};

TEST(pairs_have_room_within_every_bound) {
    const struct vw_radiance_field field = {0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(rooms); i++) {
        const struct vw_splat_room room = {.splats = rooms[i].splats, .views = rooms[i].views, .tiles = rooms[i].tiles};
        const uint64_t bytes = (uint64_t)PAIR_BYTES * rooms[i].bindable + PAIR_BYTES - 1;
        const struct vw_gpu_limits limits = {.storage_binding_bytes = bytes};
        pretended = &limits;
        uint32_t pairs = vw_splats_pair_room(&field, &room);
        pretended = NULL;
        if (pairs != rooms[i].pairs) fail_msg("%s: %u pairs, not %u", rooms[i].bound, pairs, rooms[i].pairs);
    }
}

// ---- Parts of an evaluation -----------------------------------------------------------------------------------------

enum { VIEWS = 129, PIXELS = 2, CELLS_MOST = 1 << 22, SIGHTINGS_MOST = 1 << 18 }; // PIXELS: of each view

// Photos are of so many tiles; 0: as small as the scene's. A last view is left for a part of its own.
static const struct {
    const char *bound;
    uint32_t splats, columns, rows, part_views;
} cases[] = {
    {"sightings", SIGHTINGS_MOST / 64, 0, 0, 64},
    {"cells", 300, 256, 128, CELLS_MOST / (256 * 128)},
};

struct drawn {
    uint32_t parts;
    struct vw_splat_room room; // that of the largest part
    vw_float4 colours[VIEWS * PIXELS];
};

// Draws two tiles of each of `count` views with an evaluator of its own.
static struct drawn *draw(struct vw_radiance_field *field, uint32_t first, uint32_t count) {
    struct drawn *drawn = test_allocate(1, sizeof *drawn);
    struct vw_pixel pixels[VIEWS * PIXELS] = {0};
    struct vw_evaluator evaluator = {0};
    for (uint32_t i = 0; i < count * PIXELS; i++)
        pixels[i] = (struct vw_pixel){
            .x_px = i % PIXELS ? 20.5f : 12.5f, .y_px = 9.5f, .view = first + i / PIXELS, .weight = 1.0f};
    ASSERT_OK(vw_evaluator_create(field, count * PIXELS, false, &evaluator));
    ASSERT_OK(vw_evaluator_render(&evaluator, pixels, count * PIXELS, drawn->colours));
    const struct vw_splat_evaluation *splats = vw_splat_evaluation_of(&evaluator);
    drawn->parts = splats->part_count;
    drawn->room = splats->drawing.room;
    assert_int_equal(splats->view_count, count);
    vw_evaluator_destroy(&evaluator);
    return drawn;
}

static struct vw_trainer *trainer_of_case(size_t i) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = VIEWS - 1, .val_views = 1, .width_px = 24, .height_px = 18});
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    config.splats = cases[i].splats;
    strcpy(config.effects, "none");
    struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 1);
    uint32_t side = vw_splat_step_of(&trainer->step)->drawing.specialization.side;
    for (uint32_t v = 0; v < VIEWS && cases[i].columns; v++) {
        scene->views[v].camera.width_px = cases[i].columns * side;
        scene->views[v].camera.height_px = cases[i].rows * side;
    }
    return trainer;
}

TEST_CASES(many_views_are_drawn_in_parts_and_show_the_same, i, VW_ARRAY_COUNT(cases)) {
    uint32_t most = cases[i].part_views, shown = 0;
    struct vw_trainer *trainer = trainer_of_case(i);
    const struct drawn *all = draw(&trainer->field, 0, VIEWS);
    if (all->parts != (VIEWS + most - 1) / most || all->room.views != most)
        fail_msg("%s: %u parts of up to %u views", cases[i].bound, all->parts, all->room.views);
    assert_true(all->room.cells <= CELLS_MOST);
    for (uint32_t ray = 0; ray < VIEWS * PIXELS; ray++) shown += all->colours[ray].w < 1.0f;
    assert_true(shown > VIEWS);
    for (uint32_t first = 0, count = VIEWS % most; first < VIEWS; first += count, count = most) {
        const struct drawn *one = draw(&trainer->field, first, count);
        assert_int_equal(one->parts, 1);
        assert_memory_equal(one->colours, &all->colours[first * PIXELS], count * PIXELS * sizeof *one->colours);
    }
}

TEST_GROUP(NULL, test_gpu_close)

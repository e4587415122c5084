#include "support/splat_bench.h"

#include "support/draws.h"
#include "support/gpu_fixture.h"
#include "train/model.h"

static void destroy_drawing(void *drawing) { vw_splat_drawing_destroy(drawing); }
static void destroy_gradient(void *gradient) { vw_splat_gradient_destroy(gradient); }

struct splat_pairs splat_bench_pairs(struct splat_bench *bench) {
    const struct vw_splat_drawing *drawing = &bench->drawing;
    return (struct splat_pairs){.shapes = test_read(drawing->shapes),
                                .seen = test_read(drawing->seen),
                                .ranks = test_read(drawing->pair_splats),
                                .sorted = test_read(drawing->sorted[drawing->digits % 2]),
                                .state = splat_bench_state(bench)};
}

void splat_bench_pixel(const struct splat_bench *bench, uint32_t ray, double *x, double *y) {
    uint32_t side = bench->s.side, pixels = side * side, corner = bench->tiles[ray / pixels].corner;
    *x = (corner & 0xffff) * side + ray % side + 0.5;
    *y = (corner >> 16) * side + ray % pixels / side + 0.5;
}

float *splat_bench_number(const struct splat_bench *bench, uint32_t splat, uint32_t column, uint32_t lane) {
    return &bench->params[4 * ((size_t)column * bench->room.splats + splat) + lane];
}

void splat_bench_splat(const struct splat_bench *bench, uint32_t splat, double numbers[REFERENCE_SPLAT_NUMBERS]) {
    for (uint32_t column = 0; column < bench->columns; column++)
        for (uint32_t lane = 0; lane < 4; lane++)
            numbers[4 * column + lane] = *splat_bench_number(bench, splat, column, lane);
}

struct reference_splat_view splat_bench_view(const struct splat_bench *bench, uint32_t view) {
    return reference_splat_view_of(&bench->cameras[view], &bench->views[view], &bench->s, bench->push.degree);
}

double splat_bench_certainty(const struct splat_bench *bench, uint32_t ray) {
    return bench->setup->uncertain ? (double)(0.05f + 0.9f * (float)(ray * 37 % 101) / 101.0f) : 1.0;
}

// ---- What is drawn --------------------------------------------------------------------------------------------------

static void draw_splats(struct splat_bench *bench) {
    const struct splat_case *setup = bench->setup;
    for (uint32_t splat = 0; splat < bench->count; splat++)
        for (uint32_t column = 0; column < bench->columns; column++)
            for (uint32_t lane = 0; lane < 4; lane++) {
                double draw = test_draw(setup->seed, splat, 4 * column + lane), value = draw;
                if (column == SPLAT_MEAN) value = lane < 3 ? 0.5 + 0.45 * draw : (double)setup->logit + 2.0 * draw;
                if (column == SPLAT_SCALE) value = lane < 3 ? (double)setup->log_scale + draw : 5e-5 * (1.0 + draw);
                if (column >= SPLAT_HARMONICS) value = lane < 3 ? (column == SPLAT_HARMONICS ? draw : 0.4 * draw) : 0.0;
                *splat_bench_number(bench, splat, column, lane) = (float)value;
            }
}

// Places camera `view` so that it looks at the middle of the box from a distance.
static struct vw_gpu_camera camera_at(const struct splat_bench *bench, uint32_t view) {
    double angle = 0.4 + 0.7 * view, distance = bench->setup->far_camera ? 300.0 : 1.3;
    double back[3] = {cos(angle) * 0.96, sin(angle) * 0.96, 0.28}, right[3] = {-sin(angle), cos(angle), 0.0};
    double up[3] = {back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
                    back[0] * right[1] - back[1] * right[0]};
    double depth = bench->setup->far_camera ? distance : 0.0, from = distance - depth;
    float focal = (float)((bench->setup->wide ? 0.25 : 0.9) * bench->setup->width_px * distance);
    return (struct vw_gpu_camera){
        .right = {(float)right[0], (float)right[1], (float)right[2], focal},
        .up = {(float)up[0], (float)up[1], (float)up[2], 1.1f * focal},
        .back = {(float)back[0], (float)back[1], (float)back[2], 0.5f * (float)bench->setup->width_px + 0.7f},
        .reference = {(float)(0.5 + from * back[0]), (float)(0.5 + from * back[1]), (float)(0.5 + from * back[2]),
                      (float)depth},
        .distortion = {(float)bench->setup->lens.k1, (float)bench->setup->lens.k2, (float)bench->setup->lens.p1,
                       (float)bench->setup->lens.p2},
        .higher = {(float)bench->setup->lens.k3, (float)bench->setup->lens.k4, (float)bench->setup->lens.k5,
                   (float)bench->setup->lens.k6},
        .more = {.x = 0.5f * (float)bench->setup->height_px - 0.4f, .w = bench->setup->lens.lens == VW_LENS_FISHEYE},
    };
}

// Returns the camera as a scene has it.
static struct vw_camera lens_of(const struct splat_bench *bench, const struct vw_gpu_camera *camera) {
    struct vw_camera lens = bench->setup->lens;
    lens.width_px = bench->setup->width_px;
    lens.height_px = bench->setup->height_px;
    lens.focal_x_px = camera->right.w;
    lens.focal_y_px = camera->up.w;
    lens.centre_x_px = camera->back.w;
    lens.centre_y_px = camera->more.x;
    return lens;
}

// Lists the tiles of most squares, square by square.
static void list_squares(struct splat_bench *bench, uint32_t view) {
    const struct vw_splat_view *own = &bench->views[view];
    uint32_t along = VW_SPLAT_SQUARE / bench->s.side;
    for (uint32_t top = 0; top < own->rows; top += along)
        for (uint32_t left = 0; left < own->columns; left += along)
            for (uint32_t i = 0; i < along * along && (top + left) / along != 1; i++)
                if (left + i % along < own->columns && top + i / along < own->rows)
                    bench->tiles[bench->tile_count++] = vw_splat_tile_at(own, view, left + i % along, top + i / along);
}

static void list_views(struct splat_bench *bench) {
    uint32_t cells = 0;
    bench->cameras = test_allocate(bench->room.views, sizeof *bench->cameras);
    bench->views = test_allocate(bench->room.views, sizeof *bench->views);
    for (uint32_t view = 0; view < bench->room.views; view++) {
        bench->cameras[view] = camera_at(bench, view);
        const struct vw_camera lens = lens_of(bench, &bench->cameras[view]);
        bench->views[view] = vw_splat_view_of(view, cells, &lens, bench->setup->lens_terms != 0, bench->s.side);
        cells += bench->views[view].columns * bench->views[view].rows;
    }
    bench->room.cells = cells;
    bench->tiles = test_allocate(cells, sizeof *bench->tiles);
    for (uint32_t view = 0; view < bench->room.views; view++) {
        struct vw_splat_view *own = &bench->views[view];
        uint32_t first = bench->tile_count;
        if (bench->setup->tiles == SQUARES_SOME) list_squares(bench, view);
        for (uint32_t row = 0; row < own->rows && bench->setup->tiles != SQUARES_SOME; row++)
            for (uint32_t column = 0; column < own->columns; column++)
                if (bench->setup->tiles == TILES_ALL || (row * 7 + column * 3 + view) % 4 != 1)
                    bench->tiles[bench->tile_count++] = vw_splat_tile_at(own, view, column, row);
        own->first_tile = first;
        own->tiles = bench->setup->walk_tiles && bench->setup->views > 1 ? bench->tile_count - first : 0;
    }
    bench->room.tiles = bench->room.listed_tiles = bench->tile_count;
}

static void draw_rays(struct splat_bench *bench) {
    uint32_t pixels = bench->s.side * bench->s.side;
    bench->ray_count = bench->tile_count * pixels;
    bench->rays = test_allocate(bench->ray_count, sizeof *bench->rays);
    for (uint32_t i = 0; i < bench->ray_count; i++) {
        const struct vw_splat_tile *tile = &bench->tiles[i / pixels];
        uint32_t x = (tile->corner & 0xffff) * bench->s.side + i % bench->s.side;
        uint32_t y = (tile->corner >> 16) * bench->s.side + i % pixels / bench->s.side;
        bool inside = x < bench->setup->width_px && y < bench->setup->height_px && (i * 2654435761u >> 16) % 11;
        float target[3];
        for (uint32_t c = 0; c < 3; c++) target[c] = 0.5f + 0.5f * (float)test_draw(bench->setup->seed, i, 100 + c);
        bench->rays[i].target_weight = (vw_float4){target[0], target[1], target[2], inside ? 1.0f : 0.0f};
    }
}

// ---- On the device --------------------------------------------------------------------------------------------------

static struct vw_buffer *filled(struct splat_bench *bench, const char *name, const void *data, uint64_t bytes) {
    struct vw_buffer *buffer = test_buffer(bench->gpu, name, bytes);
    if (data) ASSERT_OK(vw_buffer_write(buffer, 0, data, bytes));
    return buffer;
}

static void create_passes(struct splat_bench *bench) {
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_SPLATS, .buffer = bench->param_buffer},
        {.slot = VW_SLOT_CAMERAS, .buffer = bench->camera_buffer},
        {.slot = VW_SLOT_SPLAT_VIEWS, .buffer = bench->view_buffer},
        {.slot = VW_SLOT_RAYS, .buffer = bench->ray_buffer},
        {.slot = VW_SLOT_RAY_LOSS, .buffer = bench->ray_loss},
        {.slot = VW_SLOT_STEP_STATE, .buffer = bench->step_state},
        {.slot = VW_SLOT_OVERFLOW, .buffer = bench->overflow},
        {.slot = VW_SLOT_VISIBILITY, .buffer = bench->ray_weights, .unused = !bench->ray_weights},
        {.slot = VW_SLOT_SKY, .unused = true},
        {.slot = VW_SLOT_D_SKY, .unused = true},
        {.slot = VW_SLOT_RENDERED, .unused = true},
    };
    const struct vw_splat_pass_params params = {.gpu = bench->gpu,
                                                .specialization = &bench->s,
                                                .room = bench->room,
                                                .bindings = bindings,
                                                .binding_count = sizeof bindings / sizeof bindings[0],
                                                .ray_effects = bench->setup->uncertain};
    ASSERT_OK(vw_splat_drawing_create(&params, &bench->drawing));
    test_own(&bench->drawing, destroy_drawing);
    ASSERT_OK(vw_splat_gradient_create(&params, &bench->drawing, &bench->gradient));
    test_own(&bench->gradient, destroy_gradient);
    memcpy(vw_buffer_map(bench->drawing.tiles), bench->tiles, bench->tile_count * sizeof *bench->tiles);
    bench->submission = test_submission(bench->gpu);
}

static void create_buffers(struct splat_bench *bench) {
    uint64_t param_bytes = vw_splat_param_bytes(&bench->room);
    bench->param_buffer = filled(bench, "splats", bench->params, param_bytes);
    bench->camera_buffer = filled(bench, "cameras", bench->cameras, bench->room.views * sizeof *bench->cameras);
    bench->view_buffer = filled(bench, "splat_views", bench->views, bench->room.views * sizeof *bench->views);
    bench->ray_buffer = filled(bench, "rays", bench->rays, bench->ray_count * sizeof *bench->rays);
    bench->ray_loss = filled(bench, "ray_loss", NULL, 4 * (uint64_t)bench->ray_count);
    bench->step_state = filled(bench, "step_state", NULL, sizeof(struct vw_step_state));
    float(*weights)[2] = test_allocate(bench->ray_count, sizeof *weights);
    for (uint32_t i = 0; i < bench->ray_count; i++) weights[i][0] = (float)splat_bench_certainty(bench, i);
    if (bench->setup->uncertain)
        bench->ray_weights = filled(bench, "ray_weights", weights, bench->ray_count * sizeof *weights);
    bench->overflow = filled(bench, "overflow", NULL, 4 * VW_OVERFLOW_STRIDE);
}

static struct splat_case *with_defaults(const struct splat_case *setup) {
    struct splat_case *full = test_allocate(1, sizeof *full);
    *full = *setup;
    if (!full->count) full->count = 60;
    if (!full->width_px) full->width_px = 44;
    if (!full->height_px) full->height_px = 27;
    if (!full->views) full->views = 1;
    if (!full->pairs) full->pairs = 20000;
    if (full->log_scale == 0.0f) full->log_scale = -3.0f;
    return full;
}

struct splat_bench *splat_bench_open(const struct splat_case *setup) {
    struct splat_bench *bench = test_allocate(1, sizeof *bench);
    bench->setup = with_defaults(setup);
    setup = bench->setup;
    bench->gpu = test_gpu();
    bench->count = setup->count;
    bench->columns = VW_SPLAT_COLUMNS(setup->degree);
    const struct vw_specialization run = {.training = 1,
                                          .loss = setup->loss == SPLAT_L2 ? LOSS_L2 : LOSS_L1,
                                          .learning_rate = 1.0f,
                                          .beta1 = setup->momentum ? 0.9f : 0.0f,
                                          .momentum = setup->momentum,
                                          .effect_distortion = setup->lens_terms,
                                          .effect_uncertainty = setup->uncertain,
                                          .beta_min = 0.1f,
                                          .beta2 = 0.999f,
                                          .effect_background = BACKGROUND_FIXED,
                                          .background_red = 0.2f,
                                          .background_green = 0.7f,
                                          .background_blue = 0.4f,
                                          .inverse_rays = 1.0f / 512.0f};
    bench->s = vw_splat_specialise(&run, !setup->as_on_gpus);
    bench->s.ssim_weight = setup->ssim_weight;
    // A column has room for more splats than there are.
    bench->room = (struct vw_splat_room){
        .splats = setup->count + 5, .degree = setup->degree, .views = setup->views, .pairs = setup->pairs};
    list_views(bench);
    draw_rays(bench);
    bench->params = test_allocate((size_t)bench->columns * bench->room.splats * 4, sizeof(float));
    bench->push =
        (struct vw_push_splats){.count = setup->count,
                                .stride = bench->room.splats,
                                .degree = setup->degree,
                                .view_count = setup->views,
                                .tile_count = bench->tile_count,
                                .walked_tiles = setup->walk_tiles && setup->views == 1 ? bench->tile_count : 0};
    draw_splats(bench);
    create_buffers(bench);
    create_passes(bench);
    return bench;
}

void splat_bench_write(struct splat_bench *bench) {
    ASSERT_OK(vw_buffer_write(bench->param_buffer, 0, bench->params, vw_splat_param_bytes(&bench->room)));
}

struct vw_push_splat_update splat_bench_update(const struct splat_bench *bench) {
    return (struct vw_push_splat_update){.stride = bench->room.splats,
                                         .columns = VW_SPLAT_COLUMNS(bench->push.degree),
                                         .mean = 0.001f,
                                         .scale = 0.005f,
                                         .turn = 0.002f,
                                         .opacity = 0.025f,
                                         .colour = 0.0025f,
                                         .harmonics = 0.0001f,
                                         .adam = vw_adam_of(&bench->s.run)};
}

// Counts squares by their first tiles.
static uint32_t count_squares(const struct splat_bench *bench) {
    uint32_t count = 0, within = (VW_SPLAT_SQUARE / bench->s.side - 1) * 0x10001u;
    for (uint32_t i = 0; i < bench->tile_count; i++) count += (bench->tiles[i].corner & within) == 0;
    return count;
}

void splat_bench_run(struct splat_bench *bench, bool gradient, bool update) {
    const struct vw_push_splat_update by = splat_bench_update(bench);
    const struct vw_step_state fresh = {0};
    ASSERT_OK(vw_buffer_write(bench->step_state, 0, &fresh, sizeof fresh));
    bench->push.squares = count_squares(bench);
    vw_submission_begin(bench->submission);
    vw_splat_drawing_record(&bench->drawing, bench->submission, &bench->push);
    if (gradient) vw_splat_gradient_record(&bench->gradient, bench->submission, &bench->push);
    if (update) vw_splat_update_record(&bench->gradient, bench->submission, &by);
    test_submit(bench->submission);
}

struct vw_splat_state splat_bench_state(struct splat_bench *bench) {
    struct vw_splat_state state;
    ASSERT_OK(vw_buffer_read(bench->drawing.state, 0, &state, sizeof state));
    return state;
}

#include "train/renderers/splats/splats.h"

#include <assert.h>
#include <math.h>

static const float EPSILON = 1e-15f; // Adam's, as Kerbl et al. have it

struct vw_splat_specialization vw_splat_specialise(const struct vw_specialization *run, bool cpu) {
    struct vw_splat_specialization s = {.run = *run, .sort_digits = 256};
    s.run.gradient_quantum = EPSILON / run->inverse_rays;
    if (cpu) { // a vector of tiles, each with pairs of its own, fetches as many pairs at a time
        s.side = 8;
        s.lanes = 1;
        s.group = 8;
        s.sort_lanes = 16;
        s.sort_keys = 64;
        s.place_lanes = 64;
    } else {
        s.side = 16;
        s.lanes = s.group = 64;
        s.sort_lanes = 64;
        s.sort_keys = 16;
        s.sort_digits = 16; // so few that their counts fit the shared memory
        s.place_lanes = 256;
    }
    return s;
}

static uint32_t bits_of(uint32_t value) {
    uint32_t bits = 0;
    for (; value; value >>= 1) bits++;
    return bits;
}

uint32_t vw_splat_digit_bits(const struct vw_splat_specialization *s) {
    uint32_t bits = 1;
    while (1u << bits < s->sort_digits) bits++;
    return bits;
}

uint32_t vw_splat_sort_digits(const struct vw_splat_room *room, const struct vw_splat_specialization *s) {
    uint32_t digit_bits = vw_splat_digit_bits(s), key_bits = VW_SPLAT_DEPTH_BITS + bits_of(room->tiles);
    return (key_bits + digit_bits - 1) / digit_bits;
}

static enum vw_status check(const char *what, uint64_t value, uint64_t most, const char *remedy) {
    if (value && value <= most) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "splats: %llu %s, from 1 to %llu can be drawn; %s", (unsigned long long)value, what,
                   (unsigned long long)most, remedy);
}

enum vw_status vw_splat_check_room(const struct vw_splat_room *room, const struct vw_splat_specialization *s) {
    enum { TRIPS = 30000 }; // trips of one loop; an invocation has two
    uint64_t sightings = (uint64_t)room->splats * room->views;
    assert(s->lanes == 1 || s->group == s->lanes); // lanes of a tile meet at barriers, as often as it has pairs
    enum vw_status status =
        check("sightings", sightings, (uint64_t)TRIPS * s->place_lanes, "use fewer splats or views at once");
    if (!status) status = check("tiles", room->tiles, VW_SPLAT_TILES_MAX, "draw them in several parts");
    if (!status) status = check("cells", room->cells, (uint64_t)VW_SPLAT_CELLS_MAX * room->views, "use smaller photos");
    if (!status)
        status = check("pairs", room->pairs,
                       (uint64_t)TRIPS * s->place_lanes / s->sort_digits * s->sort_lanes * s->sort_keys,
                       "draw fewer tiles at once");
    if (status || room->degree <= VW_SPLAT_DEGREE_MAX) return status;
    return vw_fail(VW_ERROR_INPUT, "splats: harmonics of degree %u; 3 is the highest", room->degree);
}

uint64_t vw_splat_param_bytes(const struct vw_splat_room *room) {
    return 16 * (uint64_t)VW_SPLAT_COLUMNS(room->degree) * room->splats;
}

// ---- Views ----------------------------------------------------------------------------------------------------------

// Views as splats see them: a grid of tiles, and how far out its lens reaches.

static const double MARGIN = 0.15;     // share of a photo by which a centre may lie beside it before J stays as there
static const double REACH_MOST = 1e15; // so that its square is a float
enum { BORDER_STEPS = 8 };             // points along a side of a photo at which the lens is undone

// The range of x / z and y / z (y down) that the photo shows: least, most.
struct seen {
    double least[2], most[2];
};

static void widen(struct seen *seen, double x, double y) {
    const double at[2] = {x, y};
    for (int i = 0; i < 2; i++) {
        seen->least[i] = fmin(seen->least[i], at[i]);
        seen->most[i] = fmax(seen->most[i], at[i]);
    }
}

// Widens by a place of the border; where the lens has no inverse, by all that it reaches.
static void widen_by_border(const struct vw_camera *camera, double fold, double x_px, double y_px, struct seen *seen) {
    double direction[3];
    if (vw_camera_unproject(camera, x_px, y_px, direction)) {
        widen(seen, direction[0], -direction[1]);
    } else if (isfinite(fold)) {
        widen(seen, -fold, -fold);
        widen(seen, fold, fold);
    }
}

static struct seen seen_by(const struct vw_camera *camera, double fold) {
    struct seen seen = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (int i = 0; i <= BORDER_STEPS; i++) {
        double x_px = (double)camera->width_px * i / BORDER_STEPS, y_px = (double)camera->height_px * i / BORDER_STEPS;
        widen_by_border(camera, fold, x_px, 0.0, &seen);
        widen_by_border(camera, fold, x_px, camera->height_px, &seen);
        widen_by_border(camera, fold, 0.0, y_px, &seen);
        widen_by_border(camera, fold, camera->width_px, y_px, &seen);
    }
    return seen;
}

struct vw_splat_view vw_splat_view_of(uint32_t index, uint32_t first_cell, const struct vw_camera *camera, bool lens,
                                      uint32_t side) {
    struct vw_camera own = {.width_px = camera->width_px,
                            .height_px = camera->height_px,
                            .focal_x_px = camera->focal_x_px,
                            .focal_y_px = camera->focal_y_px,
                            .centre_x_px = camera->centre_x_px,
                            .centre_y_px = camera->centre_y_px};
    if (lens) own = *camera;
    double fold = vw_camera_fold(&own), margins[2];
    struct seen seen = seen_by(&own, fold);
    for (int i = 0; i < 2; i++) margins[i] = MARGIN * (seen.most[i] - seen.least[i]);
    return (struct vw_splat_view){
        .camera = index,
        .first_cell = first_cell,
        .columns = (camera->width_px + side - 1) / side,
        .rows = (camera->height_px + side - 1) / side,
        .slopes = {(float)(seen.least[0] - margins[0]), (float)(seen.least[1] - margins[1]),
                   (float)(seen.most[0] + margins[0]), (float)(seen.most[1] + margins[1])},
        .reach = (float)fmin(fold, REACH_MOST),
    };
}

struct vw_splat_tile vw_splat_tile_at(const struct vw_splat_view *view, uint32_t index, uint32_t column, uint32_t row) {
    return (struct vw_splat_tile){index, row << 16 | column, view->first_cell + row * view->columns + column};
}

// ---- Params of passes that a step and an evaluator share ------------------------------------------------------------

struct vw_splat_pass_params vw_splats_pass_params(const struct vw_radiance_field *field,
                                                  const struct vw_specialization *run,
                                                  struct vw_splat_specialization *specialization) {
    const struct vw_splat_model *splats = vw_splat_model_of(field->model);
    *specialization = vw_splat_specialise(run, vw_gpu_get_info(field->gpu)->kind == VW_GPU_CPU);
    specialization->ssim_weight = (float)field->model->config->ssim_weight;
    return (struct vw_splat_pass_params){.gpu = field->gpu,
                                         .specialization = specialization,
                                         .room = {.splats = splats->count, .degree = splats->degree}};
}

uint32_t vw_splats_pair_room(const struct vw_radiance_field *field, const struct vw_splat_room *room) {
    enum { PAIRS_PER_TILE = 2048, PAIRS_PER_SIGHTING = 4, PAIRS_MOST = 1 << 22 };
    uint64_t sightings = (uint64_t)room->splats * room->views;
    uint64_t pairs = (uint64_t)room->tiles * PAIRS_PER_TILE, every = (uint64_t)room->tiles * room->splats;
    if (pairs < sightings * PAIRS_PER_SIGHTING) pairs = sightings * PAIRS_PER_SIGHTING;
    if (pairs > every) pairs = every;
    uint64_t fit = vw_gpu_get_limits(field->gpu)->storage_binding_bytes / (sizeof(vw_float4) * VW_SPLAT_PAIR4);
    if (pairs > fit) pairs = fit;
    return (uint32_t)(pairs < PAIRS_MOST ? pairs : PAIRS_MOST);
}

struct vw_binding vw_splats_binding(const struct vw_radiance_field *field) {
    const struct vw_splat_model *splats = vw_splat_model_of(field->model);
    const struct vw_splat_room room = {.splats = splats->count, .degree = splats->degree};
    return (struct vw_binding){
        .slot = VW_SLOT_SPLATS, .buffer = field->params, .size_bytes = vw_splat_param_bytes(&room)};
}

struct vw_push_splats vw_splats_push(const struct vw_model *model) {
    const struct vw_splat_model *splats = vw_splat_model_of(model);
    return (struct vw_push_splats){
        .count = splats->count, .stride = splats->count, .degree = splats->degree, .view_count = 1};
}

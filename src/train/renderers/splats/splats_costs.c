// Loads, stores and products of the passes of splats (pass_costs.h). How many splats are seen and how many pairs they
// have is known only on the device: a splat counts as seen, with PAIRS_EACH pairs, of which all are drawn.
#include "base/memory.h"
#include "train/pass_costs.h"
#include "train/renderers/splats/splats_renderer.h"

static const double PAIRS_EACH = 2;
enum { BLENDED_OPERATIONS = 12, BLENDED_BACK_OPERATIONS = 28, PROJECTED_OPERATIONS = 150 }; // per pixel or splat

// The sizes of drawings that are alike.
struct work {
    double sightings, pixels, pixels_of_tile, columns, digits;
    double drawings; // how many drawings they are
    const char *role;
};

static void add_drawing(const struct work *w, struct vw_pass_costs *costs) {
    double pairs = w->sightings * PAIRS_EACH, harmonics = w->columns - SPLAT_HARMONICS, sorts = w->digits * w->drawings;
    const struct vw_pass_cost list[] = {
        {"mark_tiles", w->role, w->drawings, 0, w->pixels / w->pixels_of_tile * (sizeof(struct vw_splat_tile) + 4)},
        {"project_splats", w->role, w->drawings, w->sightings * PROJECTED_OPERATIONS,
         w->sightings * (16 * SPLAT_HARMONICS + sizeof(struct vw_splat_shape) + 4)},
        {"place_pairs", w->role, w->drawings, 0, w->sightings * 16},
        {"emit_pairs", w->role, w->drawings, 0, w->sightings * (sizeof(struct vw_splat_shape) + 8) + pairs * 12},
        {"colour_splats", w->role, w->drawings, w->sightings * harmonics * 3,
         w->sightings * (16 * (harmonics + 1 + VW_SPLAT_DRAWN4) + sizeof(struct vw_splat_shape))},
        {"count_digits", w->role, sorts, 0, w->digits * pairs * 8},
        {"place_digits", w->role, sorts, 0, w->digits * pairs},
        {"scatter_pairs", w->role, sorts, 0, w->digits * pairs * 24},
        {"blend_tiles", w->role, w->drawings, pairs * w->pixels_of_tile * BLENDED_OPERATIONS,
         pairs * (12 + 16 * VW_SPLAT_DRAWN4) + w->pixels * 16},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(list); i++) vw_pass_cost_add(costs, list[i]);
}

static struct work work_of(const struct vw_splat_drawing *drawing, const char *role, double views, double pixels) {
    double side = drawing->specialization.side;
    return (struct work){.sightings = views * drawing->room.splats,
                         .pixels = pixels,
                         .pixels_of_tile = side * side,
                         .columns = VW_SPLAT_COLUMNS(drawing->room.degree),
                         .digits = drawing->digits,
                         .drawings = 1,
                         .role = role};
}

void vw_splats_list_step_costs(const struct vw_step_passes *step, struct vw_pass_costs *costs) {
    const struct work w = work_of(vw_splats_step_drawing(step), NULL, 1, step->padded_rays);
    double pairs = w.sightings * PAIRS_EACH, moments = step->field->model->specialization.momentum ? 2 : 1;
    const struct vw_pass_cost list[] = {
        {"slope_pixels", NULL, 1, 0, w.pixels * (sizeof(struct vw_ray) + 36)},
        {"blend_tiles_back", NULL, 1, pairs * w.pixels_of_tile * BLENDED_BACK_OPERATIONS,
         pairs * (12 + 16 * (VW_SPLAT_DRAWN4 + VW_SPLAT_PAIR4)) + w.pixels * 32},
        {"backward_splats", NULL, 1, w.sightings * 2 * PROJECTED_OPERATIONS,
         pairs * 16 * VW_SPLAT_PAIR4 + w.sightings * 32 * w.columns},
        {"update_splats", NULL, 1, 0, w.sightings * w.columns * 16 * (3 + 2 * moments)},
    };
    add_drawing(&w, costs);
    if (step->field->model->splats.ssim_weight > 0.0f) {
        double taps = 3 * VW_SPLAT_SQUARE * (6 + 6 + 3 + 3); // moments and slopes of three channels, both ways
        vw_pass_cost_add(costs, (struct vw_pass_cost){"compare_windows", NULL, 1, w.pixels * taps,
                                                      w.pixels * (sizeof(struct vw_ray) + 32)});
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(list); i++) vw_pass_cost_add(costs, list[i]);
    const struct vw_effect_work work = {
        .step = step, .model = step->field->model, .rays = step->padded_rays, .chunks = 1};
    vw_effects_list_costs(&work, costs);
}

void vw_splats_list_evaluation_costs(const struct vw_evaluator *evaluator, struct vw_pass_costs *costs) {
    uint32_t views = 0, parts = vw_splats_count_parts(evaluator, &views);
    struct work w = work_of(vw_splats_evaluation_drawing(evaluator), evaluator_role, views, evaluator->ray_count);
    w.drawings = parts;
    add_drawing(&w, costs);
    vw_pass_cost_add(costs, (struct vw_pass_cost){"show_pixels", evaluator_role, parts, 0,
                                                  evaluator->ray_count * (sizeof(struct vw_ray) + 40.0)});
}

// Splats (--field splats). On the device: passes that draw a list of tiles, go back from the colours of their rays to
// the splats, and move these. Params, cameras, views and rays are the caller's; see shaders/interface.h for all
// layouts.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_H

#include "train/evaluator.h"
#include "train/passes.h"
#include "train/renderers/registry.h"
#include "train/step.h"
#include "viewworth/scene.h"

// Most tiles of a view on each of which a splat is tried, rather than on all cells in its box.
enum { VW_SPLAT_WALKED_TILES_MAX = 24 };

// The most that passes can be asked for.
struct vw_splat_room {
    uint32_t splats;       // room in a column of params: the stride
    uint32_t degree;       // highest degree of harmonics
    uint32_t views;        // per drawing
    uint32_t tiles;        // per drawing
    uint32_t listed_tiles; // in the list of tiles, which may serve many drawings
    uint32_t cells;        // in the map: the largest view's, or the sum over all views of one drawing
    uint32_t pairs;        // per drawing
};

// Returns the constants of splats on top of a run's; `cpu` chooses how the work is shared among invocations. It sets
// Adam's epsilon, of the mean gradient.
struct vw_splat_specialization vw_splat_specialise(const struct vw_specialization *run, bool cpu);
// Refuses, naming the number, more than the passes can count or key. VW_ERROR_INPUT.
enum vw_status vw_splat_check_room(const struct vw_splat_room *room, const struct vw_splat_specialization *s);
uint64_t vw_splat_param_bytes(const struct vw_splat_room *room);
// Fills in a view, number `index` of the cameras, as a grid of tiles. Without `lens` the camera is a pinhole.
struct vw_splat_view vw_splat_view_of(uint32_t index, uint32_t first_cell, const struct vw_camera *camera, bool lens,
                                      uint32_t side);
struct vw_splat_tile vw_splat_tile_at(const struct vw_splat_view *view, uint32_t index, uint32_t column, uint32_t row);
uint32_t vw_splat_digit_bits(const struct vw_splat_specialization *s);
// Returns 1 plus the largest digit shift of the sort, in digits.
uint32_t vw_splat_sort_digits(const struct vw_splat_room *room, const struct vw_splat_specialization *s);

struct vw_splat_pass_params {
    struct vw_gpu *gpu;
    const struct vw_splat_specialization *specialization;
    struct vw_splat_room room;
    // VW_SLOT_CAMERAS, VW_SLOT_SPLATS and VW_SLOT_SPLAT_VIEWS; for a gradient also VW_SLOT_RAYS, VW_SLOT_RAY_LOSS,
    // VW_SLOT_STEP_STATE, VW_SLOT_OVERFLOW, and the slots of effects.
    const struct vw_binding *bindings;
    uint32_t binding_count;
    const char *role;
    bool ray_effects; // sky, weights of rays, or photos fitted by fit_photo: the variants of compare_windows and
                      // slope_pixels
    bool depth;       // the variant of colour_splats
};

// Draws tiles. The host writes `tiles` (mapped), `record` draws a range of them.
struct vw_splat_drawing {
    struct vw_gpu_objects objects;
    struct vw_splat_room room;
    struct vw_splat_specialization specialization;
    uint32_t digits;
    struct vw_buffer *tiles;   // vw_splat_tile, VW_BUFFER_UPLOAD
    struct vw_buffer *colours; // vec4 per ray of the tiles of one drawing: blended rgb, and what is left of the light
    struct vw_buffer *state;   // vw_splat_state
    struct vw_buffer *map, *shapes, *sighting_pairs, *seen, *drawn, *pair_splats, *sorted[2], *counts, *ranges;
    struct vw_pass *mark, *project, *place, *emit, *colour, *count_digits[2], *place_digits, *scatter[2], *blend;
};
enum vw_status vw_splat_drawing_create(const struct vw_splat_pass_params *params, struct vw_splat_drawing *drawing);
void vw_splat_drawing_destroy(struct vw_splat_drawing *drawing);
// Records the drawing of the tiles that `push` names; `shift` and `pair_capacity` are set here.
void vw_splat_drawing_record(const struct vw_splat_drawing *drawing, struct vw_submission *submission,
                             const struct vw_push_splats *push);

// Goes back through a drawing of one view, and moves the splats that it saw.
struct vw_splat_gradient {
    struct vw_gpu_objects objects;
    const struct vw_splat_drawing *drawing; // borrowed
    struct vw_buffer *d_windows, *d_colours, *d_pairs, *d_splats, *moment1, *moment2;
    struct vw_pass *windows; // NULL without an SSIM weight
    struct vw_pass *slopes, *blend_back, *backward, *update;
};
enum vw_status vw_splat_gradient_create(const struct vw_splat_pass_params *params,
                                        const struct vw_splat_drawing *drawing, struct vw_splat_gradient *gradient);
void vw_splat_gradient_destroy(struct vw_splat_gradient *gradient);
// Records loss and gradients after the drawing of `push`, whose rays are made; view_count is 1.
void vw_splat_gradient_record(const struct vw_splat_gradient *gradient, struct vw_submission *submission,
                              const struct vw_push_splats *push);
// Records the step of the optimiser.
void vw_splat_update_record(const struct vw_splat_gradient *gradient, struct vw_submission *submission,
                            const struct vw_push_splat_update *push);

// ---- The renderer ---------------------------------------------------------------------------------------------------

// Unit of the rates: the learning rate of the passes is that of effects, as with the hash grid, at the default --lr.
#define VW_SPLAT_RATE_UNIT 0.001

// The sizes of splats, of a model. Their params are at the beginning of the block.
struct vw_splat_model {
    uint32_t count, degree; // splats; degree of their harmonics
    uint32_t source_count;  // points of the scene that they are made of, if more than `count` a draw of them; 0: none
    double extent;          // box edges, at most 1; of what the cameras stand around
};
static inline const struct vw_splat_model *vw_splat_model_of(const struct vw_model *model) {
    return model->of_renderer;
}

// Counts the points of a scene that a train view sees.
uint32_t vw_splats_count_points(const struct vw_model *model, const struct vw_scene *scene);
// Writes the initial values of all splats: at points, or, where train views see too few, where photos agree.
enum vw_status vw_splats_start(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                               float *params);
// Places splats on rays of train photos, at the depths that others agree on, in the colours of their pixels, and
// decodes the photos. The places that photos tell nothing of stay as they are. `means` in box coordinates, `colours` in
// [0,1].
enum vw_status vw_splats_place_by_photos(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                         uint32_t count, float (*means)[3], float (*colours)[3]);
// Adds splats to so many columns of params: a dome that shows the sky, whose coefficients these are. The new params
// replace
// `*params`, which the caller owns.
enum vw_status vw_splats_add_sky(const vw_float4 *sky, uint32_t columns, float **params, uint32_t *count);
// Writes the filters of splats for where they are; `held`: their scales hold the filter, which is taken out of them.
enum vw_status vw_splats_filter(const struct vw_model *model, const struct vw_scene *scene, bool held, float *params);
// Writes for each point its root mean square distance to the three nearest others, but at least `least`.
enum vw_status vw_splats_measure_gaps(const float (*points)[3], uint32_t count, float least, float *gaps);

// Returns params of passes, without room for views, tiles and pairs, and fills in `specialization`.
struct vw_splat_pass_params vw_splats_pass_params(const struct vw_radiance_field *field,
                                                  const struct vw_specialization *run,
                                                  struct vw_splat_specialization *specialization);
// Returns room for the pairs of a drawing: for tiles full of splats, for a picture of all splats, and never for more
// than the tiles can have or the device binds.
uint32_t vw_splats_pair_room(const struct vw_radiance_field *field, const struct vw_splat_room *room);
struct vw_binding vw_splats_binding(const struct vw_radiance_field *field);
struct vw_push_splats vw_splats_push(const struct vw_model *model);

// The part of a step.
struct vw_splat_step {
    struct vw_buffer *views;       // vw_splat_view per view of the scene; the step's objects own it
    struct vw_splat_view *listed;  // owned; the same on the host
    uint32_t cells;                // tiles of the largest photo that is trained on
    struct vw_drawn_photo *photos; // owned; by place in the step's pixels
    struct vw_photo_tile *drawn;   // owned; room for the tiles of one step
    struct vw_ray_passes of_rays;
    struct vw_splat_drawing drawing;
    struct vw_splat_gradient gradient;
};
static inline struct vw_splat_step *vw_splat_step_of(const struct vw_step_passes *step) { return step->of_renderer; }

// All drawings of an evaluator, as the device has them and as the host lists them.
struct vw_splat_evaluation {
    struct vw_splat_drawing drawing;
    struct vw_gpu_objects objects; // its pixels' number decides their sizes
    struct vw_buffer *view_list, *shown;
    struct vw_pass *show;
    struct vw_drawn_part *parts; // owned, as all that follow
    struct vw_splat_view *views;
    struct vw_splat_tile *tiles;
    struct vw_shown_pixel *pixels;
    size_t part_capacity, view_capacity, tile_capacity;
    uint32_t part_count, view_count, tile_count, pixel_count;
    struct vw_splat_room needed; // by the largest part, and listed_tiles
};
static inline struct vw_splat_evaluation *vw_splat_evaluation_of(const struct vw_evaluator *evaluator) {
    return evaluator->of_renderer;
}

extern const struct vw_renderer_step vw_splats_renderer_step;
extern const struct vw_renderer_evaluation vw_splats_renderer_evaluation;

#endif

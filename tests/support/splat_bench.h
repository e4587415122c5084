// A bench of splats: passes over random or given splats on one camera or several, with what tests read back.
#ifndef VIEWWORTH_TESTS_SUPPORT_SPLAT_BENCH_H
#define VIEWWORTH_TESTS_SUPPORT_SPLAT_BENCH_H

#include "reference/splats.h"
#include "support/cmocka_test.h"
#include "train/renderers/splats/splats.h"

// Zero means the default in brackets.
struct splat_case {
    const char *name;
    uint64_t seed;
    uint32_t count;                                     // [60]
    uint32_t degree;                                    // harmonics: 0 to 3
    uint32_t width_px, height_px;                       // [44, 27]
    uint32_t views;                                     // [1]
    uint32_t pairs;                                     // room for them [20,000]
    enum { TILES_ALL, TILES_SOME, SQUARES_SOME } tiles; // squares: tile by tile, as a step lists them
    bool as_on_gpus;                                    // shares tiles among invocations
    bool walk_tiles;                                    // tries every splat on all tiles of its view
    bool far_camera;                                    // 300 box edges away
    float log_scale;                                    // centre of the scales [-3]
    float logit;                                        // centre of the opacities [0]
    enum vw_splat_loss { SPLAT_L2, SPLAT_L1 } loss;
    uint32_t momentum;
    float ssim_weight;
    bool uncertain;        // the effect: rays count as splat_bench_certainty() says
    uint32_t lens_terms;   // DISTORTION_*
    struct vw_camera lens; // its coefficients
    bool wide;             // the camera sees far beyond the box
};

struct splat_bench {
    const struct splat_case *setup;
    struct vw_gpu *gpu;
    struct vw_splat_specialization s;
    struct vw_splat_room room;
    uint32_t count, columns, tile_count, ray_count;
    float *params; // [column][splat][4]
    struct vw_gpu_camera *cameras;
    struct vw_splat_view *views;
    struct vw_splat_tile *tiles;
    struct vw_ray *rays;
    struct vw_buffer *param_buffer, *camera_buffer, *view_buffer, *ray_buffer, *ray_loss, *step_state, *overflow;
    struct vw_buffer *ray_weights; // NULL unless they are uncertain
    struct vw_splat_drawing drawing;
    struct vw_splat_gradient gradient;
    struct vw_submission *submission;
    struct vw_push_splats push;
};

// Opens a bench with random splats in the box, which the test owns.
struct splat_bench *splat_bench_open(const struct splat_case *setup);
// Puts bench->params on the device.
void splat_bench_write(struct splat_bench *bench);
// Draws, and goes back and moves splats if asked for.
void splat_bench_run(struct splat_bench *bench, bool gradient, bool update);
struct vw_splat_state splat_bench_state(struct splat_bench *bench);
struct vw_push_splat_update splat_bench_update(const struct splat_bench *bench);
// The pairs of a drawing, sorted: shapes by sighting; by rank what was seen; the rank of each pair; keys and pairs.
struct splat_pairs {
    const struct vw_splat_shape *shapes;
    const struct vw_splat_seen *seen;
    const uint32_t *ranks, (*sorted)[2];
    struct vw_splat_state state;
};
struct splat_pairs splat_bench_pairs(struct splat_bench *bench);
// Finds the middle of a ray's pixel in its photo.
void splat_bench_pixel(const struct splat_bench *bench, uint32_t ray, double *x, double *y);
// Returns number `lane` of a column of a splat.
float *splat_bench_number(const struct splat_bench *bench, uint32_t splat, uint32_t column, uint32_t lane);
// Copies a splat as the reference reads it.
void splat_bench_splat(const struct splat_bench *bench, uint32_t splat, double numbers[REFERENCE_SPLAT_NUMBERS]);
// Returns how much a ray counts: 1 unless rays are uncertain.
double splat_bench_certainty(const struct splat_bench *bench, uint32_t ray);
struct reference_splat_view splat_bench_view(const struct splat_bench *bench, uint32_t view);

#endif

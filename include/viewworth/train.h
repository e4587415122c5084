// Training: configuration, effects, and the trainer that turns steps into step records.
#ifndef VIEWWORTH_TRAIN_H
#define VIEWWORTH_TRAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/hash.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/step_record.h"

enum vw_loss { VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER };
enum vw_optimizer {
    VW_OPTIMIZER_LAZY_ADAM,  // a grid entry without gradient keeps its moments and its own step count (decision 4)
    VW_OPTIMIZER_DENSE_ADAM, // every entry decays every step
    VW_OPTIMIZER_SGD,        // plain gradient descent on the mean gradient
};

// What transparent training pixels are composited on, where the effect `background` is on and no `sky` stands behind the field. Validation
// and rendering take the scene's colour.
enum vw_background_form {
    VW_BACKGROUND_FIXED,  // the scene's colour
    VW_BACKGROUND_RANDOM, // one drawn for every ray and step, so that no field can hide floaters of the scene's colour
};

// What a run's seed decides (decision 12). Where it is but one of these, the others go by the base seed.
enum vw_vary {
    VW_VARY_ALL,
    VW_VARY_ORDER,  // of the photos in every epoch
    VW_VARY_PIXELS, // those of every step, redraws included; jitter, random backgrounds, and where occupancy looks
    VW_VARY_INIT,   // of the params
};

// In which the hash grid's features are stored and read. There is no other copy of them; arithmetic and moments are float32 in both.
enum vw_table_precision {
    VW_TABLE_FLOAT32,
    VW_TABLE_FLOAT16, // an entry moves to the half nearest to where it should; what would leave the halves (65504) stays
};

// Everything that decides a run's bits besides scene, seed, device and version. Defaults: vw_config_default().
struct vw_config {
    uint64_t seed;           // 0 to 2^63-1; of what varies
    enum vw_vary vary;       // VW_VARY_ALL, but for runs that are to differ in one respect alone
    uint64_t base_seed;      // 0 to 2^63-1; of what does not vary; 0 with VW_VARY_ALL
    uint32_t epochs;         // not part of the run's identity: a run can be extended
    uint32_t burn_in_epochs; // first epochs that do not count into scores
    uint32_t rays;           // per step, 1 to 65536
    uint32_t samples;        // per ray, 1 to 4096
    uint32_t val_rays;       // in total; at least 32 per validation view are taken. Those that appearance is fitted on come on top
    enum vw_loss loss;
    enum vw_optimizer optimizer;
    double learning_rate;     // 1e-12 to 1e6; constant
    double beta1;             // [0,1); 0: no momentum
    double beta2;             // [0,1)
    uint32_t levels;          // of the hash grid, 1 to 16; levels * features is a multiple of 4
    uint32_t features;        // per entry, 2 or 4
    uint32_t log2_table;      // entries per level at most 2^log2_table, 0 to 22
    uint32_t base_resolution; // cells per axis of level 0, 1 to 1024
    double growth;            // resolution ratio of neighbouring levels, 1 to 4
    uint32_t width;           // of the hidden layers: 16, 32 or 64
    enum vw_background_form background;
    enum vw_table_precision table_precision;
    char effects[256]; // as --effects takes it: auto | none | LIST | +a,-b
    bool noise_floor;  // probe every photo's steps now and then (vw_step_record.probes); needs validation
    // From this many states, at ends of epochs evenly spread behind burn-in, probe a step on every photo; at most one per such epoch, 0:
    // none. Where they lie depends on `epochs`, which then is part of the run's identity. Needs validation
    uint32_t same_state;
    bool first_order; // probe the slope of validation along every step behind burn-in; needs validation
};

extern const struct vw_config vw_config_default;
// Checks every range; the message names the option.
enum vw_status vw_config_check(const struct vw_config *config);
// What an option ("rays", without dashes) admits, in words: "1 to 65536", "a power of two, 16 to 64". False when it sets no number.
enum { VW_CONFIG_RANGE_BYTES = 64 };
bool vw_config_range(const char *option, char text[VW_CONFIG_RANGE_BYTES]);
// The seed of one kind of draws: VW_VARY_ORDER, VW_VARY_PIXELS or VW_VARY_INIT.
uint64_t vw_config_seed_of(const struct vw_config *config, enum vw_vary draws);
// The same training without what probes it: it makes the same field.
struct vw_config vw_config_without_probes(const struct vw_config *config);
// Canonical JSON (sorted keys), owned by the caller. `identity_only` leaves out epochs and the wording of effects. Without `vary` and
// `base_seed` everything varies; without `table_precision` it is float32.
char *vw_config_to_json(const struct vw_config *config, bool identity_only);
enum vw_status vw_config_from_json(const char *json, struct vw_config *config);

const char *vw_loss_name(enum vw_loss loss);                            // "l1", "l2", "huber"
const char *vw_optimizer_name(enum vw_optimizer optimizer);             // "lazy-adam", "dense-adam", "sgd"
const char *vw_background_name(enum vw_background_form form);           // "fixed", "random"
const char *vw_vary_name(enum vw_vary vary);                            // "all", "order", "pixels", "init"
const char *vw_table_precision_name(enum vw_table_precision precision); // "float32", "float16"

// ---- Effects (decision 7) ------------------------------------------------------------------------------------------

enum { VW_EFFECT_COUNT_MAX = 16 };

struct vw_effect_verdict {
    const char *name; // "distortion", "background"
    bool called_for;  // evidence >= threshold
    double evidence;  // what was measured of the scene; NaN where it cannot tell, which calls for nothing
    double threshold;
    const char *meaning; // what the evidence is, with its unit
    bool on;             // after --effects
};

// Every known effect, in registry order, with nothing measured and nothing on.
void vw_effects_list(struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX], uint32_t *count);
// Switches effects on as they are called for and as `effects` wants it. What +a,-b does not name goes with the effects that it needs, and
// gives way to those that it cannot stand beside. VW_ERROR_USAGE when `effects` names an unknown one.
enum vw_status vw_effects_choose(const char *effects, struct vw_effect_verdict *verdicts, uint32_t count);
// Whether the effect of that name is on; false for one that is not in the list.
bool vw_effects_is_on(const struct vw_effect_verdict *verdicts, uint32_t count, const char *name);
// Whether an effect is on that fits every measured view by its left half, so that it is scored on its right half alone.
bool vw_effects_fit_views(const struct vw_effect_verdict *verdicts, uint32_t count);
// Measures the scene and chooses. Some evidence takes a probing run on `gpu`, of about a second; without a device (NULL), without photos to
// train on, or where `effects` leaves nothing to the evidence, there is none, and what it would tell is NaN. The same scene on the same
// device gets the same verdicts.
enum vw_status vw_effects_decide(struct vw_gpu *gpu, const struct vw_scene *scene, const char *effects,
                                 struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX], uint32_t *count);

// ---- The trainer ---------------------------------------------------------------------------------------------------

struct vw_trainer;

struct vw_trainer_params {
    struct vw_gpu *gpu;           // outlives the trainer
    const struct vw_scene *scene; // outlives the trainer; split train and (when validating) val not empty
    const struct vw_config *config;
    const struct vw_effect_verdict *effects; // decided or recorded verdicts, in registry order; NULL: vw_effects_decide() without a device
    uint32_t effect_count;
    bool validate;            // render the validation rays after every step (`value`), or not (`train`)
    uint32_t steps_per_batch; // 0: chosen from the time a step takes; does not change a bit of the result
};

enum vw_status vw_trainer_create(const struct vw_trainer_params *params, struct vw_trainer **trainer);
void vw_trainer_destroy(struct vw_trainer **trainer);

uint64_t vw_trainer_total_steps(const struct vw_trainer *trainer);              // epochs * train views; steps run from 1 to this
uint64_t vw_trainer_epoch_end(const struct vw_trainer *trainer, uint64_t step); // the last step of the epoch that `step` is in
// The verdicts that the trainer follows, in registry order.
const struct vw_effect_verdict *vw_trainer_effects(const struct vw_trainer *trainer, uint32_t *count);
// The views validated on, in the order of vw_step_record.views: scene indices.
const uint32_t *vw_trainer_validation_views(const struct vw_trainer *trainer, uint32_t *count);
// Runs one more batch of steps (the first call begins with step 0, the untrained field) and lends their records until the next call.
// count = 0 when the run is complete.
enum vw_status vw_trainer_advance(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count);
// The same without submitting more: hands out what is in flight. count = 0 when nothing is, and the state on the device is that after
// the last step handed out.
enum vw_status vw_trainer_collect(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count);
// Takes no step beyond `step` until called again with a later one: once all up to it are handed out, vw_trainer_advance gives count = 0 as
// at the end of the run. To be called before a step beyond it was submitted: before the first advance, or after count = 0. Where a run is
// held changes no bit of its steps.
void vw_trainer_hold_after(struct vw_trainer *trainer, uint64_t step);

// A checkpoint (decision 11): run_id, step, params and moments as a file, written beside its place, synced and moved there. To be called
// when nothing is in flight (see vw_trainer_collect).
enum vw_status vw_trainer_save_checkpoint(struct vw_trainer *trainer, const char *path);
// Goes on from a checkpoint: the next step is the one after `*step`, and the records are those of an uninterrupted run. VW_ERROR_INPUT when
// the file is missing, damaged or of another run, VW_ERROR_USAGE when it is of a later step than `last_step`: the trainer is then
// untouched. Before the first advance only.
enum vw_status vw_trainer_load_checkpoint(struct vw_trainer *trainer, const char *path, uint64_t last_step, uint64_t *step);

// The trained field as a file (OUT/field.vwf): config, box and params, so that it renders without the scene's photos.
enum vw_status vw_trainer_save_field(struct vw_trainer *trainer, const char *path);
enum vw_status vw_trainer_load_field(struct vw_trainer *trainer, const char *path); // VW_ERROR_INPUT when it does not fit the trainer
// Renders a whole view with bin-centre samples: rgb floats, width * height * 3, rows top to bottom, owned by the caller.
enum vw_status vw_trainer_render(struct vw_trainer *trainer, uint32_t view, float **rgb);

// How near the field comes to each of these views (scene indices): validation's passes, on all usable pixels, or on `pixels_max` of them
// spread evenly over a view that has more. Where validation fits a gain and a bias to the left half of a view and scores the right one, so
// does this. `errors` has one entry per view. When nothing is in flight (see vw_trainer_collect).
enum vw_status vw_trainer_measure_views(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count, uint32_t pixels_max,
                                        struct vw_view_error *errors);

// The same for all pixels of one view, which are handed out: as the field shows them, with the gain and bias that validation fits, and as
// the photo has them.
struct vw_whole_view {
    uint32_t width_px, height_px;
    float *rendered, *photo; // owned; rgb floats, rows top to bottom; not clamped to [0,1]
    uint8_t *counts;         // owned; by pixel: 1 for those that are usable and scored, else 0
    struct vw_view_error error;
};
enum vw_status vw_trainer_measure_whole(struct vw_trainer *trainer, uint32_t view, struct vw_whole_view *whole);
void vw_whole_view_free(struct vw_whole_view *whole);

// What the run is: hash of scene, subset, config (without epochs), seed, effects that are on and the box that they choose,
// whether every step is validated, shaders, version, device and driver.
enum vw_status vw_trainer_run_id(const struct vw_trainer *trainer, uint8_t run_id[32]);
void vw_trainer_subset_hash(const struct vw_trainer *trainer, uint8_t hash[32]);
void vw_shader_hash(uint8_t hash[32]); // of all embedded shaders
const char *vw_version(void);          // "0.1.0"

struct vw_trainer_stats {
    uint64_t param_count, device_bytes;
    uint64_t clamped_count, nonfinite_steps, floored_steps;
    uint32_t val_rays;         // actually taken and scored
    uint64_t same_state_steps; // taken as probes by this trainer
    double same_state_s;       // wall clock that they took
};
void vw_trainer_get_stats(const struct vw_trainer *trainer, struct vw_trainer_stats *stats);

// What a pass has to do in one step with its validation, from the sizes alone, to hold its time (vw_gpu_timers) against the device's
// ceilings.
struct vw_pass_cost {
    const char *name, *role;     // as the timer's
    double dispatches;           // per step, on average
    double multiply_adds, bytes; // of floats; loaded plus stored, gathers counted every time
};
enum { VW_PASS_COSTS_MAX = 24 };
void vw_trainer_pass_costs(const struct vw_trainer *trainer, struct vw_pass_cost costs[VW_PASS_COSTS_MAX], uint32_t *count);

#endif

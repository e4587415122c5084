// Training: its configuration, and the effects it may simulate.
#ifndef VIEWWORTH_TRAIN_H
#define VIEWWORTH_TRAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_loss { VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER };
enum vw_optimizer {
    VW_OPTIMIZER_LAZY_ADAM,  // a grid entry without gradient keeps its moments and its own step count (decision 4)
    VW_OPTIMIZER_DENSE_ADAM, // every entry decays every step
    VW_OPTIMIZER_SGD,        // plain gradient descent on the mean gradient
};

// What transparent training pixels are composited on, where the effect `background` is on and no `sky` stands behind
// the field. Validation and rendering take the scene's colour.
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

// In which the hash grid's features are stored and read. There is no other copy of them; arithmetic and moments are
// float32 in both.
enum vw_table_precision {
    VW_TABLE_FLOAT32,
    VW_TABLE_FLOAT16, // an entry moves to the half nearest to where it should; what would leave the halves (65504)
                      // stays
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
    uint32_t
        val_rays; // in total; at least 32 per validation view are taken. Those that appearance is fitted on come on top
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
    // From this many states, at ends of epochs evenly spread behind burn-in, probe a step on every photo; at most one
    // per such epoch, 0: none. Where they lie depends on `epochs`, which then is part of the run's identity. Needs
    // validation
    uint32_t same_state;
    bool first_order; // probe the slope of validation along every step behind burn-in; needs validation
};

extern const struct vw_config vw_config_default;
// Checks every range; the message names the option.
enum vw_status vw_config_check(const struct vw_config *config);
// What an option ("rays", without dashes) admits, in words: "1 to 65536", "a power of two, 16 to 64". False when it
// sets no number.
enum { VW_CONFIG_RANGE_BYTES = 64 };
bool vw_config_range(const char *option, char text[VW_CONFIG_RANGE_BYTES]);
// The seed of one kind of draws: VW_VARY_ORDER, VW_VARY_PIXELS or VW_VARY_INIT.
uint64_t vw_config_seed_of(const struct vw_config *config, enum vw_vary draws);
// The same training without what probes it: it makes the same field.
struct vw_config vw_config_without_probes(const struct vw_config *config);
// Canonical JSON (sorted keys), owned by the caller. `identity_only` leaves out epochs and the wording of effects.
// Without `vary` and `base_seed` everything varies; without `table_precision` it is float32.
char *vw_config_to_json(const struct vw_config *config, bool identity_only);
enum vw_status vw_config_from_json(const char *json, struct vw_config *config);

const char *vw_loss_name(enum vw_loss loss);                            // "l1", "l2", "huber"
const char *vw_optimizer_name(enum vw_optimizer optimizer);             // "lazy-adam", "dense-adam", "sgd"
const char *vw_background_name(enum vw_background_form form);           // "fixed", "random"
const char *vw_vary_name(enum vw_vary vary);                            // "all", "order", "pixels", "init"
const char *vw_table_precision_name(enum vw_table_precision precision); // "float32", "float16"

// ---- Effects (decision 7) ----

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
// Switches effects on as they are called for and as `effects` wants it. What +a,-b does not name goes with the effects
// that it needs, and gives way to those that it cannot stand beside. VW_ERROR_USAGE when `effects` names an unknown
// one.
enum vw_status vw_effects_choose(const char *effects, struct vw_effect_verdict *verdicts, uint32_t count);
// Whether the effect of that name is on; false for one that is not in the list.
bool vw_effects_is_on(const struct vw_effect_verdict *verdicts, uint32_t count, const char *name);
// Whether an effect is on that fits every measured view by its left half, so that it is scored on its right half alone.
bool vw_effects_fit_views(const struct vw_effect_verdict *verdicts, uint32_t count);

VW_PUBLIC_END

#endif

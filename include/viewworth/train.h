// Training: its configuration, and the effects it may simulate.
#ifndef VIEWWORTH_TRAIN_H
#define VIEWWORTH_TRAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

// ---- Configuration -------------------------------------------------------------------------------------------------

enum vw_loss { VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER };
enum vw_optimizer {
    VW_OPTIMIZER_LAZY_ADAM,  // a grid entry without gradient keeps its moments and its own step count (decision 4)
    VW_OPTIMIZER_DENSE_ADAM, // every entry decays every step
    VW_OPTIMIZER_SGD,        // plain gradient descent on the mean gradient
};

// The background of transparent training pixels when the effect `background` is on and `sky` is off. Validation and
// rendering use the scene's colour.
enum vw_background_form {
    VW_BACKGROUND_FIXED,  // the scene's colour
    VW_BACKGROUND_RANDOM, // a colour drawn for every ray and step, so that floaters of the scene's colour cannot hide
};

// The draws that a run's seed decides (decision 12). When it decides one kind of draws only, the base seed decides the
// others. The pixels that validation uses are the same in all runs, whatever their seeds, unless they are named.
enum vw_vary {
    VW_VARY_ALL,            // order, pixels and initial params
    VW_VARY_ORDER,          // the order of the photos in every epoch
    VW_VARY_PIXELS,         // the pixels of every step (resampled ones too), jitter, random backgrounds
    VW_VARY_INIT,           // the initial params
    VW_VARY_VALIDATION,     // the validation pixels, those that appearance is fitted on too; nothing of the training
    VW_VARY_ALL_VALIDATION, // all, and the validation pixels
};

// The model that is trained. All but splats turn samples of rays into colour and density.
enum vw_field {
    VW_FIELD_HASH,   // a multiresolution hash grid and two small networks (instant-ngp)
    VW_FIELD_MLP,    // positional encodings and one deep network (NeRF)
    VW_FIELD_SPLATS, // Gaussian splats (3DGS), drawn rather than sampled along rays
    VW_FIELD_COUNT,
    VW_FIELD_AUTO = VW_FIELD_COUNT, // none yet: whoever opens a run chooses by the scene (vw_run_params)
};

// The model evaluated at the even samples to place importance samples.
enum vw_coarse_network {
    VW_COARSE_NETWORK_SHARED, // the field itself
    VW_COARSE_NETWORK_OWN,    // a network of its shape, trained beside it by its own colours (NeRF); of VW_FIELD_MLP
};

// At least so many validation rays are taken per view, whatever vw_config.val_rays says.
enum { VW_VAL_RAYS_PER_VIEW_MIN = 32 };

enum { VW_PILOT_STEPS_MOST = 100000, VW_INITIAL_PATH_BYTES = 1024 };
#define VW_PILOT_STEPS_AUTO UINT32_MAX

// Everything that decides a run's bits besides scene, device and version. Defaults: vw_config_default.
struct vw_config {
    uint64_t seed;           // 0 to 2^63-1; decides what `vary` names
    enum vw_vary vary;       // VW_VARY_ALL, except in runs that differ in one kind of draws only, or in validation
    uint64_t base_seed;      // 0 to 2^63-1; decides the other draws; 0 with VW_VARY_ALL and VW_VARY_ALL_VALIDATION
    uint32_t epochs;         // not part of the run's identity: a run can be extended
    uint32_t burn_in_epochs; // first epochs, excluded from scores
    uint32_t rays;           // per step, 1 to 65536
    uint32_t samples;        // per ray, 1 to 4096, at even distances
    // Per ray, up to 4096, placed where the even ones show matter; training and rendering then use only these. 0: none
    uint32_t importance_samples;
    enum vw_coarse_network coarse_network; // VW_COARSE_NETWORK_SHARED without importance samples
    uint32_t val_rays;                     // in total; the rays that appearance is fitted on are not counted
    enum vw_loss loss;
    double huber_length; // colour difference beyond which VW_LOSS_HUBER is linear, 0.001 to 1; 0.1 under other losses
    double ssim_weight;  // share of the loss of VW_FIELD_SPLATS that is 1 - SSIM, 0 to 1; 0 with other fields
    double beta_min;     // least uncertainty of a colour with transient or uncertainty, 0.001 to 10
    double consistency_weight; // weight of HA-NeRF's consistency loss (appearance_encoder), 0 to 1000; 0: none
    enum vw_optimizer optimizer;
    double learning_rate; // 1e-12 to 1e6; at the first step
    // Share of it at the last step of `decay_epochs`, towards which it falls by the same factor from step to step; it
    // stays there afterwards; 1e-6 to 1
    double learning_rate_decay;
    uint32_t decay_epochs; // 0: `epochs`; a run that begins sets it to these, so that more epochs extend it
    double beta1;          // [0,1); 0: no momentum
    double beta2;          // [0,1)
    enum vw_field field;
    uint32_t mlp_depth;       // layers of the trunk of VW_FIELD_MLP, 1 to 16; 8 with other fields
    uint32_t frequencies;     // the same: of the encoding of positions, 0 to 16; 10 with the other
    uint32_t levels;          // levels of the hash grid, 1 to 16; levels * features is a multiple of 4
    uint32_t features;        // per entry, 2 or 4
    uint32_t log2_table;      // a level has at most 2^log2_table entries, 0 to 22
    uint32_t base_resolution; // cells per axis of level 0, 1 to 1024
    double growth;            // resolution ratio of neighbouring levels, 1 to 4
    uint32_t width;           // width of the hidden layers: 16, 32 or 64; for VW_FIELD_MLP a multiple of 8, 16 to 512
    // Splats of VW_FIELD_SPLATS, up to 1,048,576; 0: as many as the scene has points, but at least 8,192.
    uint32_t splats;
    uint32_t harmonics; // degree of the harmonics of colours of VW_FIELD_SPLATS, 0 to 3; 1 with others
    // The .ply file whose splats VW_FIELD_SPLATS begins with; "": the scene's points. A run makes the path absolute,
    // notes the file's SHA-256, and sets `splats` to how many it has. The path is not part of the run's identity.
    char initial[VW_INITIAL_PATH_BYTES], initial_sha256[VW_HASH_HEX_BYTES];
    enum vw_background_form background;
    char effects[256]; // as --effects takes it: auto | none | LIST | +a,-b
    // Steps of each pilot that decides on effects; 0: no pilots; VW_PILOT_STEPS_AUTO: by the length of the run. It does
    // not belong to the run's identity, which names the effects that are on.
    uint32_t pilot_steps;
};

// Has no field yet, and the numbers of a hash grid.
extern const struct vw_config vw_config_default;
// Returns the default config with a field and its own defaults: for VW_FIELD_MLP, NeRF's width of 256 and learning rate
// of 5e-4; for VW_FIELD_SPLATS, 12 squares of 16 x 16 pixels per step, 3 times the usual rates of 3DGS, of which that
// of positions decays to a hundredth, beta2 0.999, and 4096 validation rays.
struct vw_config vw_config_of_field(enum vw_field field);
// Gives a config without a field one, with the field's own defaults for all numbers that are those of
// vw_config_default, unless their bits (vw_config_explicit) say that they are meant.
void vw_config_take_field(enum vw_field field, uint64_t explicit_fields, struct vw_config *config);
// Checks every range, and that the field, if there is one, has what is set; the message names the option.
enum vw_status vw_config_check(const struct vw_config *config);
// Returns whether the learning rate stays the same, so that steps do not depend on the planned epochs.
bool vw_config_rate_is_constant(const struct vw_config *config);

// ---- Fields of the config: what options, JSON, checks and help follow from ----

enum vw_config_kind {
    VW_CONFIG_WHOLE,  // uint32_t
    VW_CONFIG_POWER,  // uint32_t, a power of two
    VW_CONFIG_EIGHTS, // uint32_t, a multiple of 8
    VW_CONFIG_SEED,   // uint64_t of 63 bits, as the ledger keeps it
    VW_CONFIG_REAL,   // double
    VW_CONFIG_CHOICE, // an enum of 32 bits, by its names
};
struct vw_config_field {
    const char *key, *option; // in JSON; as options spell it, without dashes
    enum vw_config_kind kind;
    size_t offset;      // in struct vw_config
    uint32_t fields;    // a bit for every enum vw_field that has it; for the others it keeps its default
    bool identity;      // part of what the run is
    double least, most; // the range; a choice has 0 and its last
    struct {
        bool differs;
        double value;
    } own[VW_FIELD_COUNT];    // defaults that differ from vw_config_default
    const char *const *names; // names of the values of a choice
};
enum { VW_CONFIG_RANGE_BYTES = 64 };
// Lists the fields, but for effects, pilot_steps, base_seed and initial. vw_config_find() returns that of an option;
// NULL: none.
const struct vw_config_field *vw_config_fields(uint32_t *count);
const struct vw_config_field *vw_config_find(const char *option);
// Returns the bit of vw_run_params.explicit_fields of an option; 0: it sets no field.
uint64_t vw_config_explicit(const char *option);
// Reads a field, and copies it.
double vw_config_get(const struct vw_config *config, const struct vw_config_field *field);
void vw_config_copy(const struct vw_config *from, const struct vw_config_field *field, struct vw_config *to);
// Says the range in words: "1 to 65536", "a power of two, 16 to 64"; "" of a choice.
void vw_config_describe_range(const struct vw_config_field *field, char text[VW_CONFIG_RANGE_BYTES]);

// Returns the seed of one kind of draws: VW_VARY_ORDER, VW_VARY_PIXELS, VW_VARY_INIT or VW_VARY_VALIDATION, which is 0
// unless validation pixels vary.
uint64_t vw_config_seed_of(const struct vw_config *config, enum vw_vary draws);
// Returns canonical JSON (sorted keys), owned by the caller. `identity_only` leaves out epochs and the wording of
// effects. vw_config_from_json() reads it back; a key of a field that is missing is VW_ERROR_INPUT.
char *vw_config_to_json(const struct vw_config *config, bool identity_only);
enum vw_status vw_config_from_json(const char *json, struct vw_config *config);

// Lets the rate fall over the epochs that there are now, unless it stays or that is settled.
void vw_config_settle_decay(struct vw_config *config);
// Sets the number of epochs, and the decay of the rate to the same share of them.
void vw_config_set_epochs(struct vw_config *config, uint32_t epochs);

const char *vw_field_name(enum vw_field field);                     // "hash", "mlp", "splats", "auto"
const char *vw_loss_name(enum vw_loss loss);                        // "l1", "l2", "huber"
const char *vw_optimizer_name(enum vw_optimizer optimizer);         // "lazy-adam", "dense-adam", "sgd"
const char *vw_background_name(enum vw_background_form form);       // "fixed", "random"
const char *vw_vary_name(enum vw_vary vary);                        // "all", "order", ..., "all,validation"
const char *vw_coarse_network_name(enum vw_coarse_network network); // "shared", "own"

// ---- Effects (decision 7) ----

enum { VW_EFFECT_COUNT_MAX = 16, VW_MEASURED_ON_BYTES = 240 };

struct vw_effect_decision {
    const char *name;       // "distortion", "background"
    bool called_for;        // evidence_low >= threshold, and beside the effects that were chosen before
    double evidence;        // measured on the scene; NaN: unknown, which calls for nothing
    double evidence_stderr; // standard error of a gain; NaN for a fact
    double evidence_low;    // for a gain, the lower end of its one-sided 95 % interval; for a fact, the evidence
    double threshold;       // for a gain, the price that it must reach; NaN: nothing was measured
    double ms_per_step, device_bytes; // cost of the effect in pilots; NaN: unknown. Costs decide nothing
    const char *meaning;              // description of the evidence, with its unit
    char measured_on[VW_MEASURED_ON_BYTES];
    bool on; // after --effects
};

// Lists every known effect, in registry order, with nothing measured and nothing on.
void vw_effects_list(struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count);
// Switches effects on as they are called for and as `effects` (--effects) says. An effect that +a,-b does not name goes
// off without the effect that it requires, and beside one that it conflicts with. VW_ERROR_USAGE when `effects` names
// an unknown effect.
enum vw_status vw_effects_choose(const char *effects, struct vw_effect_decision *decisions, uint32_t count);
// Switches off what the config's field, or importance samples, cannot have. VW_ERROR_USAGE, naming both, where
// config->effects names it.
enum vw_status vw_effects_follow_field(const struct vw_config *config, struct vw_effect_decision *decisions,
                                       uint32_t count);
// Returns the decision on the effect of that name; NULL for one that is not in the list.
struct vw_effect_decision *vw_effects_find(struct vw_effect_decision *decisions, uint32_t count, const char *name);
// Returns whether the effect of that name is on; false for one that is not in the list.
bool vw_effects_is_on(const struct vw_effect_decision *decisions, uint32_t count, const char *name);
// Returns whether an effect is on that fits each measured view on its left half, so that only the right half is scored.
bool vw_effects_fit_views(const struct vw_effect_decision *decisions, uint32_t count);
// Returns whether errors of whole views are of right halves: such an effect is on, or appearance_encoder, which then
// sees only the left halves.
bool vw_effects_halve_views(const struct vw_effect_decision *decisions, uint32_t count);

VW_PUBLIC_END

#endif

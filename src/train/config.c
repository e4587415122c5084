// The settings of a training, their ranges, and their canonical JSON.
#include "viewworth/train.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "interface.h"

const struct vw_config vw_config_default = {
    .epochs = 48,
    .burn_in_epochs = 1,
    .rays = 250,
    .samples = 16,
    .importance_samples = 16,
    .val_rays = 1024,
    .loss = VW_LOSS_L2,
    .huber_length = 0.1,
    .beta_min = 0.1,
    .optimizer = VW_OPTIMIZER_LAZY_ADAM,
    .learning_rate = 0.005,
    .learning_rate_decay = 0.1,
    .beta1 = 0.0,
    .beta2 = 0.99,
    .mlp_depth = 8,
    .frequencies = 10,
    .levels = 10,
    .features = 2,
    .log2_table = 14,
    .base_resolution = 8,
    .growth = 1.45,
    .width = 32,
    .harmonics = 1,
    .effects = "auto",
    .pilot_steps = VW_PILOT_STEPS_AUTO,
};

struct vw_config vw_config_of_field(enum vw_field field) {
    struct vw_config config = vw_config_default;
    config.field = field;
    if (field == VW_FIELD_MLP) {
        config.width = 256;
        config.learning_rate = 5e-4;
        config.learning_rate_decay = 1;
    } else if (field == VW_FIELD_SPLATS) {
        config.rays = 12 * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
        config.learning_rate = 6;
        config.learning_rate_decay = 0.01;
        config.beta2 = 0.999;
        config.val_rays = 4096;
        config.ssim_weight = 0.2;
        config.epochs = 60;
        config.importance_samples = 0;
    }
    return config;
}

static const char *const field_names[] = {"hash", "mlp", "splats"};
static const char *const loss_names[] = {"l1", "l2", "huber"};
static const char *const optimizer_names[] = {"lazy-adam", "dense-adam", "sgd"};
static const char *const background_names[] = {"fixed", "random"};
static const char *const vary_names[] = {"all", "order", "pixels", "init", "validation", "all,validation"};
static const char *const coarse_network_names[] = {"shared", "own"};

const char *vw_field_name(enum vw_field field) { return field_names[field]; }
const char *vw_loss_name(enum vw_loss loss) { return loss_names[loss]; }
const char *vw_optimizer_name(enum vw_optimizer optimizer) { return optimizer_names[optimizer]; }
const char *vw_background_name(enum vw_background_form form) { return background_names[form]; }
const char *vw_vary_name(enum vw_vary vary) { return vary_names[vary]; }
const char *vw_coarse_network_name(enum vw_coarse_network network) { return coarse_network_names[network]; }

static bool varies_all(const struct vw_config *config) {
    return config->vary == VW_VARY_ALL || config->vary == VW_VARY_ALL_VALIDATION;
}

uint64_t vw_config_seed_of(const struct vw_config *config, enum vw_vary draws) {
    if (draws == VW_VARY_VALIDATION)
        return config->vary == VW_VARY_VALIDATION || config->vary == VW_VARY_ALL_VALIDATION ? config->seed : 0;
    return varies_all(config) || config->vary == draws ? config->seed : config->base_seed;
}

// One row per number: the field, its JSON key, the option that sets it, and its range (for --help and messages too).
enum kind {
    WHOLE,  // uint32_t
    POWER,  // uint32_t, a power of two
    EIGHTS, // uint32_t, a multiple of 8
    SEED,   // uint64_t of 63 bits, as the ledger keeps it
    REAL,   // double
};
static const struct number {
    const char *key, *option;
    enum kind kind;
    size_t offset;
    double least, most;
    bool identity; // part of what the run is
} numbers[] = {
    {"seed", "seed", SEED, offsetof(struct vw_config, seed), 0, 0x1p63, true}, // 2^63 itself is one too many
    {"epochs", "epochs", WHOLE, offsetof(struct vw_config, epochs), 1, 1e9, false},
    {"burn_in_epochs", "burn-in", WHOLE, offsetof(struct vw_config, burn_in_epochs), 0, 1e9, true},
    {"rays", "rays", WHOLE, offsetof(struct vw_config, rays), 1, 65536, true},
    {"samples", "samples", WHOLE, offsetof(struct vw_config, samples), 1, 4096, true},
    {"importance_samples", "importance-samples", WHOLE, offsetof(struct vw_config, importance_samples), 0, 4096, true},
    {"val_rays", "val-rays", WHOLE, offsetof(struct vw_config, val_rays), 1, 1 << 24, true},
    {"huber_length", "huber-length", REAL, offsetof(struct vw_config, huber_length), 0.001, 1.0, true},
    {"ssim_weight", "ssim-weight", REAL, offsetof(struct vw_config, ssim_weight), 0.0, 1.0, true},
    {"beta_min", "beta-min", REAL, offsetof(struct vw_config, beta_min), 0.001, 10.0, true},
    {"consistency_weight", "consistency-weight", REAL, offsetof(struct vw_config, consistency_weight), 0.0, 1000.0,
     true},
    {"learning_rate", "lr", REAL, offsetof(struct vw_config, learning_rate), 1e-12, 1e6, true},
    {"learning_rate_decay", "learning-rate-decay", REAL, offsetof(struct vw_config, learning_rate_decay), 1e-6, 1.0,
     true},
    {"decay_epochs", "decay-epochs", WHOLE, offsetof(struct vw_config, decay_epochs), 0, 1e9, true},
    {"beta1", "beta1", REAL, offsetof(struct vw_config, beta1), 0.0, 0.999999, true},
    {"beta2", "beta2", REAL, offsetof(struct vw_config, beta2), 0.0, 0.999999, true},
    {"mlp_depth", "mlp-depth", WHOLE, offsetof(struct vw_config, mlp_depth), 1, 16, true},
    {"frequencies", "frequencies", WHOLE, offsetof(struct vw_config, frequencies), 0, 16, true},
    {"levels", "levels", WHOLE, offsetof(struct vw_config, levels), 1, 16, true},
    {"features", "features", POWER, offsetof(struct vw_config, features), 2, 4, true},
    {"log2_table", "log2-table", WHOLE, offsetof(struct vw_config, log2_table), 0, 22, true},
    {"base_resolution", "base-resolution", WHOLE, offsetof(struct vw_config, base_resolution), 1, 1024, true},
    {"growth", "growth", REAL, offsetof(struct vw_config, growth), 1.0, 4.0, true},
    {"width", "width", EIGHTS, offsetof(struct vw_config, width), 16, 512, true},
    {"splats", "splats", WHOLE, offsetof(struct vw_config, splats), 0, 1 << 20, true},
    {"harmonics", "harmonics", WHOLE, offsetof(struct vw_config, harmonics), 0, VW_SPLAT_DEGREE_MAX, true},
};

// One row per choice: the field, its JSON key and the names of its values.
static const struct choice {
    const char *key;
    size_t offset;
    const char *const *names;
    uint32_t count;
} choices[] = {
    {"loss", offsetof(struct vw_config, loss), loss_names, VW_ARRAY_COUNT(loss_names)},
    {"optimizer", offsetof(struct vw_config, optimizer), optimizer_names, VW_ARRAY_COUNT(optimizer_names)},
    {"background", offsetof(struct vw_config, background), background_names, VW_ARRAY_COUNT(background_names)},
    {"vary", offsetof(struct vw_config, vary), vary_names, VW_ARRAY_COUNT(vary_names)},
    {"field", offsetof(struct vw_config, field), field_names, VW_ARRAY_COUNT(field_names)},
    {"coarse_network", offsetof(struct vw_config, coarse_network), coarse_network_names,
     VW_ARRAY_COUNT(coarse_network_names)},
};
_Static_assert(sizeof(enum vw_loss) == sizeof(uint32_t) && sizeof(enum vw_field) == sizeof(uint32_t),
               "choice_at() reads enums as their underlying type");

static uint32_t *choice_at(struct vw_config *config, size_t i) {
    return (uint32_t *)((char *)config + choices[i].offset);
}

static double number_get(const struct vw_config *config, const struct number *number) {
    const char *field = (const char *)config + number->offset;
    switch (number->kind) {
    case REAL: return *(const double *)field;
    case SEED: return (double)*(const uint64_t *)field;
    default: return *(const uint32_t *)field;
    }
}

static bool number_fits(const struct vw_config *config, const struct number *number) {
    double value = number_get(config, number);
    if (number->kind == SEED) return config->seed <= INT64_MAX; // which a double cannot tell from 2^63
    if (number->kind == POWER && ((uint32_t)value & ((uint32_t)value - 1)) != 0) return false;
    if (number->kind == EIGHTS && (uint32_t)value % 8 != 0) return false;
    return value >= number->least && value <= number->most;
}

static void number_range(const struct number *number, char text[VW_CONFIG_RANGE_BYTES]) {
    const char *gaps = number->kind == POWER ? "a power of two, " : number->kind == EIGHTS ? "a multiple of 8, " : "";
    if (number->kind == SEED) snprintf(text, VW_CONFIG_RANGE_BYTES, "0 to %" PRId64, INT64_MAX);
    else snprintf(text, VW_CONFIG_RANGE_BYTES, "%s%.10g to %.10g", gaps, number->least, number->most);
}

bool vw_config_range(const char *option, char text[VW_CONFIG_RANGE_BYTES]) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) {
        if (strcmp(numbers[i].option, option) != 0) continue;
        number_range(&numbers[i], text);
        return true;
    }
    return false;
}

static enum vw_status check_splats(const struct vw_config *config) {
    uint32_t square = VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
    if (config->field != VW_FIELD_SPLATS && config->initial[0])
        return vw_fail(VW_ERROR_USAGE, "--initial: needs --field splats");
    if (config->field != VW_FIELD_SPLATS && config->ssim_weight != 0.0)
        return vw_fail(VW_ERROR_USAGE, "--ssim-weight: needs --field splats, not %s; leave it out",
                       vw_field_name(config->field));
    if (config->field != VW_FIELD_SPLATS)
        return config->splats || config->harmonics != vw_config_default.harmonics
                   ? vw_fail(VW_ERROR_USAGE, "--splats and --harmonics: need --field splats")
                   : VW_OK;
    if (config->rays % square != 0)
        return vw_fail(VW_ERROR_USAGE, "--rays: a multiple of %u with --field splats, not %u", square, config->rays);
    if (config->importance_samples || config->samples != vw_config_default.samples)
        return vw_fail(VW_ERROR_USAGE, "--samples and --importance-samples: splats have no samples; leave them out");
    if (config->width != vw_config_default.width)
        return vw_fail(VW_ERROR_USAGE, "--width: splats have no layers; leave it out");
    return VW_OK;
}

// Checks what a table of ranges cannot say: numbers that depend on each other.
static enum vw_status check_together(const struct vw_config *config) {
    uint32_t samples = config->samples > config->importance_samples ? config->samples : config->importance_samples;
    if ((uint64_t)config->rays * samples > 1u << 24)
        return vw_fail(VW_ERROR_USAGE, "--rays times --%s is %" PRIu64 ": at most %u samples per step",
                       samples > config->samples ? "importance-samples" : "samples", (uint64_t)config->rays * samples,
                       1u << 24);
    if (config->levels * config->features % 4 != 0)
        return vw_fail(VW_ERROR_USAGE, "--levels times --features must be a multiple of 4, not %u x %u", config->levels,
                       config->features);
    if (config->base_seed > (varies_all(config) ? 0 : INT64_MAX))
        return vw_fail(VW_ERROR_USAGE, "base_seed is %" PRIu64 ": at most %" PRId64 ", and 0 where everything varies",
                       config->base_seed, INT64_MAX);
    double finest = config->base_resolution * pow(config->growth, config->levels - 1.0);
    if (finest > 65535.0)
        return vw_fail(VW_ERROR_USAGE,
                       "--growth: the finest level has %.0f cells per axis, more than 65535; lower --growth, --levels "
                       "or --base-resolution",
                       finest);
    if (config->field == VW_FIELD_HASH && config->width != 16 && config->width != 32 && config->width != 64)
        return vw_fail(VW_ERROR_USAGE, "--width: 16, 32 or 64 with --field hash, not %u", config->width);
    if (config->field != VW_FIELD_MLP &&
        (config->mlp_depth != vw_config_default.mlp_depth || config->frequencies != vw_config_default.frequencies))
        return vw_fail(VW_ERROR_USAGE, "--mlp-depth and --frequencies: need --field mlp");
    const struct vw_config *grid = &vw_config_default;
    if (config->field != VW_FIELD_HASH &&
        (config->levels != grid->levels || config->features != grid->features ||
         config->log2_table != grid->log2_table || config->base_resolution != grid->base_resolution ||
         config->growth != grid->growth))
        return vw_fail(VW_ERROR_USAGE, "--levels, --features, --log2-table, --base-resolution and --growth: "
                                       "need --field hash");
    if (config->coarse_network == VW_COARSE_NETWORK_OWN && config->field != VW_FIELD_MLP)
        return vw_fail(VW_ERROR_USAGE, "--coarse-network own: needs --field mlp, not %s; use --coarse-network shared",
                       vw_field_name(config->field));
    if (config->coarse_network == VW_COARSE_NETWORK_OWN && !config->importance_samples)
        return vw_fail(VW_ERROR_USAGE, "--coarse-network own: needs --importance-samples above 0, which it places; "
                                       "use --coarse-network shared");
    if (config->loss != VW_LOSS_HUBER && config->huber_length != vw_config_default.huber_length)
        return vw_fail(VW_ERROR_USAGE, "--huber-length: needs --loss huber, not %s", vw_loss_name(config->loss));
    if (config->decay_epochs && vw_config_rate_is_constant(config))
        return vw_fail(VW_ERROR_USAGE, "--decay-epochs: needs --learning-rate-decay below 1");
    if (config->pilot_steps > VW_PILOT_STEPS_MOST && config->pilot_steps != VW_PILOT_STEPS_AUTO)
        return vw_fail(VW_ERROR_USAGE, "--pilot-steps takes 0 to %d, not %" PRIu32, VW_PILOT_STEPS_MOST,
                       config->pilot_steps);
    return check_splats(config);
}

enum vw_status vw_config_check(const struct vw_config *config) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) {
        if (number_fits(config, &numbers[i])) continue;
        char range[VW_CONFIG_RANGE_BYTES];
        number_range(&numbers[i], range);
        return vw_fail(VW_ERROR_USAGE, "--%s takes %s, not %.10g", numbers[i].option, range,
                       number_get(config, &numbers[i]));
    }
    return check_together(config);
}

static json_t *number_to_json(const struct vw_config *config, const struct number *number) {
    if (number->kind == REAL) return json_real(number_get(config, number));
    if (number->kind == SEED) return json_integer((json_int_t)config->seed);
    return json_integer((json_int_t)number_get(config, number));
}

bool vw_config_rate_is_constant(const struct vw_config *config) { return config->learning_rate_decay == 1.0; }

// Returns over how many epochs the rate falls; 0: it does not.
static uint32_t settled_decay(const struct vw_config *config) {
    if (vw_config_rate_is_constant(config)) return 0;
    return config->decay_epochs ? config->decay_epochs : config->epochs;
}

void vw_config_settle_decay(struct vw_config *config) { config->decay_epochs = settled_decay(config); }

void vw_config_set_epochs(struct vw_config *config, uint32_t epochs) {
    double share = (double)config->decay_epochs / config->epochs;
    if (config->decay_epochs) config->decay_epochs = (uint32_t)fmin(fmax(1, round(share * epochs)), 1e9);
    config->epochs = epochs;
}

// Returns whether memory was short.
static int choices_to_json(const struct vw_config *config, json_t *object) {
    int failed = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(choices) && !failed; i++)
        failed = json_object_set_new(object, choices[i].key,
                                     json_string(choices[i].names[*choice_at((struct vw_config *)config, i)]));
    return failed;
}

// Adds the file that splats begin from: its hash is part of the identity, its path is not. Returns whether memory was
// short.
static int initial_to_json(const struct vw_config *config, bool identity_only, json_t *object) {
    if (!config->initial[0]) return 0;
    int failed = json_object_set_new(object, "initial_sha256", json_string(config->initial_sha256));
    return failed || identity_only ? failed : json_object_set_new(object, "initial", json_string(config->initial));
}

char *vw_config_to_json(const struct vw_config *config, bool identity_only) {
    json_t *object = json_object();
    struct vw_config written = *config;
    int failed = !object;
    if (identity_only) written.decay_epochs = settled_decay(config);
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers) && !failed; i++)
        if (!identity_only || numbers[i].identity)
            failed = json_object_set_new(object, numbers[i].key, number_to_json(&written, &numbers[i]));
    failed = failed || choices_to_json(config, object);
    failed = failed || initial_to_json(config, identity_only, object);
    failed = failed || json_object_set_new(object, "base_seed", json_integer((json_int_t)config->base_seed));
    bool automatic = config->pilot_steps == VW_PILOT_STEPS_AUTO;
    failed = failed ||
             (!identity_only &&
              json_object_set_new(object, "pilot_steps", automatic ? json_null() : json_integer(config->pilot_steps)));
    // The effects that are on are part of the identity by their names, however they were asked for: see
    // vw_trainer_run_id.
    failed = failed || (!identity_only && json_object_set_new(object, "effects", json_string(config->effects)));
    char *text = failed ? NULL : vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the configuration's JSON");
    return text;
}

static enum vw_status choice_from_json(const json_t *object, size_t i, struct vw_config *config) {
    const struct choice *choice = &choices[i];
    const char *name = json_string_value(json_object_get(object, choice->key));
    for (uint32_t value = 0; name && value < choice->count; value++) {
        if (strcmp(name, choice->names[value]) != 0) continue;
        *choice_at(config, i) = value;
        return VW_OK;
    }
    return vw_fail(VW_ERROR_INPUT, "config: %s: \"%s\" is not known", choice->key, name ? name : "(none)");
}

static enum vw_status number_from_json(const json_t *object, const struct number *number, struct vw_config *config) {
    const json_t *value = json_object_get(object, number->key);
    char *field = (char *)config + number->offset;
    if (!json_is_number(value)) return vw_fail(VW_ERROR_INPUT, "config: %s is missing or not a number", number->key);
    if (number->kind == REAL) *(double *)field = json_number_value(value);
    else if (number->kind == SEED) *(uint64_t *)field = (uint64_t)json_integer_value(value);
    else *(uint32_t *)field = (uint32_t)json_integer_value(value);
    return VW_OK;
}

static enum vw_status initial_from_json(const json_t *object, struct vw_config *config) {
    const json_t *path = json_object_get(object, "initial"), *hash = json_object_get(object, "initial_sha256");
    const char *text = json_string_value(path), *hex = json_string_value(hash);
    uint8_t bytes[VW_HASH_BYTES];
    if (!path && !hash) return VW_OK;
    if (!text || !*text || strlen(text) >= sizeof config->initial || !hex || !vw_hash_from_hex(hex, bytes))
        return vw_fail(VW_ERROR_INPUT, "config: initial and initial_sha256 are not a path and a hash");
    strcpy(config->initial, text);
    strcpy(config->initial_sha256, hex);
    return VW_OK;
}

// Reads the fields that no table has.
static enum vw_status rest_from_json(const json_t *object, struct vw_config *config) {
    const json_t *pilots = json_object_get(object, "pilot_steps");
    const char *effects = json_string_value(json_object_get(object, "effects"));
    json_int_t base_seed = json_integer_value(json_object_get(object, "base_seed"));
    json_int_t pilot_steps = json_integer_value(pilots);
    if (!effects || strlen(effects) >= sizeof config->effects)
        return vw_fail(VW_ERROR_INPUT, "config: effects is missing or too long");
    if (pilot_steps < 0 || pilot_steps > VW_PILOT_STEPS_MOST)
        return vw_fail(VW_ERROR_INPUT, "config: pilot_steps is not a number of steps");
    strcpy(config->effects, effects);
    config->base_seed = (uint64_t)base_seed;
    config->pilot_steps = json_is_integer(pilots) ? (uint32_t)pilot_steps : VW_PILOT_STEPS_AUTO;
    return VW_OK;
}

enum vw_status vw_config_from_json(const char *json, struct vw_config *config) {
    struct vw_config parsed = vw_config_default;
    json_error_t error;
    json_t *object = vw_json_load(json, strlen(json), 0, &error);
    if (!object) return vw_fail(VW_ERROR_INPUT, "config: %d:%d: %s", error.line, error.column, error.text);
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers) && !status; i++)
        status = number_from_json(object, &numbers[i], &parsed);
    for (size_t i = 0; i < VW_ARRAY_COUNT(choices) && !status; i++) status = choice_from_json(object, i, &parsed);
    if (!status) status = rest_from_json(object, &parsed);
    if (!status) status = initial_from_json(object, &parsed);
    json_decref(object);
    if (!status) status = vw_config_check(&parsed);
    if (!status) *config = parsed;
    return status;
}

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
    .field = VW_FIELD_AUTO,
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

static const char *const field_names[] = {"hash", "mlp", "splats", "auto"};
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

enum { HASH = 1 << VW_FIELD_HASH, MLP = 1 << VW_FIELD_MLP, SPLATS = 1 << VW_FIELD_SPLATS };
enum { SAMPLED = HASH | MLP, ALL = SAMPLED | SPLATS, AUTO = 1 << VW_FIELD_AUTO };

#define NUMBER(key, option, kind, least, most, fields, ...)                                                            \
    { #key, option, VW_CONFIG_##kind, offsetof(struct vw_config, key), fields, true, least, most, __VA_ARGS__ }
#define CHOICE(key, option, texts)                                                                                     \
    {                                                                                                                  \
#key, option, VW_CONFIG_CHOICE, offsetof(struct vw_config, key), ALL, true, .names = texts,                    \
                                                                                    .most = VW_ARRAY_COUNT(texts) - 1  \
    }
#define OF_MLP(value) .own[VW_FIELD_MLP] = {true, value}
#define OF_SPLATS(value) .own[VW_FIELD_SPLATS] = {true, value}

static const struct vw_config_field table[] = {
    NUMBER(seed, "seed", SEED, 0, 0x1p63, ALL), // 2^63 itself is one too many
    {"epochs", "epochs", VW_CONFIG_WHOLE, offsetof(struct vw_config, epochs), ALL, false, 1, 1e9, OF_SPLATS(30)},
    NUMBER(burn_in_epochs, "burn-in", WHOLE, 0, 1e9, ALL),
    NUMBER(rays, "rays", WHOLE, 1, 65536, ALL, OF_SPLATS(24 * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE)),
    NUMBER(samples, "samples", WHOLE, 1, 4096, SAMPLED),
    NUMBER(importance_samples, "importance-samples", WHOLE, 0, 4096, SAMPLED, OF_SPLATS(0)),
    NUMBER(val_rays, "val-rays", WHOLE, 1, 1 << 24, ALL, OF_SPLATS(4096)),
    NUMBER(huber_length, "huber-length", REAL, 0.001, 1, ALL),
    NUMBER(ssim_weight, "ssim-weight", REAL, 0, 1, SPLATS, OF_SPLATS(0.2)),
    NUMBER(beta_min, "beta-min", REAL, 0.001, 10, ALL),
    NUMBER(consistency_weight, "consistency-weight", REAL, 0, 1000, SAMPLED),
    NUMBER(learning_rate, "lr", REAL, 1e-12, 1e6, ALL, OF_MLP(5e-4), OF_SPLATS(6)),
    NUMBER(learning_rate_decay, "learning-rate-decay", REAL, 1e-6, 1, ALL, OF_MLP(1)),
    NUMBER(decay_epochs, "decay-epochs", WHOLE, 0, 1e9, ALL),
    NUMBER(beta1, "beta1", REAL, 0, 0.999999, ALL),
    NUMBER(beta2, "beta2", REAL, 0, 0.999999, ALL, OF_SPLATS(0.999)),
    NUMBER(mlp_depth, "mlp-depth", WHOLE, 1, 16, MLP),
    NUMBER(frequencies, "frequencies", WHOLE, 0, 16, MLP),
    NUMBER(levels, "levels", WHOLE, 1, 16, HASH),
    NUMBER(features, "features", POWER, 2, 4, HASH),
    NUMBER(log2_table, "log2-table", WHOLE, 0, 22, HASH),
    NUMBER(base_resolution, "base-resolution", WHOLE, 1, 1024, HASH),
    NUMBER(growth, "growth", REAL, 1, 4, HASH),
    NUMBER(width, "width", EIGHTS, 16, 512, SAMPLED, OF_MLP(256)),
    NUMBER(splats, "splats", WHOLE, 0, 1 << 20, SPLATS),
    NUMBER(harmonics, "harmonics", WHOLE, 0, VW_SPLAT_DEGREE_MAX, SPLATS),
    CHOICE(loss, "loss", loss_names),
    CHOICE(optimizer, "optimizer", optimizer_names),
    CHOICE(background, "background", background_names),
    CHOICE(vary, "vary", vary_names),
    CHOICE(field, "field", field_names),
    CHOICE(coarse_network, "coarse-network", coarse_network_names),
};
_Static_assert(VW_ARRAY_COUNT(table) <= 64, "vw_config_explicit() has a bit for each");
_Static_assert(sizeof(enum vw_loss) == sizeof(uint32_t) && sizeof(enum vw_field) == sizeof(uint32_t),
               "choices are read as their underlying type");

const struct vw_config_field *vw_config_fields(uint32_t *count) {
    *count = VW_ARRAY_COUNT(table);
    return table;
}

const struct vw_config_field *vw_config_find(const char *option) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(table); i++)
        if (!strcmp(table[i].option, option)) return &table[i];
    return NULL;
}

uint64_t vw_config_explicit(const char *option) {
    const struct vw_config_field *field = vw_config_find(option);
    return field ? UINT64_C(1) << (field - table) : 0;
}

double vw_config_get(const struct vw_config *config, const struct vw_config_field *field) {
    const char *at = (const char *)config + field->offset;
    switch (field->kind) {
    case VW_CONFIG_REAL: return *(const double *)at;
    case VW_CONFIG_SEED: return (double)*(const uint64_t *)at;
    default: return *(const uint32_t *)at;
    }
}

// Sets any number but a seed, which a double does not hold.
static void set(struct vw_config *config, const struct vw_config_field *field, double value) {
    char *at = (char *)config + field->offset;
    if (field->kind == VW_CONFIG_REAL) *(double *)at = value;
    else *(uint32_t *)at = (uint32_t)value;
}

void vw_config_copy(const struct vw_config *from, const struct vw_config_field *field, struct vw_config *to) {
    if (field->kind == VW_CONFIG_SEED) to->seed = from->seed;
    else set(to, field, vw_config_get(from, field));
}

struct vw_config vw_config_of_field(enum vw_field of) {
    struct vw_config config = vw_config_default;
    config.field = of;
    for (size_t i = 0; i < VW_ARRAY_COUNT(table); i++)
        if (of < VW_FIELD_COUNT && table[i].own[of].differs) set(&config, &table[i], table[i].own[of].value);
    return config;
}

void vw_config_take_field(enum vw_field field, uint64_t explicit_fields, struct vw_config *config) {
    const struct vw_config of_field = vw_config_of_field(field);
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(table); i++)
        if (!(explicit_fields >> i & 1) &&
            vw_config_get(config, &table[i]) == vw_config_get(&vw_config_default, &table[i]))
            vw_config_copy(&of_field, &table[i], config);
    config->field = field;
}

static bool fits(const struct vw_config *config, const struct vw_config_field *field) {
    double value = vw_config_get(config, field);
    if (field->kind == VW_CONFIG_SEED) return config->seed <= INT64_MAX; // which a double cannot tell from 2^63
    if (field->kind == VW_CONFIG_POWER && ((uint32_t)value & ((uint32_t)value - 1)) != 0) return false;
    if (field->kind == VW_CONFIG_EIGHTS && (uint32_t)value % 8 != 0) return false;
    return value >= field->least && value <= field->most;
}

void vw_config_describe_range(const struct vw_config_field *field, char text[VW_CONFIG_RANGE_BYTES]) {
    const char *gaps = field->kind == VW_CONFIG_POWER    ? "a power of two, "
                       : field->kind == VW_CONFIG_EIGHTS ? "a multiple of 8, "
                                                         : "";
    if (field->kind == VW_CONFIG_CHOICE) text[0] = 0;
    else if (field->kind == VW_CONFIG_SEED) snprintf(text, VW_CONFIG_RANGE_BYTES, "0 to %" PRId64, INT64_MAX);
    else snprintf(text, VW_CONFIG_RANGE_BYTES, "%s%.10g to %.10g", gaps, field->least, field->most);
}

// Refuses a value that only other values of --field have.
static enum vw_status check_has(const struct vw_config *config, const struct vw_config *defaults,
                                const struct vw_config_field *field) {
    if ((field->fields | AUTO) >> config->field & 1 || vw_config_get(config, field) == vw_config_get(defaults, field))
        return VW_OK;
    char names[32] = "";
    for (uint32_t i = 0; i < VW_FIELD_COUNT; i++)
        if (field->fields >> i & 1)
            snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", *names ? " or " : "", field_names[i]);
    return vw_fail(VW_ERROR_USAGE, "--%s: needs --field %s, not %s; leave it out", field->option, names,
                   field_names[config->field]);
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
    if (config->coarse_network == VW_COARSE_NETWORK_OWN && config->field != VW_FIELD_MLP &&
        config->field != VW_FIELD_AUTO)
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
    uint32_t square = VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
    if (config->field == VW_FIELD_SPLATS && config->rays % square != 0)
        return vw_fail(VW_ERROR_USAGE, "--rays: a multiple of %u with --field splats, not %u", square, config->rays);
    if (config->field != VW_FIELD_SPLATS && config->field != VW_FIELD_AUTO && config->initial[0])
        return vw_fail(VW_ERROR_USAGE, "--initial: needs --field splats");
    return VW_OK;
}

enum vw_status vw_config_check(const struct vw_config *config) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(table); i++) {
        if (fits(config, &table[i])) continue;
        char range[VW_CONFIG_RANGE_BYTES];
        vw_config_describe_range(&table[i], range);
        return vw_fail(VW_ERROR_USAGE, "--%s takes %s, not %.10g", table[i].option, range,
                       vw_config_get(config, &table[i]));
    }
    const struct vw_config defaults = vw_config_of_field(config->field);
    for (size_t i = 0; i < VW_ARRAY_COUNT(table) && !status; i++) status = check_has(config, &defaults, &table[i]);
    return status ? status : check_together(config);
}

static json_t *field_to_json(const struct vw_config *config, const struct vw_config_field *field) {
    double value = vw_config_get(config, field);
    switch (field->kind) {
    case VW_CONFIG_CHOICE: return json_string(field->names[(uint32_t)value]);
    case VW_CONFIG_REAL: return json_real(value);
    case VW_CONFIG_SEED: return json_integer((json_int_t)config->seed);
    default: return json_integer((json_int_t)value);
    }
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
    for (size_t i = 0; i < VW_ARRAY_COUNT(table) && !failed; i++)
        if (!identity_only || table[i].identity)
            failed = json_object_set_new(object, table[i].key, field_to_json(&written, &table[i]));
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

static enum vw_status choice_from_json(const json_t *value, const struct vw_config_field *field,
                                       struct vw_config *config) {
    const char *name = json_string_value(value);
    for (uint32_t i = 0; name && i <= (uint32_t)field->most; i++) {
        if (strcmp(name, field->names[i]) != 0) continue;
        set(config, field, i);
        return VW_OK;
    }
    return vw_fail(VW_ERROR_INPUT, "config: %s: \"%s\" is not known", field->key, name ? name : "(none)");
}

static enum vw_status field_from_json(const json_t *object, const struct vw_config_field *field,
                                      struct vw_config *config) {
    const json_t *value = json_object_get(object, field->key);
    if (field->kind == VW_CONFIG_CHOICE) return choice_from_json(value, field, config);
    if (!json_is_number(value)) return vw_fail(VW_ERROR_INPUT, "config: %s is missing or not a number", field->key);
    if (field->kind == VW_CONFIG_SEED) config->seed = (uint64_t)json_integer_value(value);
    else if (field->kind == VW_CONFIG_REAL) set(config, field, json_number_value(value));
    else set(config, field, (uint32_t)json_integer_value(value));
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
    for (size_t i = 0; i < VW_ARRAY_COUNT(table) && !status; i++) status = field_from_json(object, &table[i], &parsed);
    if (!status) status = rest_from_json(object, &parsed);
    if (!status) status = initial_from_json(object, &parsed);
    json_decref(object);
    if (!status) status = vw_config_check(&parsed);
    if (!status && parsed.field == VW_FIELD_AUTO) status = vw_fail(VW_ERROR_INPUT, "config: field: none is chosen");
    if (!status) *config = parsed;
    return status;
}

#include "experiment/sweep/configurations.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "run/plan/accuracy_levels.h"

enum how { TIMES, PLUS, SET };
enum { VALUES_MAX = 8, VALUE_BYTES = 32 };
enum { HASH = 1 << VW_FIELD_HASH, MLP = 1 << VW_FIELD_MLP, SAMPLED = HASH | MLP, ALL = SAMPLED | 1 << VW_FIELD_SPLATS };

// A number of the config, and the values to try, computed from its value at the base.
static const struct sweep {
    const char *parameter;
    size_t offset;
    enum how how;
    uint32_t fields;           // a bit for every field that has it
    double values[VALUES_MAX]; // up to the first 0
} sweeps[] = {
    {"rays", offsetof(struct vw_config, rays), TIMES, ALL, {0.125, 0.25, 0.5, 2}},
    {"samples", offsetof(struct vw_config, samples), TIMES, SAMPLED, {0.25, 0.5, 2}},
    {"importance-samples", offsetof(struct vw_config, importance_samples), SET, SAMPLED, {8, 16, 32}},
    {"val-rays", offsetof(struct vw_config, val_rays), SET, ALL, {64, 128, 256, 512, 1024, 2048, 4096}},
    {"levels", offsetof(struct vw_config, levels), PLUS, HASH, {-4, -2, 4}},
    {"log2-table", offsetof(struct vw_config, log2_table), PLUS, HASH, {-4, -2, 2, 4}},
    {"mlp-depth", offsetof(struct vw_config, mlp_depth), SET, MLP, {1, 2, 4, 8}},
    {"width", offsetof(struct vw_config, width), SET, SAMPLED, {16, 32, 64, 128, 256}},
    {"epochs", offsetof(struct vw_config, epochs), TIMES, ALL, {0.25, 0.5, 2}},
};
static const double learning_rate_decays[] = {1, 0.3, 0.1};
static const double FULL_RESOLUTION_RAYS = 2; // times the base's: the largest factor of `rays`

// ---- Configurations ----

static enum vw_status add(struct vw_sweep_configurations *configurations, const char *parameter, const char *value,
                          const struct vw_config *config) {
    if (configurations->count == VW_CONFIGURATIONS_MAX)
        return vw_fail(VW_ERROR_USAGE, "more than %d configurations to try; name fewer by --parameters",
                       VW_CONFIGURATIONS_MAX);
    struct vw_sweep_configuration *configuration = &configurations->configurations[configurations->count++];
    *configuration = (struct vw_sweep_configuration){.parameter = parameter, .config = *config};
    snprintf(configuration->value, sizeof configuration->value, "%s", value);
    snprintf(configuration->name, sizeof configuration->name, "%s%s%s", parameter, *value ? "-" : "", value);
    return VW_OK;
}

static bool is_listed(const struct vw_sweep_configurations *configurations, const char *parameter, const char *value) {
    for (uint32_t i = 0; i < configurations->count; i++)
        if (!strcmp(configurations->configurations[i].parameter, parameter) &&
            !strcmp(configurations->configurations[i].value, value))
            return true;
    return false;
}

static bool has(const struct vw_config *config, const struct sweep *sweep) {
    return sweep->fields >> config->field & 1;
}

static void describe_base(uint32_t downscale, struct vw_sweep_configuration *base) {
    size_t used = 0, size_bytes = sizeof base->value;
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps) && used < size_bytes; i++)
        if (has(&base->config, &sweeps[i]))
            used += (size_t)snprintf(base->value + used, size_bytes - used, "%s %" PRIu32 ", ", sweeps[i].parameter,
                                     *(const uint32_t *)((const char *)&base->config + sweeps[i].offset));
    if (used < size_bytes)
        snprintf(base->value + used, size_bytes - used, "learning-rate-decay %g, downscale %" PRIu32,
                 base->config.learning_rate_decay, downscale);
}

// Spells the effects that are on like --effects, but for one (NULL: none). Returns false when the list is too long.
static bool spell_effects(const struct vw_session *session, const char *without,
                          char text[sizeof((struct vw_config *)0)->effects]) {
    const size_t text_bytes = sizeof((struct vw_config *)0)->effects;
    size_t used = 0;
    text[0] = 0;
    for (uint32_t i = 0; i < session->effect_count && used < text_bytes; i++)
        if (session->effects[i].on && (!without || strcmp(session->effects[i].name, without) != 0))
            used += (size_t)snprintf(text + used, text_bytes - used, "%s%s", used ? "," : "", session->effects[i].name);
    if (!used) snprintf(text, text_bytes, "none");
    return used < text_bytes;
}

// Returns the validation rays that cover all pixels of every validation view: as many for each as the largest view has.
static uint64_t val_pixels(const struct vw_scene *scene) {
    uint64_t most = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        uint64_t pixels = (uint64_t)scene->views[v].image.width_px * scene->views[v].image.height_px;
        if (scene->views[v].split == VW_SPLIT_VAL && pixels > most) most = pixels;
    }
    return most * scene->split_count[VW_SPLIT_VAL];
}

static enum vw_status check_val_pixels(const struct vw_scene *scene) {
    struct vw_config config = vw_config_default;
    uint64_t pixels = val_pixels(scene);
    config.val_rays = pixels < UINT32_MAX ? (uint32_t)pixels : UINT32_MAX;
    if (!vw_config_check(&config)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "%s: %" PRIu64
                   " validation pixels are too many to measure after every step; take a higher --downscale",
                   scene->path, pixels);
}

// Returns the number to try, 0 if it would be below 1.
static uint32_t number_of(const struct sweep *sweep, uint32_t base, double value) {
    double number = sweep->how == TIMES ? base * value : sweep->how == PLUS ? base + value : value;
    return number < 1 ? 0 : (uint32_t)number;
}

// Returns whether a config can be trained and gives scores.
static bool is_admitted(const struct vw_config *config) {
    return config->epochs > config->burn_in_epochs && !vw_config_check(config);
}

// Lets a decay keep its share of changed epochs.
static void keep_share(const struct vw_config *base, struct vw_config *config) {
    uint32_t epochs = config->epochs;
    config->epochs = base->epochs;
    vw_config_set_epochs(config, epochs);
}

static enum vw_status add_sweep(const struct vw_session *session, const struct sweep *sweep,
                                struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    const struct vw_config *base = &configurations->configurations[0].config;
    uint32_t of_base = *(const uint32_t *)((const char *)base + sweep->offset);
    bool val_rays = sweep->offset == offsetof(struct vw_config, val_rays);
    uint32_t least = val_rays ? VW_VAL_RAYS_PER_VIEW_MIN * session->scene->split_count[VW_SPLIT_VAL] : 0;
    uint64_t most = val_pixels(session->scene);
    for (int i = 0; i < VALUES_MAX && sweep->values[i] != 0 && !status; i++) {
        struct vw_config config = *base;
        char value[VALUE_BYTES];
        uint32_t number = number_of(sweep, of_base, sweep->values[i]);
        if (number < least) number = least;
        *(uint32_t *)((char *)&config + sweep->offset) = number;
        keep_share(base, &config);
        snprintf(value, sizeof value, "%" PRIu32, number);
        bool base_again = number == (of_base < least ? least : of_base), all_again = val_rays && number >= most;
        if (base_again || all_again || is_listed(configurations, sweep->parameter, value) || !is_admitted(&config))
            continue;
        status = add(configurations, sweep->parameter, value, &config);
    }
    return status;
}

static enum vw_status add_learning_rate_decays(const struct vw_session *session,
                                               struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    (void)session;
    for (size_t i = 0; i < VW_ARRAY_COUNT(learning_rate_decays) && !status; i++) {
        char value[VALUE_BYTES];
        struct vw_config config = configurations->configurations[0].config;
        if (learning_rate_decays[i] == config.learning_rate_decay) continue;
        config.learning_rate_decay = learning_rate_decays[i];
        if (!is_admitted(&config)) continue;
        snprintf(value, sizeof value, "%g", learning_rate_decays[i]);
        status = add(configurations, "learning-rate-decay", value, &config);
    }
    return status;
}

static enum vw_status add_effects(const struct vw_session *session, struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < session->effect_count && !status; i++) {
        char value[VALUE_BYTES];
        struct vw_config config = configurations->configurations[0].config;
        if (!session->effects[i].on) continue;
        snprintf(value, sizeof value, "without-%s", session->effects[i].name);
        spell_effects(session, session->effects[i].name, config.effects);
        status = add(configurations, "effects", value, &config);
    }
    return status;
}

// Adds the levels of --accuracy, which also set epochs; leaves out one that equals the base.
static enum vw_status add_accuracies(const struct vw_session *session, struct vw_sweep_configurations *configurations) {
    char of_base[VW_ACCURACY_TEXT_BYTES], ours[VW_ACCURACY_TEXT_BYTES];
    (void)session;
    const struct vw_config *base = &configurations->configurations[0].config;
    vw_accuracy_options(base, of_base);
    enum vw_status status = VW_OK;
    for (uint32_t level = 0; level < vw_accuracy_level_count() && !status; level++) {
        struct vw_config config = configurations->configurations[0].config;
        vw_accuracy_apply(level, 0, &config);
        keep_share(base, &config);
        vw_accuracy_options(&config, ours);
        if (strcmp(ours, of_base) == 0 || !is_admitted(&config)) continue;
        status = add(configurations, "accuracy", vw_accuracy_level_about(level)->name, &config);
    }
    return status;
}

static enum vw_status add_full_resolution(const struct vw_session *session,
                                          struct vw_sweep_configurations *configurations) {
    struct vw_config config = configurations->configurations[0].config;
    uint32_t rays = config.rays;
    config.val_rays = (uint32_t)val_pixels(session->scene);
    config.rays = number_of(&sweeps[0], rays, FULL_RESOLUTION_RAYS);
    if (!is_admitted(&config)) config.rays = rays;
    configurations->full_resolution = configurations->count;
    return add(configurations, "full_resolution", "", &config);
}

// ---- Parameters ----

// A parameter that is not a number of the config.
static const struct {
    const char *parameter;
    enum vw_status (*add)(const struct vw_session *session, struct vw_sweep_configurations *configurations);
} others[] = {
    {"learning-rate-decay", add_learning_rate_decays},
    {"effects", add_effects},
    {"accuracy", add_accuracies},
};

// Returns the bit of a parameter: first those of `sweeps`, then the others; 0 for another word.
static uint32_t bit_of(struct vw_word word) {
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(sweeps); i++)
        if (vw_word_is(word, sweeps[i].parameter)) return UINT32_C(1) << i;
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(others); i++)
        if (vw_word_is(word, others[i].parameter)) return UINT32_C(1) << (VW_ARRAY_COUNT(sweeps) + i);
    return 0;
}

enum vw_status vw_sweep_parameters_parse(const char *list, uint32_t *parameters) {
    struct vw_word word;
    *parameters = 0;
    while (vw_word_list_next(&list, &word)) {
        uint32_t bit = bit_of(word);
        if (!bit)
            return vw_fail(VW_ERROR_USAGE, "--parameters: \"%.*s\" is none of " VW_SWEEP_PARAMETERS, (int)word.length,
                           word.text);
        *parameters |= bit;
    }
    return VW_OK;
}

static bool is_wanted(uint32_t parameters, uint32_t place) { return !parameters || (parameters >> place & 1); }

enum vw_status vw_sweep_configurations_list(const struct vw_config *base, uint32_t downscale, uint32_t parameters,
                                            const struct vw_session *session,
                                            struct vw_sweep_configurations *configurations) {
    configurations->count = 0;
    struct vw_config config = *base;
    if (!spell_effects(session, NULL, config.effects))
        return vw_fail(VW_ERROR_USAGE, "--effects: the list is too long; name fewer");
    enum vw_status status = check_val_pixels(session->scene);
    if (!status) status = add(configurations, "base", "", &config);
    if (!status) describe_base(downscale ? downscale : 1, &configurations->configurations[0]);
    if (!status) status = add_full_resolution(session, configurations);
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(sweeps) && !status; i++) {
        if (!is_wanted(parameters, i) || !has(&config, &sweeps[i])) continue;
        status = add_sweep(session, &sweeps[i], configurations);
    }
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(others) && !status; i++)
        if (is_wanted(parameters, VW_ARRAY_COUNT(sweeps) + i)) status = others[i].add(session, configurations);
    return status;
}

char *vw_sweep_folder(const char *out, const struct vw_sweep_configuration *configuration) {
    return vw_format_text("%s/configurations/%s", out, configuration->name);
}

#include "experiment/sweep/configurations.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "run/plan/presets.h"
#include "base/memory.h"

enum how { TIMES, PLUS, SET };
enum { SETTINGS_MAX = 8, SETTING_BYTES = 32, VAL_RAYS_PER_VIEW = 32 }; // as validation takes at least

// A number of the config and what it is set to, from its value at the base.
static const struct sweep {
    const char *parameter;
    size_t offset;
    enum how how;
    double settings[SETTINGS_MAX]; // up to the first 0
} sweeps[] = {
    {"rays", offsetof(struct vw_config, rays), TIMES, {0.125, 0.25, 0.5, 2}},
    {"samples", offsetof(struct vw_config, samples), TIMES, {0.25, 0.5, 2}},
    {"val-rays", offsetof(struct vw_config, val_rays), SET, {64, 128, 256, 512, 1024, 2048, 4096}},
    {"levels", offsetof(struct vw_config, levels), PLUS, {-4, -2, 4}},
    {"log2-table", offsetof(struct vw_config, log2_table), PLUS, {-4, -2, 2, 4}},
    {"width", offsetof(struct vw_config, width), SET, {16, 32, 64}},
    {"epochs", offsetof(struct vw_config, epochs), TIMES, {0.25, 0.5, 2}},
};
static const double downscales[] = {2, 4}; // times the base's
static const char *const other_parameters[] = {"table-precision", "downscale", "effects", "accuracy"};
static const double FULL_RESOLUTION_RAYS = 2; // times the base's: the most that `rays` tries

// ---- Which parameters
// --------------------------------------------------------------------------------------------------------

static bool is_parameter(const char *word, size_t length) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps); i++)
        if (strlen(sweeps[i].parameter) == length && !strncmp(sweeps[i].parameter, word, length)) return true;
    for (size_t i = 0; i < VW_ARRAY_COUNT(other_parameters); i++)
        if (strlen(other_parameters[i]) == length && !strncmp(other_parameters[i], word, length)) return true;
    return false;
}

static const char *next_word(const char *word) {
    const char *comma = strchr(word, ',');
    return comma ? comma + 1 : NULL;
}

enum vw_status vw_sweep_check_parameters(const char *parameters) {
    for (const char *word = parameters; word; word = next_word(word))
        if (!is_parameter(word, strcspn(word, ",")))
            return vw_fail(VW_ERROR_USAGE, "--parameters: \"%.*s\" is none of " VW_SWEEP_PARAMETERS,
                           (int)strcspn(word, ","), word);
    return VW_OK;
}

static bool is_wanted(const struct vw_options *options, const char *parameter) {
    if (!options->parameters) return true;
    for (const char *word = options->parameters; word; word = next_word(word))
        if (strlen(parameter) == strcspn(word, ",") && !strncmp(word, parameter, strlen(parameter))) return true;
    return false;
}

// ---- Points
// -------------------------------------------------------------------------------------------------------------

// Adds a configuration of that config, at the base's downscale.
static enum vw_status add(struct vw_sweep_configurations *configurations, const char *parameter, const char *value,
                          const struct vw_config *config) {
    if (configurations->count == VW_CONFIGURATIONS_MAX)
        return vw_fail(VW_ERROR_USAGE, "more than %d configurations to try; choose fewer by --parameters",
                       VW_CONFIGURATIONS_MAX);
    struct vw_sweep_configuration *configuration = &configurations->configurations[configurations->count++];
    *configuration = (struct vw_sweep_configuration){
        .parameter = parameter, .config = *config, .downscale = configurations->configurations[0].downscale};
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

// All that a sweep turns, as it is at the base.
static void describe_base(struct vw_sweep_configuration *base) {
    size_t used = 0, size_bytes = sizeof base->value;
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps) && used < size_bytes; i++)
        used += (size_t)snprintf(base->value + used, size_bytes - used, "%s %" PRIu32 ", ", sweeps[i].parameter,
                                 *(const uint32_t *)((const char *)&base->config + sweeps[i].offset));
    if (used < size_bytes)
        snprintf(base->value + used, size_bytes - used, "table-precision %s, downscale %" PRIu32,
                 vw_table_precision_name(base->config.table_precision), base->downscale);
}

// The effects that are on, as --effects takes them, but for one (NULL: none). False when the list is too long.
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

// So many rays that every validation view takes all its pixels: as many as the largest has, for each.
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
                   " validation pixels are more than can be measured in every step; take a higher --downscale",
                   scene->path, pixels);
}

// The number that a sweep sets, 0 where it cannot be one.
static uint32_t number_of(const struct sweep *sweep, uint32_t base, double value) {
    double number = sweep->how == TIMES ? base * value : sweep->how == PLUS ? base + value : value;
    return number < 1 ? 0 : (uint32_t)number;
}

// Whether a value can be trained, and has scores.
static bool is_admitted(const struct vw_config *config) {
    return config->epochs > config->burn_in_epochs && !vw_config_check(config);
}

static enum vw_status add_sweep(const struct vw_session *session, const struct sweep *sweep,
                                struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    const struct vw_config *base = &configurations->configurations[0].config;
    uint32_t of_base = *(const uint32_t *)((const char *)base + sweep->offset);
    bool val_rays = sweep->offset == offsetof(struct vw_config, val_rays);
    uint32_t least = val_rays ? VAL_RAYS_PER_VIEW * session->scene->split_count[VW_SPLIT_VAL] : 0;
    uint64_t most = val_pixels(session->scene);
    for (int i = 0; i < SETTINGS_MAX && sweep->settings[i] != 0 && !status; i++) {
        struct vw_config config = *base;
        char value[SETTING_BYTES];
        uint32_t number = number_of(sweep, of_base, sweep->settings[i]);
        if (number < least) number = least;
        *(uint32_t *)((char *)&config + sweep->offset) = number;
        snprintf(value, sizeof value, "%" PRIu32, number);
        bool base_again = number == (of_base < least ? least : of_base), all_again = val_rays && number >= most;
        if (base_again || all_again || is_listed(configurations, sweep->parameter, value) || !is_admitted(&config))
            continue;
        status = add(configurations, sweep->parameter, value, &config);
    }
    return status;
}

static enum vw_status add_all_pixels(const struct vw_session *session, struct vw_sweep_configurations *configurations) {
    struct vw_config config = configurations->configurations[0].config;
    config.val_rays = (uint32_t)val_pixels(session->scene);
    configurations->all_pixels = configurations->count;
    return add(configurations, "val-rays", "all", &config);
}

static enum vw_status add_downscales(struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(downscales) && !status; i++) {
        char value[SETTING_BYTES];
        uint32_t downscale = (uint32_t)(configurations->configurations[0].downscale * downscales[i]);
        if (downscale > 64) continue; // what --downscale admits
        snprintf(value, sizeof value, "%" PRIu32, downscale);
        status = add(configurations, "downscale", value, &configurations->configurations[0].config);
        if (!status) configurations->configurations[configurations->count - 1].downscale = downscale;
    }
    return status;
}

static enum vw_status add_effects(const struct vw_session *session, struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < session->effect_count && !status; i++) {
        char value[SETTING_BYTES];
        struct vw_config config = configurations->configurations[0].config;
        if (!session->effects[i].on) continue;
        snprintf(value, sizeof value, "without-%s", session->effects[i].name);
        spell_effects(session, session->effects[i].name, config.effects);
        status = add(configurations, "effects", value, &config);
    }
    return status;
}

static enum vw_status add_table_precisions(struct vw_sweep_configurations *configurations) {
    enum vw_status status = VW_OK;
    for (enum vw_table_precision precision = VW_TABLE_FLOAT32; precision <= VW_TABLE_FLOAT16 && !status; precision++) {
        struct vw_config config = configurations->configurations[0].config;
        if (precision == config.table_precision) continue;
        config.table_precision = precision;
        if (!is_admitted(&config)) continue;
        status = add(configurations, "table-precision", vw_table_precision_name(precision), &config);
    }
    return status;
}

// The settings of --accuracy, with epochs of their own: but for one that is the base.
static enum vw_status add_accuracies(struct vw_sweep_configurations *configurations) {
    uint32_t count = 0;
    const struct vw_preset *settings = vw_presets(&count);
    char of_base[VW_PRESET_TEXT_BYTES], ours[VW_PRESET_TEXT_BYTES];
    vw_preset_options(&configurations->configurations[0].config, of_base);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        struct vw_config config = configurations->configurations[0].config;
        vw_preset_apply(&settings[i], &config);
        vw_preset_options(&config, ours);
        if (strcmp(ours, of_base) == 0 || !is_admitted(&config)) continue;
        status = add(configurations, "accuracy", settings[i].name, &config);
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

enum vw_status vw_sweep_configurations_list(const struct vw_options *options, const struct vw_session *session,
                                            struct vw_sweep_configurations *configurations) {
    configurations->count = 0;
    configurations->all_pixels = UINT32_MAX;
    configurations->configurations[0].downscale = options->downscale;
    struct vw_config base = options->config;
    if (!spell_effects(session, NULL, base.effects))
        return vw_fail(VW_ERROR_USAGE, "--effects: the list is too long; name fewer");
    enum vw_status status = check_val_pixels(session->scene);
    if (!status) status = add(configurations, "base", "", &base);
    if (!status) describe_base(&configurations->configurations[0]);
    if (!status) status = add_full_resolution(session, configurations);
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps) && !status; i++) {
        if (!is_wanted(options, sweeps[i].parameter)) continue;
        status = add_sweep(session, &sweeps[i], configurations);
        if (!status && sweeps[i].offset == offsetof(struct vw_config, val_rays))
            status = add_all_pixels(session, configurations);
    }
    if (!status && is_wanted(options, "table-precision")) status = add_table_precisions(configurations);
    if (!status && is_wanted(options, "downscale")) status = add_downscales(configurations);
    if (!status && is_wanted(options, "effects")) status = add_effects(session, configurations);
    if (!status && is_wanted(options, "accuracy")) status = add_accuracies(configurations);
    return status;
}

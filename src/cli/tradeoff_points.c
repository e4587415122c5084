#include "cli/tradeoff_points.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "cli/settings.h"
#include "viewworth/memory.h"

enum how { TIMES, PLUS, SET };
enum { SETTINGS_MAX = 8, SETTING_BYTES = 32, VAL_RAYS_PER_VIEW = 32 }; // as validation takes at least

// A number of the config and what it is set to, from its value at the base.
static const struct sweep {
    const char *knob;
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
static const char *const other_knobs[] = {"table-precision", "downscale", "effects", "accuracy"};
static const double EXHAUSTIVE_RAYS = 2; // times the base's: the most that `rays` tries

// ---- Which knobs --------------------------------------------------------------------------------------------------------

static bool is_knob(const char *word, size_t length) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps); i++)
        if (strlen(sweeps[i].knob) == length && !strncmp(sweeps[i].knob, word, length)) return true;
    for (size_t i = 0; i < VW_ARRAY_COUNT(other_knobs); i++)
        if (strlen(other_knobs[i]) == length && !strncmp(other_knobs[i], word, length)) return true;
    return false;
}

static const char *next_word(const char *word) {
    const char *comma = strchr(word, ',');
    return comma ? comma + 1 : NULL;
}

enum vw_status vw_tradeoff_check_knobs(const char *knobs) {
    for (const char *word = knobs; word; word = next_word(word))
        if (!is_knob(word, strcspn(word, ",")))
            return vw_fail(VW_ERROR_USAGE, "--knobs: \"%.*s\" is none of " VW_TRADEOFF_KNOBS, (int)strcspn(word, ","), word);
    return VW_OK;
}

static bool is_wanted(const struct vw_options *options, const char *knob) {
    if (!options->knobs) return true;
    for (const char *word = options->knobs; word; word = next_word(word))
        if (strlen(knob) == strcspn(word, ",") && !strncmp(word, knob, strlen(knob))) return true;
    return false;
}

// ---- Points -------------------------------------------------------------------------------------------------------------

// Adds a point of that config, at the base's downscale.
static enum vw_status add(struct vw_tradeoff_points *points, const char *knob, const char *setting, const struct vw_config *config) {
    if (points->count == VW_POINTS_MAX)
        return vw_fail(VW_ERROR_USAGE, "more than %d points to try; choose fewer by --knobs", VW_POINTS_MAX);
    struct vw_tradeoff_point *point = &points->points[points->count++];
    *point = (struct vw_tradeoff_point){.knob = knob, .config = *config, .downscale = points->points[0].downscale};
    snprintf(point->setting, sizeof point->setting, "%s", setting);
    snprintf(point->name, sizeof point->name, "%s%s%s", knob, *setting ? "-" : "", setting);
    return VW_OK;
}

static bool is_listed(const struct vw_tradeoff_points *points, const char *knob, const char *setting) {
    for (uint32_t i = 0; i < points->count; i++)
        if (!strcmp(points->points[i].knob, knob) && !strcmp(points->points[i].setting, setting)) return true;
    return false;
}

// All that a sweep turns, as it is at the base.
static void describe_base(struct vw_tradeoff_point *base) {
    size_t used = 0, size_bytes = sizeof base->setting;
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps) && used < size_bytes; i++)
        used += (size_t)snprintf(base->setting + used, size_bytes - used, "%s %" PRIu32 ", ", sweeps[i].knob,
                                 *(const uint32_t *)((const char *)&base->config + sweeps[i].offset));
    if (used < size_bytes)
        snprintf(base->setting + used, size_bytes - used, "table-precision %s, downscale %" PRIu32,
                 vw_table_precision_name(base->config.table_precision), base->downscale);
}

// The effects that are on, as --effects takes them, but for one (NULL: none). False when the list is too long.
static bool spell_effects(const struct vw_stage *stage, const char *without, char text[sizeof((struct vw_config *)0)->effects]) {
    const size_t text_bytes = sizeof((struct vw_config *)0)->effects;
    size_t used = 0;
    text[0] = 0;
    for (uint32_t i = 0; i < stage->effect_count && used < text_bytes; i++)
        if (stage->effects[i].on && (!without || strcmp(stage->effects[i].name, without) != 0))
            used += (size_t)snprintf(text + used, text_bytes - used, "%s%s", used ? "," : "", stage->effects[i].name);
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
                   "%s: %" PRIu64 " validation pixels are more than can be measured in every step; take a higher --downscale", scene->path,
                   pixels);
}

// The number that a sweep sets, 0 where it cannot be one.
static uint32_t number_of(const struct sweep *sweep, uint32_t base, double setting) {
    double number = sweep->how == TIMES ? base * setting : sweep->how == PLUS ? base + setting : setting;
    return number < 1 ? 0 : (uint32_t)number;
}

// Whether a setting can be trained, and has scores.
static bool is_admitted(const struct vw_config *config) { return config->epochs > config->burn_in_epochs && !vw_config_check(config); }

static enum vw_status add_sweep(const struct vw_stage *stage, const struct sweep *sweep, struct vw_tradeoff_points *points) {
    enum vw_status status = VW_OK;
    const struct vw_config *base = &points->points[0].config;
    uint32_t of_base = *(const uint32_t *)((const char *)base + sweep->offset);
    bool val_rays = sweep->offset == offsetof(struct vw_config, val_rays);
    uint32_t least = val_rays ? VAL_RAYS_PER_VIEW * stage->scene->split_count[VW_SPLIT_VAL] : 0;
    uint64_t most = val_pixels(stage->scene);
    for (int i = 0; i < SETTINGS_MAX && sweep->settings[i] != 0 && !status; i++) {
        struct vw_config config = *base;
        char setting[SETTING_BYTES];
        uint32_t number = number_of(sweep, of_base, sweep->settings[i]);
        if (number < least) number = least;
        *(uint32_t *)((char *)&config + sweep->offset) = number;
        snprintf(setting, sizeof setting, "%" PRIu32, number);
        bool base_again = number == (of_base < least ? least : of_base), all_again = val_rays && number >= most;
        if (base_again || all_again || is_listed(points, sweep->knob, setting) || !is_admitted(&config)) continue;
        status = add(points, sweep->knob, setting, &config);
    }
    return status;
}

static enum vw_status add_all_pixels(const struct vw_stage *stage, struct vw_tradeoff_points *points) {
    struct vw_config config = points->points[0].config;
    config.val_rays = (uint32_t)val_pixels(stage->scene);
    points->all_pixels = points->count;
    return add(points, "val-rays", "all", &config);
}

static enum vw_status add_downscales(struct vw_tradeoff_points *points) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(downscales) && !status; i++) {
        char setting[SETTING_BYTES];
        uint32_t downscale = (uint32_t)(points->points[0].downscale * downscales[i]);
        if (downscale > 64) continue; // what --downscale admits
        snprintf(setting, sizeof setting, "%" PRIu32, downscale);
        status = add(points, "downscale", setting, &points->points[0].config);
        if (!status) points->points[points->count - 1].downscale = downscale;
    }
    return status;
}

static enum vw_status add_effects(const struct vw_stage *stage, struct vw_tradeoff_points *points) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < stage->effect_count && !status; i++) {
        char setting[SETTING_BYTES];
        struct vw_config config = points->points[0].config;
        if (!stage->effects[i].on) continue;
        snprintf(setting, sizeof setting, "without-%s", stage->effects[i].name);
        spell_effects(stage, stage->effects[i].name, config.effects);
        status = add(points, "effects", setting, &config);
    }
    return status;
}

static enum vw_status add_table_precisions(struct vw_tradeoff_points *points) {
    enum vw_status status = VW_OK;
    for (enum vw_table_precision precision = VW_TABLE_FLOAT32; precision <= VW_TABLE_FLOAT16 && !status; precision++) {
        struct vw_config config = points->points[0].config;
        if (precision == config.table_precision) continue;
        config.table_precision = precision;
        if (!is_admitted(&config)) continue;
        status = add(points, "table-precision", vw_table_precision_name(precision), &config);
    }
    return status;
}

// The settings of --accuracy, with epochs of their own: but for one that is the base.
static enum vw_status add_accuracies(struct vw_tradeoff_points *points) {
    uint32_t count = 0;
    const struct vw_setting *settings = vw_settings(&count);
    char of_base[VW_SETTING_TEXT_BYTES], ours[VW_SETTING_TEXT_BYTES];
    vw_setting_options(&points->points[0].config, of_base);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        struct vw_config config = points->points[0].config;
        vw_setting_apply(&settings[i], &config);
        vw_setting_options(&config, ours);
        if (strcmp(ours, of_base) == 0 || !is_admitted(&config)) continue;
        status = add(points, "accuracy", settings[i].name, &config);
    }
    return status;
}

static enum vw_status add_exhaustive(const struct vw_stage *stage, struct vw_tradeoff_points *points) {
    struct vw_config config = points->points[0].config;
    uint32_t rays = config.rays;
    config.val_rays = (uint32_t)val_pixels(stage->scene);
    config.rays = number_of(&sweeps[0], rays, EXHAUSTIVE_RAYS);
    if (!is_admitted(&config)) config.rays = rays;
    points->exhaustive = points->count;
    return add(points, "exhaustive", "", &config);
}

enum vw_status vw_tradeoff_points_list(const struct vw_options *options, const struct vw_stage *stage, struct vw_tradeoff_points *points) {
    points->count = 0;
    points->all_pixels = UINT32_MAX;
    points->points[0].downscale = options->downscale;
    struct vw_config base = options->config;
    if (!spell_effects(stage, NULL, base.effects)) return vw_fail(VW_ERROR_USAGE, "--effects: the list is too long; name fewer");
    enum vw_status status = check_val_pixels(stage->scene);
    if (!status) status = add(points, "base", "", &base);
    if (!status) describe_base(&points->points[0]);
    if (!status) status = add_exhaustive(stage, points);
    for (size_t i = 0; i < VW_ARRAY_COUNT(sweeps) && !status; i++) {
        if (!is_wanted(options, sweeps[i].knob)) continue;
        status = add_sweep(stage, &sweeps[i], points);
        if (!status && sweeps[i].offset == offsetof(struct vw_config, val_rays)) status = add_all_pixels(stage, points);
    }
    if (!status && is_wanted(options, "table-precision")) status = add_table_precisions(points);
    if (!status && is_wanted(options, "downscale")) status = add_downscales(points);
    if (!status && is_wanted(options, "effects")) status = add_effects(stage, points);
    if (!status && is_wanted(options, "accuracy")) status = add_accuracies(points);
    return status;
}

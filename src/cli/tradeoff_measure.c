#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/interrupt.h"
#include "cli/seed_runs.h"
#include "cli/tradeoff.h"
#include "cli/turns.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/psnr.h"
#include "viewworth/statistics.h"

enum { ROUNDS = 8, STEPS_PER_BATCH = 2, PIXELS_OF_VIEW_MAX = 1 << 16 };

// ---- What is kept -------------------------------------------------------------------------------------------------------

static const struct measure {
    const char *name;
    size_t offset;
} measures[] = {
#define MEASURE(name, field)                                                                                                               \
    { name, offsetof(struct vw_measured_point, field) }
    MEASURE("train_ms", train.wall_ms),    MEASURE("train_cpu_ms", train.cpu_ms), MEASURE("value_ms", value.wall_ms),
    MEASURE("value_cpu_ms", value.cpu_ms), MEASURE("base_ms", base.wall_ms),      MEASURE("base_cpu_ms", base.cpu_ms),
    MEASURE("device_bytes", device_bytes),
};

static double *field_of(struct vw_measured_point *measured, const struct measure *measure) {
    return (double *)((char *)measured + measure->offset);
}

static enum vw_status recall(struct vw_tradeoff *tradeoff, uint32_t point, bool *found) {
    enum vw_status status = VW_OK;
    *found = true;
    for (size_t i = 0; i < VW_ARRAY_COUNT(measures) && *found && !status; i++)
        status = vw_tradeoffs_find(tradeoff->tradeoffs, tradeoff->point_ids[point], measures[i].name, found,
                                   field_of(&tradeoff->measured[point], &measures[i]));
    return status;
}

static enum vw_status keep(struct vw_tradeoff *tradeoff, uint32_t point) {
    struct vw_tradeoff_measure kept[VW_ARRAY_COUNT(measures)];
    for (size_t i = 0; i < VW_ARRAY_COUNT(measures); i++)
        kept[i] = (struct vw_tradeoff_measure){measures[i].name, *field_of(&tradeoff->measured[point], &measures[i])};
    return vw_tradeoffs_keep(tradeoff->tradeoffs, tradeoff->point_ids[point], kept, VW_ARRAY_COUNT(measures));
}

// ---- Time ---------------------------------------------------------------------------------------------------------------

static struct vw_trainer_params params_of(const struct vw_stage *stage, const struct vw_config *config,
                                          const struct vw_effect_verdict *effects, bool validate) {
    return (struct vw_trainer_params){.gpu = stage->gpu,
                                      .scene = stage->scene,
                                      .config = config,
                                      .effects = effects,
                                      .effect_count = stage->effect_count,
                                      .validate = validate,
                                      .steps_per_batch = STEPS_PER_BATCH};
}

// What is on at a point, among the verdicts of the base.
static enum vw_status choose_effects(const struct vw_tradeoff *tradeoff, uint32_t point,
                                     struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX]) {
    const struct vw_stage *stage = &tradeoff->laboratory.stage;
    memcpy(effects, stage->effects, sizeof stage->effects);
    return vw_effects_choose(tradeoff->points.points[point].config.effects, effects, stage->effect_count);
}

static struct vw_step_times times_of(const struct vw_turn_taker *taker) {
    struct vw_turn_result result = vw_turn_taker_conclude(taker, ROUNDS);
    return (struct vw_step_times){result.ms_per_step, result.cpu_ms_per_step};
}

// The base, the point without scoring, and the point with it, in turn.
static enum vw_status time_point(struct vw_tradeoff *tradeoff, uint32_t point) {
    enum { BASE, TRAIN, VALUE, TAKERS };
    const struct vw_stage *stage = &tradeoff->laboratory.stage;
    const struct vw_config *base = &tradeoff->points.points[0].config, *ours = &tradeoff->points.points[point].config;
    struct vw_measured_point *measured = &tradeoff->measured[point];
    struct vw_turn_taker takers[TAKERS] = {0};
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    enum vw_status status = choose_effects(tradeoff, point, effects);
    const struct vw_trainer_params params[] = {params_of(stage, base, stage->effects, true), params_of(stage, ours, effects, false),
                                               params_of(stage, ours, effects, true)};
    for (int i = 0; i < TAKERS && !status; i++) status = vw_turn_taker_enter(&params[i], ROUNDS, &takers[i]);
    if (!status) status = vw_turns_take(takers, TAKERS, ROUNDS);
    if (!status)
        *measured = (struct vw_measured_point){.train = times_of(&takers[TRAIN]),
                                               .value = times_of(&takers[VALUE]),
                                               .base = times_of(&takers[BASE]),
                                               .device_bytes = (double)takers[VALUE].device_bytes};
    for (int i = 0; i < TAKERS; i++) vw_turn_taker_leave(&takers[i]);
    return status;
}

enum vw_status vw_tradeoff_time_steps(struct vw_tradeoff *tradeoff) {
    const struct vw_stage *stage = &tradeoff->laboratory.stage;
    enum vw_status status = VW_OK;
    vw_log_info("timing   the steps of %u points%s", tradeoff->points.count,
                vw_effects_is_on(stage->effects, stage->effect_count, "occupancy") ? ", as they are before occupancy skips empty space"
                                                                                   : "");
    for (uint32_t point = 0; point < tradeoff->points.count && !status; point++) {
        bool found = false;
        status = recall(tradeoff, point, &found);
        if (!status && !found) status = time_point(tradeoff, point);
        if (!status && !found) status = keep(tradeoff, point);
        if (!status && !found)
            vw_log_info("timed    %s: %.3g ms a step, %.3g with scoring (%u of %u)", tradeoff->points.points[point].name,
                        tradeoff->measured[point].train.wall_ms, tradeoff->measured[point].value.wall_ms, point + 1,
                        tradeoff->points.count);
    }
    return status;
}

uint64_t vw_tradeoff_steps(const struct vw_tradeoff *tradeoff, uint32_t point) {
    return (uint64_t)tradeoff->points.points[point].config.epochs * tradeoff->laboratory.train_count;
}

void vw_tradeoff_step_ms(const struct vw_tradeoff *tradeoff, uint32_t point, double *train_ms, double *value_ms) {
    double base_ms[VW_POINTS_MAX];
    bool cpu = vw_gpu_get_info(tradeoff->laboratory.stage.gpu)->kind == VW_GPU_CPU;
    const struct vw_measured_point *measured = &tradeoff->measured[point];
    for (uint32_t i = 0; i < tradeoff->points.count; i++) base_ms[i] = tradeoff->measured[i].base.wall_ms;
    double median_ms = vw_median(base_ms, tradeoff->points.count);
    double of_base_ms = cpu ? measured->base.cpu_ms : measured->base.wall_ms;
    *train_ms = (cpu ? measured->train.cpu_ms : measured->train.wall_ms) / of_base_ms * median_ms;
    *value_ms = (cpu ? measured->value.cpu_ms : measured->value.wall_ms) / of_base_ms * median_ms;
}

// ---- PSNR ---------------------------------------------------------------------------------------------------------------

char *vw_tradeoff_folder(const struct vw_tradeoff *tradeoff, uint32_t point) {
    return vw_format_text("%s/points/%s", tradeoff->options->out, tradeoff->points.points[point].name);
}

static enum vw_status measure_field(struct vw_tradeoff *tradeoff, const char *path, const struct vw_config *config,
                                    const struct vw_effect_verdict *effects, double *psnr_db) {
    const struct vw_stage *stage = &tradeoff->laboratory.stage;
    const struct vw_trainer_params params = params_of(stage, config, effects, false);
    uint32_t *views = NULL, count = 0;
    struct vw_view_error *errors = NULL;
    struct vw_trainer *trainer = NULL;
    enum vw_status status = vw_scene_list_views(stage->scene, VW_SPLIT_VAL, &views, &count);
    if (!status) errors = vw_allocate(count, sizeof *errors);
    if (!status && !errors) status = VW_ERROR_MEMORY;
    if (!status) status = vw_trainer_create(&params, &trainer);
    if (!status) status = vw_trainer_load_field(trainer, path);
    if (!status) status = vw_trainer_measure_views(trainer, views, count, PIXELS_OF_VIEW_MAX, errors);
    *psnr_db = 0;
    for (uint32_t i = 0; i < count && !status; i++) *psnr_db += vw_psnr_db(errors[i].mse) / count;
    vw_trainer_destroy(&trainer);
    free(errors);
    free(views);
    return status;
}

static enum vw_status measure_seed(struct vw_tradeoff *tradeoff, uint32_t point, uint32_t seed, double *psnr_db) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_config config = tradeoff->points.points[point].config;
    config.seed += seed;
    char *folder = vw_tradeoff_folder(tradeoff, point);
    char *path = folder ? vw_seed_run_path(folder, config.seed, "field.vwf") : NULL;
    enum vw_status status = path ? choose_effects(tradeoff, point, effects) : VW_ERROR_MEMORY;
    if (!status) status = measure_field(tradeoff, path, &config, effects, psnr_db);
    free(path);
    free(folder);
    return status;
}

enum vw_status vw_tradeoff_recall_psnr(struct vw_tradeoff *tradeoff, uint32_t point, bool *found) {
    return vw_tradeoffs_find(tradeoff->tradeoffs, tradeoff->point_ids[point], "val_psnr", found, &tradeoff->measured[point].val_psnr);
}

// Without masks, or the gain and bias that appearance fits by halves of photos, other pixels count than at the base.
static enum vw_status sees_base_pixels(const struct vw_tradeoff *tradeoff, uint32_t point, bool *same) {
    const struct vw_stage *stage = &tradeoff->laboratory.stage;
    struct vw_effect_verdict ours[VW_EFFECT_COUNT_MAX];
    enum vw_status status = choose_effects(tradeoff, point, ours);
    *same = vw_effects_fit_views(ours, stage->effect_count) == vw_effects_fit_views(stage->effects, stage->effect_count) &&
            vw_effects_is_on(ours, stage->effect_count, "masks") == vw_effects_is_on(stage->effects, stage->effect_count, "masks");
    return status;
}

enum vw_status vw_tradeoff_measure_psnr(struct vw_tradeoff *tradeoff, uint32_t point) {
    double sum_db = 0;
    bool same = true;
    enum vw_status status = sees_base_pixels(tradeoff, point, &same);
    for (uint32_t seed = 0; seed < tradeoff->options->seeds && !status && same; seed++) {
        double psnr_db = NAN;
        status = measure_seed(tradeoff, point, seed, &psnr_db);
        sum_db += psnr_db;
    }
    const struct vw_tradeoff_measure kept = {"val_psnr", same ? sum_db / tradeoff->options->seeds : NAN};
    tradeoff->measured[point].val_psnr = kept.value;
    return status ? status : vw_tradeoffs_keep(tradeoff->tradeoffs, tradeoff->point_ids[point], &kept, 1);
}

// What accuracy costs in time: the scene is valued at the base setting and at points around it, each with one knob changed.
#include "cli/tradeoff.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/out_folder.h"
#include "cli/report_folder.h"
#include "cli/seed_runs.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"

// Trainings on halves have other seeds than the valued runs: an initialisation that both shared would lift how well they agree.
static uint64_t first_judging_seed(const struct vw_options *options) { return options->config.seed + options->seeds; }

static enum vw_status check(const struct vw_options *options) {
    const struct vw_config *config = &options->config;
    uint64_t seeds = options->seeds + VW_SUBSET_SEEDS;
    if (config->epochs <= config->burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u, and no scores to compare; ask for more",
                       config->epochs, config->burn_in_epochs);
    if (config->seed > (uint64_t)INT64_MAX - (seeds - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the %" PRIu64 " seeds counted from it pass %" PRId64 ", the largest; begin with a lower one",
                       config->seed, seeds, INT64_MAX);
    if (vw_file_exists(options->out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", options->out);
    enum vw_status status = vw_tradeoff_check_knobs(options->knobs);
    return status ? status : vw_out_check(options->out);
}

// ---- Opening ------------------------------------------------------------------------------------------------------------

// All that a point's figures depend on: the base's run, which knows scene, device and shaders, and the point's own config and length.
static enum vw_status name_point(struct vw_tradeoff *tradeoff, uint32_t point) {
    const struct vw_tradeoff_point *of_point = &tradeoff->points.points[point];
    struct vw_hasher hasher;
    uint8_t hash[32];
    char *config = vw_config_to_json(&of_point->config, false);
    if (!config) return VW_ERROR_MEMORY;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth point 1");
    vw_hasher_add_text(&hasher, tradeoff->laboratory.base_id);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher, of_point->downscale);
    vw_hasher_add_integer(&hasher, tradeoff->options->seeds);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, tradeoff->point_ids[point]);
    free(config);
    return VW_OK;
}

static enum vw_status open_sweep(struct vw_tradeoff *tradeoff) {
    const struct vw_options *options = tradeoff->options;
    struct vw_laboratory *laboratory = &tradeoff->laboratory;
    char *path = vw_path_join(options->out, "tradeoff.db");
    enum vw_status status = path ? vw_stage_open(options, &laboratory->stage) : VW_ERROR_MEMORY;
    if (!status && !laboratory->stage.scene->split_count[VW_SPLIT_VAL])
        status = vw_fail(VW_ERROR_INPUT, "%s: no photo validates; give some by --val", options->operand);
    if (!status) status = vw_folder_create(options->out);
    if (!status) status = vw_laboratory_open(options, laboratory);
    if (!status) status = vw_tradeoffs_open(path, &tradeoff->tradeoffs);
    if (!status) status = vw_tradeoff_points_list(options, &laboratory->stage, &tradeoff->points);
    for (uint32_t i = 0; i < tradeoff->points.count && !status; i++) status = name_point(tradeoff, i);
    free(path);
    return status;
}

// ---- Runs ---------------------------------------------------------------------------------------------------------------

// From what steps take. Trainings on halves take half the base's steps; setting up and measuring are not in it.
static void say_duration(const struct vw_tradeoff *tradeoff) {
    double seconds = 0, train_ms, value_ms;
    for (uint32_t i = 0; i < tradeoff->points.count; i++) {
        vw_tradeoff_step_ms(tradeoff, i, &train_ms, &value_ms);
        seconds += 1e-3 * value_ms * (double)vw_tradeoff_steps(tradeoff, i) * tradeoff->options->seeds;
    }
    vw_tradeoff_step_ms(tradeoff, 0, &train_ms, &value_ms);
    seconds += 1e-3 * train_ms * (double)vw_tradeoff_steps(tradeoff, 0) / 2 * tradeoff->options->halves * VW_SUBSET_SEEDS;
    vw_log_info("tradeoff %u points with %u seeds each, and %u trainings on halves: about %.0f min in all, less what is done already",
                tradeoff->points.count, tradeoff->options->seeds, tradeoff->options->halves * VW_SUBSET_SEEDS, ceil(seconds / 60));
}

// Whether the ledgers of all seeds lie in a point's folder.
static bool has_runs(const struct vw_tradeoff *tradeoff, const char *folder) {
    bool there = true;
    for (uint32_t i = 0; i < tradeoff->options->seeds && there; i++) {
        char *path = vw_seed_run_path(folder, tradeoff->options->config.seed + i, "ledger.db");
        there = path && vw_file_exists(path);
        free(path);
    }
    return there;
}

// A point whose PSNR is known has runs that are finished.
static enum vw_status make_point(struct vw_tradeoff *tradeoff, uint32_t point, const char *folder) {
    const struct vw_tradeoff_point *of_point = &tradeoff->points.points[point];
    struct vw_options options = *tradeoff->options;
    bool known = false;
    enum vw_status status = vw_tradeoff_recall_psnr(tradeoff, point, &known);
    if (status || (known && has_runs(tradeoff, folder))) return status;
    options.out = folder;
    options.config = of_point->config;
    options.downscale = of_point->downscale;
    vw_log_info("point    %s (%u of %u)", of_point->name, point + 1, tradeoff->points.count);
    status = vw_seed_runs_make(&options, 0, options.seeds);
    return status || known ? status : vw_tradeoff_measure_psnr(tradeoff, point);
}

static enum vw_status make_points(struct vw_tradeoff *tradeoff) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < tradeoff->points.count && !status; i++) {
        char *folder = vw_tradeoff_folder(tradeoff, i);
        status = folder ? make_point(tradeoff, i, folder) : VW_ERROR_MEMORY;
        free(folder);
    }
    return status;
}

static enum vw_status try_halves(struct vw_tradeoff *tradeoff) {
    struct vw_laboratory *laboratory = &tradeoff->laboratory;
    const struct vw_options *options = tradeoff->options;
    if (!options->halves) return VW_OK;
    enum vw_status status = vw_subsets_draw(laboratory->train_count, options->halves, &tradeoff->subsets);
    laboratory->planned = (uint64_t)tradeoff->subsets.count * VW_SUBSET_SEEDS;
    if (status) return status;
    return vw_subsets_try(&tradeoff->subsets, laboratory->train_views, first_judging_seed(options), vw_laboratory_try, laboratory);
}

// ---- Results ------------------------------------------------------------------------------------------------------------

static enum vw_status conclude(struct vw_tradeoff *tradeoff) {
    const struct vw_options *options = tradeoff->options;
    const struct vw_report_options report = {.scene = tradeoff->laboratory.stage.scene, .no_thumbnails = true};
    char *report_path = NULL, *csv_path = vw_path_join(options->out, "tradeoff.csv");
    enum vw_status status = csv_path ? vw_tradeoff_make_figures(tradeoff) : VW_ERROR_MEMORY;
    if (!status) status = vw_tradeoffs_set_figures(tradeoff->tradeoffs, tradeoff->point_ids[0], tradeoff->figures, tradeoff->figure_count);
    if (!status) status = vw_tradeoff_write_csv(tradeoff, csv_path);
    if (!status) report_path = vw_report_folder_conclude(options->out, &report);
    if (!status && options->json) status = vw_tradeoff_print_json(tradeoff, csv_path, report_path);
    else if (!status) vw_tradeoff_print(tradeoff, csv_path, report_path);
    free(report_path);
    free(csv_path);
    return status;
}

static enum vw_status sweep(struct vw_tradeoff *tradeoff) {
    vw_interrupt_watch();
    enum vw_status status = open_sweep(tradeoff);
    if (!status) status = vw_tradeoff_time_steps(tradeoff);
    if (status) return status;
    say_duration(tradeoff);
    status = make_points(tradeoff);
    if (!status) status = try_halves(tradeoff);
    return status ? status : conclude(tradeoff);
}

enum vw_status vw_command_tradeoff(const struct vw_options *options) {
    enum vw_status status = check(options);
    if (status) return status;
    struct vw_tradeoff *tradeoff = vw_allocate(1, sizeof *tradeoff);
    if (!tradeoff) return VW_ERROR_MEMORY;
    tradeoff->options = options;
    status = sweep(tradeoff);
    free(tradeoff->figures);
    vw_subsets_free(&tradeoff->subsets);
    vw_tradeoffs_close(&tradeoff->tradeoffs);
    vw_laboratory_close(&tradeoff->laboratory);
    free(tradeoff);
    return status;
}

// What accuracy costs in time: the scene is valued at the base setting and at configurations around it, each with one
// parameter changed.
#include "experiment/sweep/sweep.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/params.h"
#include "run/out_folder.h"
#include "run/outputs/report_folder.h"
#include "experiment/seed_runs.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/hash.h"
#include "base/memory.h"

// Trainings on halves have other seeds than the valued runs: an initialisation that both shared would lift how well
// they agree.
static uint64_t first_evaluation_seed(const struct vw_options *options) {
    return options->config.seed + options->seeds;
}

static enum vw_status check(const struct vw_options *options) {
    const struct vw_config *config = &options->config;
    uint64_t seeds = options->seeds + VW_SUBSET_SEEDS;
    if (config->epochs <= config->burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE,
                       "--epochs %u leaves no epoch after --burn-in %u, and no scores to compare; ask for more",
                       config->epochs, config->burn_in_epochs);
    if (config->seed > (uint64_t)INT64_MAX - (seeds - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the %" PRIu64 " seeds counted from it pass %" PRId64
                       ", the largest; begin with a lower one",
                       config->seed, seeds, INT64_MAX);
    if (vw_file_exists(options->out))
        return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", options->out);
    enum vw_status status = vw_sweep_check_parameters(options->parameters);
    return status ? status : vw_out_check(options->out);
}

// ---- Opening
// ------------------------------------------------------------------------------------------------------------

// All that a configuration's metrics depend on: the base's run, which knows scene, device and shaders, and the
// configuration's own config and length.
static enum vw_status name_configuration(struct vw_sweep *tradeoff, uint32_t configuration) {
    const struct vw_sweep_configuration *of_configuration = &tradeoff->configurations.configurations[configuration];
    struct vw_hasher hasher;
    uint8_t hash[32];
    char *config = vw_config_to_json(&of_configuration->config, false);
    if (!config) return VW_ERROR_MEMORY;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth configuration 1");
    vw_hasher_add_text(&hasher, tradeoff->retrainer.base_id);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher, of_configuration->downscale);
    vw_hasher_add_integer(&hasher, tradeoff->options->seeds);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, tradeoff->configuration_ids[configuration]);
    free(config);
    return VW_OK;
}

static enum vw_status open_sweep(struct vw_sweep *tradeoff) {
    const struct vw_options *options = tradeoff->options;
    struct vw_retrainer *retrainer = &tradeoff->retrainer;
    const struct vw_session_params params = vw_params_of_session(options);
    char *path = vw_path_join(options->out, "tradeoff.db");
    enum vw_status status = path ? vw_session_open(&params, &retrainer->session) : VW_ERROR_MEMORY;
    if (!status && !retrainer->session.scene->split_count[VW_SPLIT_VAL])
        status = vw_fail(VW_ERROR_INPUT, "%s: no photo validates; give some by --val", options->operand);
    if (!status) status = vw_folder_create(options->out);
    if (!status) status = vw_retrainer_open(options, retrainer);
    if (!status) status = vw_sweeps_open(path, &tradeoff->tradeoffs);
    if (!status) status = vw_sweep_configurations_list(options, &retrainer->session, &tradeoff->configurations);
    for (uint32_t i = 0; i < tradeoff->configurations.count && !status; i++) status = name_configuration(tradeoff, i);
    free(path);
    return status;
}

// ---- Runs
// ---------------------------------------------------------------------------------------------------------------

// From what steps take. Trainings on halves take half the base's steps; setting up and measuring are not in it.
static void say_duration(const struct vw_sweep *tradeoff) {
    double seconds = 0, train_ms, value_ms;
    for (uint32_t i = 0; i < tradeoff->configurations.count; i++) {
        vw_sweep_step_ms(tradeoff, i, &train_ms, &value_ms);
        seconds += 1e-3 * value_ms * (double)vw_sweep_steps(tradeoff, i) * tradeoff->options->seeds;
    }
    vw_sweep_step_ms(tradeoff, 0, &train_ms, &value_ms);
    seconds += 1e-3 * train_ms * (double)vw_sweep_steps(tradeoff, 0) / 2 * tradeoff->options->halves * VW_SUBSET_SEEDS;
    vw_log_info("tradeoff %u configurations with %u seeds each, and %u trainings on halves: about %.0f min in all, "
                "less what is done already",
                tradeoff->configurations.count, tradeoff->options->seeds, tradeoff->options->halves * VW_SUBSET_SEEDS,
                ceil(seconds / 60));
}

// Whether the ledgers of all seeds lie in a configuration's folder.
static bool has_runs(const struct vw_sweep *tradeoff, const char *folder) {
    bool there = true;
    for (uint32_t i = 0; i < tradeoff->options->seeds && there; i++) {
        char *path = vw_seed_run_path(folder, tradeoff->options->config.seed + i, "ledger.db");
        there = path && vw_file_exists(path);
        free(path);
    }
    return there;
}

// A configuration whose PSNR is known has runs that are finished.
static enum vw_status make_configuration(struct vw_sweep *tradeoff, uint32_t configuration, const char *folder) {
    const struct vw_sweep_configuration *of_configuration = &tradeoff->configurations.configurations[configuration];
    struct vw_options options = *tradeoff->options;
    bool known = false;
    enum vw_status status = vw_sweep_recall_psnr(tradeoff, configuration, &known);
    if (status || (known && has_runs(tradeoff, folder))) return status;
    options.out = folder;
    options.config = of_configuration->config;
    options.downscale = of_configuration->downscale;
    vw_log_info("configuration    %s (%u of %u)", of_configuration->name, configuration + 1,
                tradeoff->configurations.count);
    status = vw_seed_runs_make(&options, 0, options.seeds);
    return status || known ? status : vw_sweep_measure_psnr(tradeoff, configuration);
}

static enum vw_status make_configurations(struct vw_sweep *tradeoff) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < tradeoff->configurations.count && !status; i++) {
        char *folder = vw_sweep_folder(tradeoff, i);
        status = folder ? make_configuration(tradeoff, i, folder) : VW_ERROR_MEMORY;
        free(folder);
    }
    return status;
}

static enum vw_status try_halves(struct vw_sweep *tradeoff) {
    struct vw_retrainer *retrainer = &tradeoff->retrainer;
    const struct vw_options *options = tradeoff->options;
    if (!options->halves) return VW_OK;
    enum vw_status status = vw_subsets_draw(retrainer->train_count, options->halves, &tradeoff->subsets);
    retrainer->planned = (uint64_t)tradeoff->subsets.count * VW_SUBSET_SEEDS;
    if (status) return status;
    return vw_subsets_retrain(&tradeoff->subsets, retrainer->train_views, first_evaluation_seed(options), vw_retrain,
                              retrainer);
}

// ---- Results
// ------------------------------------------------------------------------------------------------------------

static enum vw_status finish(struct vw_sweep *tradeoff) {
    const struct vw_options *options = tradeoff->options;
    const struct vw_report_params report = {.scene = tradeoff->retrainer.session.scene, .no_thumbnails = true};
    char *report_path = NULL, *csv_path = vw_path_join(options->out, "tradeoff.csv");
    enum vw_status status = csv_path ? vw_sweep_make_metrics(tradeoff) : VW_ERROR_MEMORY;
    if (!status)
        status = vw_sweeps_set_metrics(tradeoff->tradeoffs, tradeoff->configuration_ids[0], tradeoff->metrics,
                                       tradeoff->metric_count);
    if (!status) status = vw_sweep_write_csv(tradeoff, csv_path);
    if (!status) report_path = vw_report_folder_finish(options->out, &report, NULL);
    if (!status && options->json) status = vw_sweep_print_json(tradeoff, csv_path, report_path);
    else if (!status) vw_sweep_print(tradeoff, csv_path, report_path);
    free(report_path);
    free(csv_path);
    return status;
}

static enum vw_status sweep(struct vw_sweep *tradeoff) {
    vw_interrupt_watch();
    enum vw_status status = open_sweep(tradeoff);
    if (!status) status = vw_sweep_time_steps(tradeoff);
    if (status) return status;
    say_duration(tradeoff);
    status = make_configurations(tradeoff);
    if (!status) status = try_halves(tradeoff);
    return status ? status : finish(tradeoff);
}

enum vw_status vw_command_tradeoff(const struct vw_options *options) {
    enum vw_status status = check(options);
    if (status) return status;
    struct vw_sweep *tradeoff = vw_allocate(1, sizeof *tradeoff);
    if (!tradeoff) return VW_ERROR_MEMORY;
    tradeoff->options = options;
    status = sweep(tradeoff);
    free(tradeoff->metrics);
    vw_subsets_free(&tradeoff->subsets);
    vw_sweeps_close(&tradeoff->tradeoffs);
    vw_retrainer_close(&tradeoff->retrainer);
    free(tradeoff);
    return status;
}

#include "run/imported/import_steps.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/hash.h"
#include "ledger/step_log.h"
#include "run/imported/imported_run.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/run_outputs.h"
#include "run/scoring.h"
#include "value/series.h"
#include "viewworth/log.h"
#include "viewworth/version.h"

struct import {
    const struct vw_import_params *params;
    struct vw_config config;
    struct vw_step_log log;
    struct vw_out_lock *lock;        // lock of OUT
    char *ledger_path, *scores_path; // owned
    char log_sha256[VW_HASH_HEX_BYTES];
    char *config_json, *options_json; // owned; of the run row
    struct vw_ledger *ledger;
    struct vw_step_statistics statistics;
    uint64_t unvalidated; // steps with neither values nor a flag
    uint32_t score_count;
};

// ---- Reading -------------------------------------------------------------------------------------------------------

static void count_steps(struct import *import) {
    import->statistics = vw_step_statistics_begin();
    for (uint32_t i = 0; i < import->log.record_count; i++) {
        const struct vw_step_record *record = &import->log.records[i];
        vw_step_statistics_add(&import->statistics, record);
        import->unvalidated += record->view != VW_RECORD_UNTRAINED && !record->validated && !record->nonfinite;
    }
}

static void warn(const struct import *import) {
    if (import->statistics.nonfinite > 0)
        vw_log_warning("%" PRIu64 " steps were not finite and carry no value (step.nonfinite in the ledger)",
                       import->statistics.nonfinite);
    if (import->log.shared_count > 0)
        vw_log_warning("%" PRIu64 " steps were not validated: what changed between two validations, up to %" PRIu64
                       " steps apart, is credited in equal shares to the photos between, so that telling photos apart "
                       "takes about %" PRIu64 " times as many steps",
                       import->log.shared_count, import->log.validated_every, import->log.validated_every);
    if (import->unvalidated > 0)
        vw_log_warning("steps before the first validation or after the last one are not credited: %" PRIu64,
                       import->unvalidated);
    if (import->log.epochs <= import->config.burn_in_epochs)
        vw_log_warning("the log's %u epochs leave none after --burn-in %u: steps are recorded, but no scores",
                       import->log.epochs, import->config.burn_in_epochs);
}

// Checks all input before OUT is made.
static enum vw_status open_import(struct import *import) {
    const char *out = import->params->out;
    import->ledger_path = vw_path_join(out, "ledger.db");
    import->scores_path = vw_path_join(out, "scores.csv");
    if (!import->ledger_path || !import->scores_path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_out_check(out);
    if (!status && vw_file_exists(import->ledger_path))
        status = vw_fail(VW_ERROR_USAGE, "--out %s: already contains a run; name another folder", out);
    if (!status) status = vw_step_log_read(import->params->log, &import->log);
    if (status) return status;
    import->config = *import->params->config;
    import->config.epochs = import->log.epochs;
    count_steps(import);
    if (vw_step_statistics_are_void(&import->statistics))
        return vw_fail(VW_ERROR_INPUT, "%s: no step has finite values; import another log", import->params->log);
    status = vw_config_check(&import->config);
    if (!status) status = vw_out_lock_take(out, &import->lock);
    if (status) return status;
    vw_hash_to_hex(import->log.sha256, import->log_sha256);
    import->config_json = vw_imported_config_to_json(&import->config);
    import->options_json = vw_imported_options_to_json(import->log_sha256, import->log.validated_every);
    return import->config_json && import->options_json ? VW_OK : VW_ERROR_MEMORY;
}

static void close_import(struct import *import) {
    vw_ledger_close(&import->ledger);
    vw_step_log_clear(&import->log);
    free(import->config_json);
    free(import->options_json);
    free(import->ledger_path);
    free(import->scores_path);
    vw_out_lock_release(&import->lock);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

// Creates the ledger. The log and the fields that affect the scores identify the run; photos have names, but no files.
static enum vw_status create_ledger(struct import *import) {
    uint8_t names_hash[VW_HASH_BYTES];
    char run_id[VW_HASH_HEX_BYTES], names_hex[VW_HASH_HEX_BYTES], no_shaders[VW_HASH_HEX_BYTES] = "",
                                                                  started_utc[VW_UTC_BYTES];
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < import->log.image_count; i++) vw_hasher_add_text(&hasher, import->log.images[i].name);
    vw_hasher_end(&hasher, names_hash);
    vw_imported_run_id(import->log_sha256, &import->config, run_id);
    vw_hash_to_hex(names_hash, names_hex);
    memset(no_shaders, '0', sizeof no_shaders - 1);
    vw_utc_now(started_utc);
    const struct vw_ledger_run run = {
        .run_id = run_id,
        .scene_hash = names_hex,
        .scene_path = import->params->log,
        .config_json = import->config_json,
        .subset_hash = names_hex,
        .device = vw_imported_device,
        .driver = "none",
        .shader_hash = no_shaders,
        .version = vw_version(),
        .started_utc = started_utc,
        .scene_options_json = import->options_json,
        .effects_json = "[]",
    };
    return vw_ledger_create(import->ledger_path, &run, import->log.images, import->log.image_count, &import->ledger);
}

// Removes what somebody laid there, and writes the table before the ledger's end, so that a finished run has it.
static enum vw_status record(struct import *import) {
    struct vw_scoring scoring = {0};
    char finished_utc[VW_UTC_BYTES];
    enum vw_status status = vw_ledger_append(import->ledger, import->log.records, import->log.record_count, NULL);
    if (!status) status = vw_scoring_make(import->ledger, &import->config, &scoring);
    if (!status) status = vw_run_remove_outdated(import->params->out, false);
    if (!status) status = vw_run_scores_write(import->params->out, &scoring, false);
    vw_utc_now(finished_utc);
    if (!status)
        status = vw_ledger_finish(import->ledger, "finished", finished_utc, scoring.scores, scoring.score_count);
    import->score_count = scoring.score_count;
    vw_scoring_free(&scoring);
    return status;
}

static void mark_failed(struct import *import) {
    struct vw_saved_error why = vw_error_save();
    vw_scoring_end_early(import->ledger, &import->config, "failed");
    vw_error_restore(&why);
}

static enum vw_status fill_result(struct import *import, struct vw_import_result *result) {
    struct vw_ledger_run run;
    enum vw_status status = vw_ledger_get_run(import->ledger, &run);
    if (status) return status;
    *result = (struct vw_import_result){
        .ledger_path = import->ledger_path,
        .scores_path = import->scores_path,
        .photos = import->log.image_count,
        .epochs = import->log.epochs,
        .score_count = import->score_count,
        .validated_every = import->log.validated_every,
        .statistics = import->statistics,
    };
    import->ledger_path = import->scores_path = NULL; // the result owns them
    memcpy(result->log_sha256, import->log_sha256, sizeof result->log_sha256);
    snprintf(result->run_id, sizeof result->run_id, "%s", run.run_id);
    vw_ledger_chain_head(import->ledger, result->head);
    return VW_OK;
}

enum vw_status vw_import_make(const struct vw_import_params *params, struct vw_import_result *result) {
    struct import import = {.params = params};
    enum vw_status status = open_import(&import);
    if (!status) warn(&import);
    if (!status) status = create_ledger(&import);
    if (!status) status = record(&import);
    if (status && import.ledger) mark_failed(&import);
    if (!status) status = fill_result(&import, result);
    if (!status) status = vw_checksums_write(params->out, import.ledger);
    close_import(&import);
    return status;
}

void vw_import_result_free(struct vw_import_result *result) {
    free(result->ledger_path);
    free(result->scores_path);
    *result = (struct vw_import_result){0};
}

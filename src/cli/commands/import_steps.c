#include <inttypes.h>

#include "base/text.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "run/imported/import_steps.h"

static json_t *to_json(const char *log, const struct vw_import_result *result) {
    const struct vw_step_statistics *statistics = &result->statistics;
    return json_pack("{s:s, s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:s, s:s, s:o, s:o, s:s}", "run_id", result->run_id,
                     "log", log, "log_sha256", result->log_sha256, "photos", (json_int_t)result->photos, "epochs",
                     (json_int_t)result->epochs, "steps", (json_int_t)statistics->steps, "nonfinite",
                     (json_int_t)statistics->nonfinite, "validated_every",
                     (json_int_t)(result->validated_every ? result->validated_every : 1), "score_count",
                     (json_int_t)result->score_count, "ledger", result->ledger_path, "scores", result->scores_path,
                     "val_psnr_start_db", vw_json_real(statistics->first_val_psnr_db), "val_psnr_end_db",
                     vw_json_real(statistics->last_val_psnr_db), "head", result->head);
}

static void print_text(const struct vw_import_result *result) {
    vw_print("imported  %" PRIu64 " step%s on %u photo%s in %u epoch%s\n", result->statistics.steps,
             vw_plural(result->statistics.steps), result->photos, vw_plural(result->photos), result->epochs,
             vw_plural(result->epochs));
    vw_print("validation PSNR  %.2f dB after the last step\n", result->statistics.last_val_psnr_db);
    vw_print("ledger   %s\nscores   %s\n", result->ledger_path, result->scores_path);
    vw_print("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", result->head);
}

enum vw_status vw_command_import_steps(const struct vw_options *options) {
    const struct vw_import_params params = {.log = options->operand, .out = options->out, .config = &options->config};
    struct vw_import_result result = {0};
    enum vw_status status = vw_import_make(&params, &result);
    if (!status && options->json) status = vw_json_print(to_json(options->operand, &result));
    else if (!status) print_text(&result);
    vw_import_result_free(&result);
    return status;
}

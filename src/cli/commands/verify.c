#include <inttypes.h>
#include <string.h>

#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "cli/program.h"
#include "experiment/worth.h"
#include "run/verify/verify.h"

static json_t *to_json(const struct vw_verification *verification, uint32_t retrainings) {
    const char *log_sha256 = *verification->log_sha256 ? verification->log_sha256 : NULL;
    json_t *items = json_array(), *unlisted = json_array();
    for (uint32_t i = 0; i < verification->item_count; i++) {
        const struct vw_verify_item *item = &verification->items[i];
        vw_json_append(&items,
                       json_pack("{s:s, s:s, s:s}", "item", item->name, "result", item->result, "by", item->by));
    }
    for (uint32_t i = 0; i < verification->list.unlisted_count; i++)
        vw_json_append(&unlisted, json_string(verification->list.unlisted[i]));
    return json_pack("{s:b, s:s, s:s*, s:s, s:I, s:I, s:I, s:I, s:b, s:s, s:o, s:o}", "intact", 1, "run_id",
                     verification->run_id, "log_sha256", log_sha256, "status", verification->status, "steps",
                     (json_int_t)verification->steps, "scores", (json_int_t)verification->score_count, "replayed",
                     (json_int_t)verification->replayed_steps, "retrainings_repeated", (json_int_t)retrainings,
                     "lasting_repeated", verification->lasting_repeated, "head", verification->head, "checks", items,
                     "not_listed", unlisted);
}

// Says what was made again, and in one line what was not.
static void print_repeated(const struct vw_verification *verification, uint32_t retrainings) {
    bool no_steps = !verification->replayed_steps;
    bool no_retrainings = !retrainings && (no_steps || verification->retrainings);
    if (!no_steps) vw_print("replay   %" PRIu64 " repeated steps gave the same bits\n", verification->replayed_steps);
    if (retrainings) vw_print("replay   %" PRIu32 " retrainings made again gave the same bits\n", retrainings);
    if (verification->lasting_repeated) vw_print("replay   the backward pass made again gave the same bits\n");
    if (no_steps || no_retrainings)
        vw_print("%s%s%s not repeated (--replay all, --retrainings all)\n", no_steps ? "steps" : "",
                 no_steps && no_retrainings ? " and " : "", no_retrainings ? "retrainings" : "");
}

static void print_text(const struct vw_verification *verification, uint32_t retrainings) {
    vw_print("%s is intact: %" PRIu64 " steps, %u scores, %s\n", verification->ledger_path, verification->steps,
             verification->score_count, verification->status);
    if (strcmp(verification->status, "running") == 0)
        vw_print("the run has not ended, so removed last steps cannot be detected\n");
    if (*verification->log_sha256)
        vw_print("the run was imported, so its training cannot be checked; the log had the SHA-256\n         %s\n",
                 verification->log_sha256);
    else print_repeated(verification, retrainings);
    vw_print("head     %s\n\n%-23s %-12s %s\n", verification->head, "item", "result", "checked by");
    for (uint32_t i = 0; i < verification->item_count; i++) {
        const struct vw_verify_item *item = &verification->items[i];
        if (*item->by) vw_print("%-23s %-12s %s\n", item->name, item->result, item->by);
        else vw_print("%-23s %s\n", item->name, item->result);
    }
    for (uint32_t i = 0; i < verification->list.unlisted_count; i++)
        vw_print("%-23s %-12s nothing: not in SHA256SUMS\n", verification->list.unlisted[i], "not checked");
}

static enum vw_status repeat_retrainings(const struct vw_options *options, uint32_t *repeated) {
    if (!options->retrainings) return VW_OK;
    const struct vw_worth_run_params params = {
        .out = options->operand, .devices.first = options->device, .interrupt = vw_interrupt_watch()};
    return vw_worth_repeat(&params, options->retrainings, repeated);
}

enum vw_status vw_command_verify(const struct vw_options *options) {
    struct vw_verify_params params = {.out = options->operand,
                                      .expect = options->expect,
                                      .providers = options->scene.providers,
                                      .replay_steps = options->replay_steps,
                                      .lasting = options->lasting.wanted,
                                      .device = options->device};
    struct vw_verification verification = {0};
    uint32_t retrainings = 0;
    if (options->replay_steps || options->lasting.wanted) params.interrupt = vw_interrupt_watch();
    enum vw_status status = vw_run_verify(&params, &verification);
    if (!status) status = repeat_retrainings(options, &retrainings);
    if (!status && options->json) status = vw_json_print(to_json(&verification, retrainings));
    else if (!status) print_text(&verification, retrainings);
    vw_verification_free(&verification);
    return status;
}

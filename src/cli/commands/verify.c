#include <inttypes.h>
#include <string.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/print.h"
#include "run/verify/verify.h"

static json_t *to_json(const struct vw_verification *verification) {
    const char *log_sha256 = *verification->log_sha256 ? verification->log_sha256 : NULL;
    json_t *items = json_array(), *unlisted = json_array();
    for (uint32_t i = 0; i < verification->item_count; i++) {
        const struct vw_verify_item *item = &verification->items[i];
        vw_json_append(&items,
                       json_pack("{s:s, s:s, s:s}", "item", item->name, "result", item->result, "by", item->by));
    }
    for (uint32_t i = 0; i < verification->list.unlisted_count; i++)
        vw_json_append(&unlisted, json_string(verification->list.unlisted[i]));
    return json_pack("{s:b, s:s, s:s*, s:s, s:I, s:I, s:I, s:s, s:o, s:o}", "intact", 1, "run_id", verification->run_id,
                     "log_sha256", log_sha256, "status", verification->status, "steps", (json_int_t)verification->steps,
                     "scores", (json_int_t)verification->score_count, "replayed",
                     (json_int_t)verification->replayed_steps, "head", verification->head, "checks", items,
                     "not_listed", unlisted);
}

static void print_text(const struct vw_verification *verification, bool replayed) {
    vw_print("%s is intact: %" PRIu64 " steps, %u scores, %s\n", verification->ledger_path, verification->steps,
             verification->score_count, verification->status);
    if (strcmp(verification->status, "running") == 0)
        vw_print("the run has not ended, so removed last steps cannot be detected\n");
    if (*verification->log_sha256)
        vw_print("the run was imported, so its training cannot be checked; the log had the SHA-256\n         %s\n",
                 verification->log_sha256);
    if (replayed) vw_print("replay   %" PRIu64 " repeated steps gave the same bits\n", verification->replayed_steps);
    vw_print("head     %s\n\n%-23s %-12s %s\n", verification->head, "item", "result", "checked by");
    for (uint32_t i = 0; i < verification->item_count; i++) {
        const struct vw_verify_item *item = &verification->items[i];
        if (*item->by) vw_print("%-23s %-12s %s\n", item->name, item->result, item->by);
        else vw_print("%-23s %s\n", item->name, item->result);
    }
    for (uint32_t i = 0; i < verification->list.unlisted_count; i++)
        vw_print("%-23s %-12s nothing: not in SHA256SUMS\n", verification->list.unlisted[i], "not checked");
}

enum vw_status vw_command_verify(const struct vw_options *options) {
    struct vw_verify_params params = {.out = options->operand,
                                      .expect = options->expect,
                                      .providers = options->providers,
                                      .replay_steps = options->replay_steps,
                                      .device = options->device};
    struct vw_verification verification = {0};
    if (options->replay_steps) params.interrupt = vw_interrupt_watch();
    enum vw_status status = vw_run_verify(&params, &verification);
    if (!status && options->json) status = vw_json_print(to_json(&verification));
    else if (!status) print_text(&verification, options->replay_steps > 0);
    vw_verification_free(&verification);
    return status;
}

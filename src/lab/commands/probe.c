#include <inttypes.h>

#include "cli/output/print.h"
#include "cli/program.h"
#include "lab/commands/commands.h"
#include "lab/probes/probe_run.h"

static void print(const struct vw_probing *probing) {
    const struct vw_noise_floor *noise = &probing->noise;
    vw_print("replay   %" PRIu64 " repeated steps gave the same bits\n", probing->steps);
    if (noise->repeated_count)
        vw_print(
            "noise    validating once more moves PSNR by %g dB (%u times), a step with learning rate 0 by %g dB (%u "
            "times)\n         other pixels of the same photo move a step's delta by %.2g dB, %.2g of mean absolute "
            "error (%u resampled steps)\n",
            noise->repeated_db, noise->repeated_count, noise->zero_learning_rate_db, noise->zero_learning_rate_count,
            noise->resampled_db, noise->resampled_l1, noise->resampled_count);
    else vw_print("noise    no step was probed; value the scene with more --epochs\n");
    if (probing->states) vw_print("states   %u steps from %u states\n", probing->same_state_steps, probing->states);
    vw_print("time     probes took %.1f s, %.0f %% of all\nprobes   %s\nscores   %s\n", probing->seconds,
             100 * probing->share, probing->probes_path, probing->scores_path);
}

static json_t *to_json(const struct vw_probing *probing) {
    const struct vw_noise_floor *noise = &probing->noise;
    json_t *floor =
        json_pack("{s:I, s:o, s:I, s:o, s:I, s:o, s:o}", "repeated_count", (json_int_t)noise->repeated_count,
                  "repeated_db", vw_json_real(noise->repeated_db), "zero_learning_rate_count",
                  (json_int_t)noise->zero_learning_rate_count, "zero_learning_rate_db",
                  vw_json_real(noise->zero_learning_rate_db), "resampled_count", (json_int_t)noise->resampled_count,
                  "resampled_db", vw_json_real(noise->resampled_db), "resampled_l1", vw_json_real(noise->resampled_l1));
    return json_pack("{s:I, s:o, s:I, s:I, s:o, s:o, s:s, s:s}", "steps", (json_int_t)probing->steps, "noise_floor",
                     floor, "states", (json_int_t)probing->states, "same_state_steps",
                     (json_int_t)probing->same_state_steps, "seconds", vw_json_real(probing->seconds), "share",
                     vw_json_real(probing->share), "probes", probing->probes_path, "scores", probing->scores_path);
}

enum vw_status vw_lab_probe(const struct vw_options *options) {
    const struct vw_probe_params params = {.out = options->operand,
                                           .device = options->device,
                                           .same_state = vw_lab_options(options)->same_state,
                                           .lengthened = vw_lab_options(options)->lengthen_percent / 100.0,
                                           .interrupt = vw_interrupt_watch()};
    struct vw_probing probing;
    enum vw_status status = vw_probe_run(&params, &probing);
    if (!status && options->json) status = vw_json_print(to_json(&probing));
    else if (!status) print(&probing);
    vw_probing_free(&probing);
    return status;
}

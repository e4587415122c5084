// value_photos SCENE OUT [EPOCHS]: trains on the photos of a scene, shows its progress, and prints what each photo is
// worth, best first.
//
//     cc value_photos.c $(pkg-config --cflags --libs viewworth) -o value_photos && ./value_photos fox out/fox
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include <viewworth/viewworth.h>

static bool show_progress(void *context, const struct vw_run_state *state) {
    (void)context;
    fprintf(stderr, "step %" PRIu64 " of %" PRIu64 ", epoch %" PRIu32 " of %" PRIu32 ", validation PSNR %.2f dB\n",
            state->step, state->total_steps, state->epoch + 1, state->epochs, state->val_psnr_db);
    return true; // false asks the run to stop
}

static void show_message(void *context, enum vw_log_level level, const char *line) {
    (void)context;
    fprintf(stderr, "%s%s\n", level == VW_LOG_WARNING ? "warning: " : "", line);
}

static enum vw_status print_scores(const struct vw_run *run) {
    const struct vw_ledger_image *images = NULL;
    const struct vw_ledger_score *scores = NULL;
    uint32_t image_count = 0, score_count = 0;
    enum vw_status status = vw_run_images(run, &images, &image_count);
    if (!status) status = vw_run_scores(run, NULL, &scores, &score_count);
    for (uint32_t i = 0; i < score_count; i++)
        printf("%+.4f %s  %s\n", scores[i].value, scores[i].unit, images[scores[i].image_id].name);
    return status;
}

int main(int argument_count, char **arguments) {
    if (argument_count < 3) {
        fprintf(stderr, "usage: %s SCENE OUT [EPOCHS]\n", arguments[0]);
        return 2;
    }
    struct vw_config config = vw_config_default;
    if (argument_count > 3) config.epochs = (uint32_t)strtoul(arguments[3], NULL, 10);
    const struct vw_run_params params = {
        .scene = {.path = arguments[1]}, .out = arguments[2], .config = &config, .progress = show_progress};
    struct vw_run *run = NULL;
    vw_log_set_sink(show_message, NULL);
    enum vw_status status = vw_run_open(&params, &run);
    if (!status) status = vw_run_advance(run, UINT64_MAX);
    if (!status) status = vw_run_finish(run);
    if (!status) status = print_scores(run);
    if (status) fprintf(stderr, "%s: %s\n", arguments[0], vw_error_message());
    vw_run_close(&run);
    return vw_exit_code(status);
}

#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "check/mend.h"
#include "check/table.h"
#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/program.h"
#include "scene/formats/scene_copy.h"
#include "viewworth/log.h"

// Pixels of a photo beyond which it is checked at a smaller size: details of more are seldom sharp.
static const double PIXELS_MOST = 4e6;

// Returns the factor that reduces the largest photo to PIXELS_MOST.
static uint32_t choose_downscale(const struct vw_scene *scene) {
    double most = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        most = fmax(most, (double)scene->views[v].camera.width_px * scene->views[v].camera.height_px);
    return (uint32_t)fmax(ceil(sqrt(most / PIXELS_MOST)), 1);
}

static enum vw_status write_table(const char *path, const struct vw_rows *rows) {
    return path ? vw_rows_write_csv(path, rows) : VW_OK;
}

// Writes the copy, if one is asked for.
static enum vw_status copy(const struct vw_options *options, const struct vw_scene_params *opened,
                           struct vw_checked *checked) {
    const struct vw_interrupt interrupt = vw_interrupt_watch();
    const struct vw_mend_params params = {.opened = opened,
                                          .scene = checked->scene,
                                          .check = checked->check,
                                          .to = options->copy,
                                          .interrupt = &interrupt};
    return options->copy ? vw_check_mend(&params, &checked->mended_count) : VW_OK;
}

enum vw_status vw_command_check(const struct vw_options *options) {
    struct vw_scene_params params = options->scene;
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    struct vw_check check = {0};
    struct vw_check_row *rows = NULL;
    uint32_t count = 0;
    double began_s = vw_now_s();
    enum vw_status status = vw_params_open_scene(&params, choose_downscale, options->device, &gpu, &scene);
    if (!status && scene->missing) vw_log_warning("%s: %s", scene->path, scene->missing);
    if (!status && options->copy) status = vw_scene_copy_check(options->copy, scene);
    if (!status) status = vw_check_scene(scene, &check);
    if (!status) status = vw_check_make_rows(scene, &check, &rows, &count);
    const struct vw_rows table = vw_check_rows(rows, count);
    if (!status) status = write_table(options->to, &table);
    struct vw_checked checked = {scene, &check, rows, count, options->to, vw_now_s() - began_s, options->copy, 0};
    if (!status) status = copy(options, &params, &checked);
    if (!status) status = vw_check_print(&checked, options->json);
    free(rows);
    vw_check_free(&check);
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu);
    return status;
}

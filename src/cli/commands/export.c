#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "run/recorded/export_scene.h"

static enum vw_status print(const struct vw_options *options, const struct vw_export *exported) {
    if (options->json)
        return vw_json_print(json_pack("{s:s, s:s?, s:s?}", "method", exported->method, "cameras", options->cameras,
                                       "points", options->points));
    if (options->cameras)
        vw_print("%u cameras, coloured by rank of %s: %s\n", exported->camera_count, exported->method,
                 options->cameras);
    if (options->points) vw_print("%u points: %s\n", exported->point_count, options->points);
    return VW_OK;
}

enum vw_status vw_command_export(const struct vw_options *options) {
    const struct vw_export_params params = {
        .out = options->operand, .cameras = options->cameras, .points = options->points, .device = options->device};
    struct vw_export exported;
    enum vw_status status = vw_export_scene(&params, &exported);
    return status ? status : print(options, &exported);
}

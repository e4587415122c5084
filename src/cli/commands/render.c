#include "run/recorded/render.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"

static json_t *to_json(const struct vw_rendered_view *rendered) {
    return json_pack("{s:s, s:s, s:o, s:s}", "view", rendered->view, "split", vw_split_name(rendered->split), "psnr_db",
                     vw_json_real(rendered->psnr_db), "image", rendered->image_path);
}

static void print_text(const struct vw_rendered_view *rendered) {
    vw_print("%s  PSNR %.2f dB over the whole view%s\nphoto left, render right: %s\n", rendered->view,
             rendered->psnr_db,
             rendered->fitted ? ", without the gain and bias that validation fits: not comparable with val_psnr" : "",
             rendered->image_path);
}

static json_t *path_to_json(const struct vw_rendered_path *rendered) {
    return json_pack("{s:s, s:i, s:s?}", "to", rendered->to, "frames", (int)rendered->frame_count, "video",
                     rendered->video);
}

static enum vw_status render_path(const struct vw_options *options, const struct vw_render_params *params) {
    struct vw_rendered_path rendered = {0};
    enum vw_status status = vw_render_path(params, &rendered);
    if (!status && options->json) status = vw_json_print(path_to_json(&rendered));
    else if (!status && params->pose) vw_print("render: %s\n", rendered.to);
    else if (!status) vw_print("%u frames: %s/frame_0001.png ...\n", rendered.frame_count, rendered.to);
    if (!status && !options->json && rendered.video) vw_print("video: %s\n", rendered.video);
    vw_rendered_path_free(&rendered);
    return status;
}

enum vw_status vw_command_render(const struct vw_options *options) {
    const struct vw_render_params params = {.out = options->operand,
                                            .view = options->view,
                                            .to = options->to,
                                            .device = options->device,
                                            .depth = options->depth,
                                            .pose = options->pose,
                                            .path = options->path,
                                            .frames = options->frames,
                                            .video = options->video};
    struct vw_rendered_view rendered = {0};
    if (params.path || params.pose) return render_path(options, &params);
    enum vw_status status = vw_render_view(&params, &rendered);
    if (!status && options->json) status = vw_json_print(to_json(&rendered));
    else if (!status) print_text(&rendered);
    vw_rendered_view_free(&rendered);
    return status;
}

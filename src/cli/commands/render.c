#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "run/recorded/render_view.h"

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

enum vw_status vw_command_render(const struct vw_options *options) {
    const struct vw_render_params params = {
        .out = options->operand, .view = options->view, .to = options->to, .device = options->device};
    struct vw_rendered_view rendered = {0};
    enum vw_status status = vw_render_view(&params, &rendered);
    if (!status && options->json) status = vw_json_print(to_json(&rendered));
    else if (!status) print_text(&rendered);
    vw_rendered_view_free(&rendered);
    return status;
}

#include "run/recorded/render_path.h"

#include <stdlib.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "image/image.h"
#include "run/recorded/video.h"
#include "scene/camera_path.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static enum vw_status check_params(const struct vw_render_params *params) {
    if (params->pose && params->path) return vw_fail(VW_ERROR_USAGE, "--pose and --path: give one of them");
    if (params->only_render)
        return vw_fail(VW_ERROR_USAGE,
                       "--only-render: --pose and --path have no photo to leave out; give it with a view");
    enum vw_status status = vw_video_check(params->video);
    return !status && params->pose ? vw_render_check_image(params->to) : status;
}

static enum vw_status make_path(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                struct vw_camera_path *path) {
    const struct vw_scene *scene = rendering->run.scene;
    if (params->pose) return vw_camera_path_parse(scene, "--pose", params->pose, rendering->view, path);
    if (!vw_camera_path_is(params->path)) return vw_camera_path_read(scene, params->path, rendering->view, path);
    return vw_camera_path_make(scene, params->path, rendering->view, params->frames, path);
}

// Returns the name of a frame, owned by the caller; the first is 1.
static char *name_frame(const struct vw_render_params *params, const char *to, uint32_t number) {
    return params->pose ? vw_copy_text(to) : vw_format_text("%s/" VW_VIDEO_FRAME_NAME, to, number);
}

// Refuses a user's folder with frames of a longer path, which a video would go on with.
static enum vw_status check_folder(const struct vw_render_params *params, uint32_t frame_count) {
    char *next = name_frame(params, params->to, frame_count + 1);
    if (!next) return VW_ERROR_MEMORY;
    enum vw_status status =
        vw_file_exists(next)
            ? vw_fail(VW_ERROR_USAGE, "%s: is of a longer path; remove its frames, or name another folder by --to",
                      next)
            : VW_OK;
    free(next);
    return status ? status : vw_folder_create(params->to);
}

static enum vw_status prepare_target(const struct vw_render_params *params, uint32_t frame_count,
                                     struct vw_rendered_path *rendered) {
    rendered->to =
        params->to ? vw_copy_text(params->to) : vw_path_join(params->out, params->pose ? "render_pose.png" : "frames");
    if (!rendered->to) return VW_ERROR_MEMORY;
    if (params->pose) return VW_OK;
    return params->to ? check_folder(params, frame_count) : vw_folder_create_inside(params->out, "frames");
}

static enum vw_status render_frame(const struct vw_rendering *rendering, const struct vw_view *frame,
                                   const char *name) {
    float *rgb = NULL;
    if (!name) return VW_ERROR_MEMORY;
    enum vw_status status = vw_trainer_render_posed(rendering->trainer, rendering->view, frame, false, &rgb);
    if (!status) status = vw_image_save(name, frame->camera.width_px, frame->camera.height_px, 3, rgb);
    free(rgb);
    return status;
}

static void remove_depth(const char *frame) {
    char *depth = vw_render_name_depth(frame);
    if (depth) (void)unlink(depth);
    free(depth);
}

// Removes the frames of a longer path from OUT.
static enum vw_status remove_rest(const struct vw_render_params *params, const struct vw_rendered_path *rendered) {
    bool removed = !params->pose && !params->to;
    for (uint32_t number = rendered->frame_count + 1; removed; number++) {
        char *name = name_frame(params, rendered->to, number);
        if (!name) return VW_ERROR_MEMORY;
        removed = unlink(name) == 0;
        remove_depth(name);
        free(name);
    }
    return VW_OK;
}

static enum vw_status render_frames(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                    const struct vw_camera_path *path, struct vw_rendered_path *rendered) {
    enum vw_status status = prepare_target(params, path->count, rendered);
    if (!status && params->path) vw_log_info("rendering %u frames to %s", path->count, rendered->to);
    for (uint32_t f = 0; f < path->count && !status; f++) {
        char *name = name_frame(params, rendered->to, f + 1);
        status = render_frame(rendering, &path->frames[f], name);
        if (!status && params->depth) status = vw_rendering_write_depth(rendering, &path->frames[f], name);
        else if (!status && params->path) remove_depth(name);
        free(name);
    }
    rendered->frame_count = path->count;
    return status ? status : remove_rest(params, rendered);
}

enum vw_status vw_render_path(const struct vw_render_params *params, struct vw_rendered_path *rendered) {
    struct vw_rendering rendering = {0};
    struct vw_camera_path path = {0};
    struct vw_out_lock *lock = NULL;
    bool made = false;
    enum vw_status status = check_params(params);
    if (!status) status = vw_rendering_lock(params->out, params->to, &lock);
    if (!status && params->video && !lock) status = vw_rendering_lock(params->out, params->video, &lock);
    if (!status) status = vw_rendering_open(params, &rendering);
    if (!status) status = make_path(params, &rendering, &path);
    if (!status) status = render_frames(params, &rendering, &path, rendered);
    if (!status && params->video) status = vw_video_make(rendered->to, params->video, &made);
    if (made) rendered->video = params->video;
    vw_camera_path_free(&path);
    vw_rendering_close(&rendering);
    vw_out_lock_release(&lock);
    return status;
}

void vw_rendered_path_free(struct vw_rendered_path *rendered) {
    free(rendered->to);
    *rendered = (struct vw_rendered_path){0};
}

#include "run/next/proposal_files.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "image/image.h"
#include "image/webp_text.h"
#include "run/next/proposals_json.h"
#include "run/next/reasons.h"
#include "run/out_files.h"
#include "scene/camera_path.h"
#include "scene/formats/ply.h"
#include "scene/formats/transforms.h"
#include "train/trainer.h"

// Returns the path of a render, owned by the caller; NULL: memory is short.
static char *name_render(const char *out, uint32_t place) {
    return vw_format_text("%s/" VW_NEXT_RENDER_NAME, out, place + 1);
}

// ---- Renders -------------------------------------------------------------------------------------------------------

static enum vw_status add_picture(const struct vw_camera *camera, const float *rgb, json_t **pictures) {
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status =
        vw_image_encode_webp(camera->width_px, camera->height_px, "webp:70", rgb, &data, &size_bytes);
    char *text = status ? NULL : vw_webp_to_text(data, size_bytes);
    if (!status) vw_json_append(pictures, text ? json_string(text) : NULL);
    free(data);
    free(text);
    return status || *pictures ? status : VW_ERROR_MEMORY;
}

static enum vw_status render_proposal(const struct vw_proposal_files *files, uint32_t place, json_t **pictures) {
    struct vw_view pose = *files->next->proposals[place].pose;
    double factor = fmin(1, VW_NEXT_RENDER_SIDE_MOST_PX / fmax(pose.camera.width_px, pose.camera.height_px));
    pose.camera = vw_camera_resized(&pose.camera, (uint32_t)fmax(1, lround(factor * pose.camera.width_px)),
                                    (uint32_t)fmax(1, lround(factor * pose.camera.height_px)));
    float *rgb = NULL;
    char *path = name_render(files->out, place);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status =
        vw_trainer_render_posed(files->trainer, files->next->proposals[place].nearest_view, &pose, false, &rgb);
    if (!status) status = vw_image_save(path, pose.camera.width_px, pose.camera.height_px, 3, rgb);
    if (!status && place < VW_NEXT_PICTURES_MOST) status = add_picture(&pose.camera, rgb, pictures);
    free(rgb);
    free(path);
    return status;
}

// Removes next.json of an earlier call.
static enum vw_status remove_list(const char *list) {
    if (!unlink(list) || errno == ENOENT) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s: cannot remove: %s", list, strerror(errno));
}

// Removes the renders of an earlier call beyond those of this one.
static enum vw_status remove_rest(const struct vw_proposal_files *files) {
    bool removed = true;
    for (uint32_t place = files->next->proposal_count; removed; place++) {
        char *path = name_render(files->out, place);
        if (!path) return VW_ERROR_MEMORY;
        removed = !unlink(path);
        free(path);
    }
    return VW_OK;
}

// ---- Poses for other programs --------------------------------------------------------------------------------------

static json_t *frame_to_json(const struct vw_proposal_files *files, uint32_t place) {
    char render[32], reasons[128] = "";
    snprintf(render, sizeof render, VW_NEXT_RENDER_NAME, place + 1);
    json_t *frame = vw_transforms_frame_to_json(files->next->proposals[place].pose, render, NULL, true);
    vw_next_print_reasons(files->next->proposals[place].reasons, reasons, sizeof reasons);
    vw_json_set(&frame, "reason", json_string(reasons));
    return frame;
}

static enum vw_status write_transforms(const struct vw_proposal_files *files) {
    json_t *file = json_object(), *frames = json_array();
    for (uint32_t k = 0; k < files->next->proposal_count; k++) vw_json_append(&frames, frame_to_json(files, k));
    vw_json_set(&file, "camera_model", json_string("OPENCV"));
    vw_json_set(&file, "frames", frames);
    return vw_json_write_file(files->to, file);
}

static enum vw_status write_pyramids(const struct vw_proposal_files *files) {
    uint32_t count = files->next->proposal_count;
    struct vw_camera_pyramid *pyramids = vw_allocate(count, sizeof *pyramids);
    if (!pyramids) return VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < count; k++) {
        pyramids[k].view = files->next->proposals[k].pose;
        vw_rank_colour(count > 1 ? 1 - k / (double)(count - 1) : 1, pyramids[k].rgb);
    }
    const struct vw_camera_pyramids all = {pyramids, count, vw_camera_pyramid_depth(files->scene)};
    enum vw_status status = vw_csv_write_file(files->to, vw_ply_print_cameras, &all);
    free(pyramids);
    return status;
}

static enum vw_status write_poses(const struct vw_proposal_files *files) {
    if (!files->to) return VW_OK;
    return vw_path_ends_with(files->to, ".ply") ? write_pyramids(files) : write_transforms(files);
}

static enum vw_status write_list(const struct vw_proposal_files *files, const char *path, json_t *pictures) {
    json_t *list = vw_proposals_to_json(files->next);
    vw_json_set(&list, "pictures", pictures);
    return vw_json_write_file(path, list);
}

enum vw_status vw_proposal_files_write(const struct vw_proposal_files *files) {
    char *list = vw_path_join(files->out, VW_NEXT_FILE);
    json_t *pictures = json_array();
    enum vw_status status = list ? write_poses(files) : VW_ERROR_MEMORY;
    bool written = !status;
    if (!status) status = remove_list(list);
    for (uint32_t k = 0; k < files->next->proposal_count && !status; k++) status = render_proposal(files, k, &pictures);
    if (!status) status = remove_rest(files);
    if (!status) status = write_list(files, list, json_incref(pictures));
    if (status && written && files->to) unlink(files->to); // it names renders that are not there
    json_decref(pictures);
    free(list);
    return status;
}

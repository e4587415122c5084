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
#include "run/next/next_private.h"
#include "run/out_folder.h"
#include "scene/formats/ply.h"
#include "scene/formats/transforms.h"
#include "train/trainer.h"

enum { RENDER_SIDE_MOST_PX = 480 }; // a WebP file of noise, too, is then below VW_WEBP_TEXT_LIMIT_BYTES
enum { PICTURES_MOST = 20 };        // so that pages stay small

// ---- next.json -----------------------------------------------------------------------------------------------------

static json_t *proposal_to_json(const struct vw_proposal *proposal, uint32_t place) {
    const double(*pose)[4] = proposal->pose->camera_to_world;
    char render[32];
    snprintf(render, sizeof render, VW_NEXT_RENDER_NAME, place + 1);
    return json_pack("{s:o, s:[fff], s:[fff], s:o, s:o, s:s, s:f, s:o, s:o, s:o, s:s}", "name",
                     vw_json_string(proposal->pose->name), "position", pose[0][VW_POSE_POSITION],
                     pose[1][VW_POSE_POSITION], pose[2][VW_POSE_POSITION], "direction", -pose[0][VW_POSE_BACK],
                     -pose[1][VW_POSE_BACK], -pose[2][VW_POSE_BACK], "camera_to_world", vw_pose_to_json(pose), "gain",
                     vw_json_real(proposal->gain), "reason", proposal->reason, "seen_by", proposal->seen_by, "nearest",
                     vw_json_string(proposal->nearest), "distance", vw_json_real(proposal->apart), "move",
                     vw_json_string(proposal->move), "render", render);
}

json_t *vw_proposals_to_json(const struct vw_next *next) {
    json_t *proposals = json_array();
    for (uint32_t k = 0; k < next->proposal_count; k++)
        vw_json_append(&proposals, proposal_to_json(&next->proposals[k], k));
    return json_pack("{s:s, s:o}", "scene_hash", next->scene_hash, "proposals", proposals);
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

static enum vw_status render(const char *path, const struct vw_proposal *proposal, struct vw_trainer *trainer,
                             json_t **pictures) {
    struct vw_view pose = *proposal->pose;
    double factor = fmin(1, RENDER_SIDE_MOST_PX / fmax(pose.camera.width_px, pose.camera.height_px));
    pose.camera = vw_camera_resized(&pose.camera, (uint32_t)fmax(1, lround(factor * pose.camera.width_px)),
                                    (uint32_t)fmax(1, lround(factor * pose.camera.height_px)));
    float *rgb = NULL;
    enum vw_status status = vw_trainer_render_posed(trainer, proposal->nearest_view, &pose, false, &rgb);
    if (!status) status = vw_image_save(path, pose.camera.width_px, pose.camera.height_px, 3, rgb);
    if (!status && json_array_size(*pictures) < PICTURES_MOST) status = add_picture(&pose.camera, rgb, pictures);
    free(rgb);
    return status;
}

// Renders the proposals and removes the renders of an earlier call beyond them.
static enum vw_status write_renders(const char *out, const struct vw_next *next, struct vw_trainer *trainer,
                                    json_t **pictures) {
    enum vw_status status = VW_OK;
    bool more = true;
    for (uint32_t place = 0; more && !status; place++) {
        char *path = vw_format_text("%s/" VW_NEXT_RENDER_NAME, out, place + 1);
        if (!path) return VW_ERROR_MEMORY;
        if (place < next->proposal_count) status = render(path, &next->proposals[place], trainer, pictures);
        else more = !unlink(path);
        free(path);
    }
    return status;
}

// ---- Poses for other programs --------------------------------------------------------------------------------------

static enum vw_status write_transforms(const char *to, const struct vw_next *next) {
    json_t *frames = json_array();
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        char name[32];
        snprintf(name, sizeof name, VW_NEXT_RENDER_NAME, k + 1);
        json_t *frame = vw_transforms_frame_to_json(next->proposals[k].pose, name, NULL, true);
        vw_json_set(&frame, "reason", json_string(next->proposals[k].reason));
        vw_json_append(&frames, frame);
    }
    return vw_json_write_file(to, json_pack("{s:s, s:o}", "camera_model", "OPENCV", "frames", frames));
}

static enum vw_status write_pyramids(const char *to, const struct vw_next *next, const struct vw_scene *scene) {
    uint32_t count = next->proposal_count;
    struct vw_camera_pyramid *pyramids = vw_allocate(count, sizeof *pyramids);
    if (!pyramids) return VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < count; k++) {
        pyramids[k].view = next->proposals[k].pose;
        vw_rank_colour(count > 1 ? 1 - k / (double)(count - 1) : 1, pyramids[k].rgb);
    }
    const struct vw_camera_pyramids all = {pyramids, count, vw_camera_pyramid_depth(scene)};
    enum vw_status status = vw_csv_write_file(to, vw_ply_print_cameras, &all);
    free(pyramids);
    return status;
}

// ---- All of them ---------------------------------------------------------------------------------------------------

// Replaces what an earlier call left in OUT. next.json goes first and comes last, so that a killed call leaves none
// that is of other renders.
static enum vw_status replace(const char *list, const struct vw_next_params *params, const struct vw_next *next,
                              struct vw_trainer *trainer) {
    if (unlink(list) && errno != ENOENT) return vw_fail(VW_ERROR_IO, "%s: cannot remove: %s", list, strerror(errno));
    json_t *pictures = json_array(), *file;
    enum vw_status status = write_renders(params->out, next, trainer, &pictures);
    if (status) {
        json_decref(pictures);
        return status;
    }
    file = vw_proposals_to_json(next);
    vw_json_set(&file, "pictures", pictures);
    return vw_json_write_file(list, file);
}

enum vw_status vw_next_write(const struct vw_next_params *params, const struct vw_next *next,
                             const struct vw_scene *scene, struct vw_trainer *trainer) {
    char *list = vw_path_join(params->out, VW_NEXT_FILE);
    enum vw_status status = list ? VW_OK : VW_ERROR_MEMORY;
    if (!status && params->to)
        status = vw_path_ends_with(params->to, ".ply") ? write_pyramids(params->to, next, scene)
                                                       : write_transforms(params->to, next);
    bool written = !status && params->to;
    if (!status) status = replace(list, params, next, trainer);
    if (status && written) unlink(params->to); // it names renders that are not there
    free(list);
    return status;
}

#include "run/next/proposals_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "image/webp_text.h"
#include "run/next/reasons.h"
#include "scene/builder.h"
#include "scene/camera_path.h"
#include "scene/formats/transforms.h"

// ---- Writing -------------------------------------------------------------------------------------------------------

static json_t *reasons_to_json(uint32_t reasons) {
    json_t *words = json_array();
    for (uint32_t i = 0; i < VW_NEXT_REASON_COUNT; i++)
        if (reasons >> i & 1) vw_json_append(&words, json_string(vw_next_reason_word(i)));
    return words;
}

static json_t *proposal_to_json(const struct vw_next *next, uint32_t place) {
    const struct vw_proposal *proposal = &next->proposals[place];
    const struct vw_view *view = proposal->pose;
    const double(*pose)[4] = view->camera_to_world;
    char render[32];
    snprintf(render, sizeof render, VW_NEXT_RENDER_NAME, place + 1);
    return json_pack("{s:o, s:[fff], s:[fff], s:o, s:o, s:o, s:f, s:o, s:o, s:o, s:s}", "name",
                     vw_json_string(view->name), "position", pose[0][VW_POSE_POSITION], pose[1][VW_POSE_POSITION],
                     pose[2][VW_POSE_POSITION], "direction", -pose[0][VW_POSE_BACK], -pose[1][VW_POSE_BACK],
                     -pose[2][VW_POSE_BACK], "camera_to_world", vw_pose_to_json(pose), "gain",
                     vw_json_real(proposal->gain), "reasons", reasons_to_json(proposal->reasons), "seen_by",
                     proposal->seen_by, "nearest", vw_json_string(proposal->nearest), "distance",
                     vw_json_real(proposal->apart), "move", vw_json_string(proposal->move), "render", render);
}

json_t *vw_proposals_to_json(const struct vw_next *next) {
    json_t *root = json_object(), *proposals = json_array();
    for (uint32_t k = 0; k < next->proposal_count; k++) vw_json_append(&proposals, proposal_to_json(next, k));
    vw_json_set(&root, "scene_hash", json_string(next->scene_hash));
    vw_json_set(&root, "proposals", proposals);
    return root;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static const double DIRECTION_MOST = 1.1; // a unit vector, rounded

static bool is_vector(const json_t *array, double most) {
    bool fits = json_array_size(array) == 3;
    for (size_t i = 0; fits && i < 3; i++) {
        const json_t *number = json_array_get(array, i);
        fits = json_is_number(number) && fabs(json_number_value(number)) <= most;
    }
    return fits;
}

static bool are_reasons(const json_t *array) {
    bool fits = json_is_array(array) && json_array_size(array) <= VW_NEXT_REASON_COUNT;
    for (size_t i = 0; fits && i < json_array_size(array); i++)
        fits = vw_next_reason_is_known(json_string_value(json_array_get(array, i)));
    return fits;
}

static bool are_pictures(const json_t *array, size_t proposal_count) {
    size_t most = proposal_count < VW_NEXT_PICTURES_MOST ? proposal_count : VW_NEXT_PICTURES_MOST;
    bool fits = !array || (json_is_array(array) && json_array_size(array) <= most);
    for (size_t i = 0; fits && i < json_array_size(array); i++)
        fits = vw_is_webp_text(json_string_value(json_array_get(array, i)));
    return fits;
}

// Returns the field of a proposal that is not what a page needs; NULL: all are.
static const char *find_broken(const json_t *proposal) {
    if (!is_vector(json_object_get(proposal, "position"), VW_POSITION_MOST_WORLD)) return "position";
    if (!is_vector(json_object_get(proposal, "direction"), DIRECTION_MOST)) return "direction";
    if (!are_reasons(json_object_get(proposal, "reasons"))) return "reasons";
    if (!json_is_number(json_object_get(proposal, "seen_by"))) return "seen_by";
    if (!json_is_string(json_object_get(proposal, "nearest"))) return "nearest";
    if (!json_is_string(json_object_get(proposal, "move"))) return "move";
    return json_is_number(json_object_get(proposal, "distance")) ? NULL : "distance";
}

enum vw_status vw_proposals_check(const char *path, json_t *file, const char *scene_hash, uint32_t image_count) {
    static const char remedy[] = "remove it, or propose again by viewworth next";
    const char *hash = json_string_value(json_object_get(file, "scene_hash"));
    const json_t *proposals = json_object_get(file, "proposals");
    (void)image_count; // a proposal is of no photo
    if (!hash || strcmp(hash, scene_hash) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: is of another scene than the ledger; %s", path, remedy);
    if (!json_is_array(proposals) || json_array_size(proposals) > VW_CAMERA_PATH_FRAMES_MOST)
        return vw_fail(VW_ERROR_INPUT, "%s: proposals: is not a list of proposals; %s", path, remedy);
    if (!are_pictures(json_object_get(file, "pictures"), json_array_size(proposals)))
        return vw_fail(VW_ERROR_INPUT, "%s: pictures: is not what a page needs; %s", path, remedy);
    for (size_t i = 0; i < json_array_size(proposals); i++) {
        const char *broken = find_broken(json_array_get(proposals, i));
        if (broken)
            return vw_fail(VW_ERROR_INPUT, "%s: proposal %zu: %s: is not what a page needs; %s", path, i + 1, broken,
                           remedy);
    }
    return VW_OK;
}

enum vw_status vw_proposals_drop_pictures(char **text) {
    json_error_t error;
    json_t *file = vw_json_load(*text, strlen(*text), 0, &error);
    json_object_del(file, "pictures");
    free(*text);
    *text = vw_json_to_text(file, JSON_COMPACT);
    json_decref(file);
    return *text ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for next.json");
}

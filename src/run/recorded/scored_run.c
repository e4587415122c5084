#include "run/recorded/scored_run.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "ledger/find_image.h"
#include "run/imported/imported_run.h"
#include "run/out_folder.h"
#include "run/session.h"
#include "scene/formats/scene_copy.h"
#include "viewworth/log.h"

enum vw_status vw_scored_run_open(const char *out, struct vw_scored_run *run) {
    struct vw_recorded_run *recorded = &run->recorded;
    json_error_t error;
    *run = (struct vw_scored_run){0};
    enum vw_status status = vw_recorded_open_unverified(out, recorded);
    if (!status) status = vw_recorded_check_scores(recorded);
    if (!status) status = vw_recorded_warn_unverified(recorded, false);
    if (!status) status = vw_ledger_get_images(recorded->ledger, &run->images, &run->image_count);
    if (status) return status;
    run->scene_options =
        vw_json_load(recorded->row.scene_options_json, strlen(recorded->row.scene_options_json), 0, &error);
    if (json_is_object(run->scene_options)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: run.scene_options_json: %s", recorded->ledger_path,
                   recorded->row.scene_options_json);
}

void vw_scored_run_warn(const struct vw_scored_run *run, uint32_t corrupt) {
    const struct vw_recorded_run *recorded = &run->recorded;
    json_int_t corrupted = json_integer_value(json_object_get(run->scene_options, "corrupt"));
    if (strcmp(recorded->row.status, "finished") != 0)
        vw_log_warning("%s: the run is %s, not finished; its scores may still change", recorded->ledger_path,
                       recorded->row.status);
    if (corrupted != corrupt)
        vw_log_warning("%s: the run corrupted %" JSON_INTEGER_FORMAT " photos (--corrupt), and %" PRIu32
                       " are to be corrupted now: its scores are of other photos",
                       recorded->ledger_path, corrupted, corrupt);
}

enum vw_status vw_scored_run_select(const struct vw_scored_run *run, const struct vw_selection_params *params,
                                    struct vw_selection *selection) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    enum vw_status status = vw_ledger_get_scores(run->recorded.ledger, &scores, &score_count);
    if (!status) status = vw_selection_make(scores, score_count, run->images, run->image_count, params, selection);
    if (status) vw_fail_context(status, "%s", run->recorded.ledger_path);
    free(scores);
    return status;
}

void vw_scored_run_close(struct vw_scored_run *run) {
    json_decref(run->scene_options);
    vw_recorded_close(&run->recorded);
}

// ---- The list -------------------------------------------------------------------------------------------------------

static enum vw_split split_of(const char *name) {
    enum vw_split split = VW_SPLIT_TRAIN;
    while (split < VW_SPLIT_EXCLUDED && strcmp(name, vw_split_name(split)) != 0) split++;
    return split;
}

// Lists all images of the run, owned by the caller; NULL if memory is short.
static struct vw_listed_photo *list_photos(const struct vw_scored_run *run, const struct vw_selection *selection) {
    struct vw_listed_photo *photos = vw_allocate(run->image_count, sizeof *photos);
    for (uint32_t i = 0; photos && i < run->image_count; i++)
        photos[i] =
            (struct vw_listed_photo){run->images[i].name, split_of(run->images[i].split), false, run->images[i].sha256};
    for (uint32_t i = 0; photos && selection && i < selection->count; i++) {
        const struct vw_ledger_image *image =
            vw_ledger_find_image(run->images, run->image_count, selection->image_ids[i]);
        photos[image - run->images].chosen = true;
    }
    return photos;
}

uint32_t vw_scored_run_train_count(const struct vw_scored_run *run) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < run->image_count; i++) count += split_of(run->images[i].split) == VW_SPLIT_TRAIN;
    return count;
}

enum vw_status vw_selection_list_write(const struct vw_scored_run *run, const struct vw_selection *selection,
                                       const char *to) {
    struct vw_listed_photo *photos = list_photos(run, selection);
    if (!photos) return VW_ERROR_MEMORY;
    const struct vw_photo_list list = {
        .scene_path = vw_is_imported(&run->recorded.row) ? NULL : run->recorded.row.scene_path,
        .photos = photos,
        .photo_count = run->image_count,
        .to = to,
        .check_only = !selection,
    };
    enum vw_status status = vw_photo_list_write(&list);
    free(photos);
    return status;
}

// ---- The copy -------------------------------------------------------------------------------------------------------

// Opens the scene for its files and cameras: as the run did, but with photos of full size.
static enum vw_status open_scene(const struct vw_scored_run *run, const char *to, struct vw_scene **scene) {
    struct vw_scene_params params;
    json_t *texts = NULL;
    if (vw_is_imported(&run->recorded.row))
        return vw_fail(VW_ERROR_USAGE, "--copy %s: %s was imported and has no scene; use --to", to,
                       run->recorded.ledger_path);
    enum vw_status status = vw_scene_options_from_json(run->recorded.row.scene_options_json, &texts, &params);
    if (status) return status;
    params.path = run->recorded.row.scene_path;
    bool whole = !params.corrupt && vw_file_exists_inside(run->recorded.out, VW_CHECKSUMS_FILE);
    params.downscale = params.corrupt = 0;
    params.val_weights = params.providers = NULL;
    params.headers_only = true;
    char *found = vw_path_join(run->recorded.out, VW_OUT_MASKS);
    if (found && vw_folder_exists(found) && whole) params.masks = found; // given ones are among them
    status = vw_scene_open(&params, scene);
    free(found);
    json_decref(texts);
    return status;
}

enum vw_status vw_selection_copy_check(const struct vw_scored_run *run, const char *to) {
    struct vw_scene *scene = NULL;
    enum vw_status status = open_scene(run, to, &scene);
    if (!status) status = vw_scene_copy_check(to, scene);
    vw_scene_close(&scene);
    return status;
}

enum vw_status vw_selection_copy(const struct vw_scored_run *run, const struct vw_selection *selection, const char *to,
                                 const struct vw_interrupt *interrupt) {
    struct vw_scene *scene = NULL;
    struct vw_listed_photo *photos = list_photos(run, selection);
    enum vw_status status = photos ? open_scene(run, to, &scene) : VW_ERROR_MEMORY;
    const struct vw_photo_list list = {
        .scene_path = run->recorded.row.scene_path, .photos = photos, .photo_count = run->image_count, .to = to};
    if (!status) status = vw_scene_copy(&list, scene, interrupt);
    vw_scene_close(&scene);
    free(photos);
    return status;
}

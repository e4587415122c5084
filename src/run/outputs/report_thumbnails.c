#include "run/outputs/report_thumbnails.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "viewworth/log.h"

// ---- Once per scene ------------------------------------------------------------------------------------------------

static enum vw_status make(const struct vw_report_params *params, const struct vw_recorded_scene *recorded,
                           struct vw_thumbnails *thumbnails) {
    char hash[VW_HASH_HEX_BYTES] = "";
    if (params->scene) vw_hash_to_hex(params->scene->hash, hash);
    if (strcmp(hash, recorded->hash) == 0) return vw_thumbnails_make(params->scene, thumbnails);
    if (!recorded->path) return vw_fail(VW_ERROR_INPUT, "%s: was imported and has no photos", recorded->out);
    return vw_thumbnails_make_again(recorded, params->device, thumbnails);
}

// Finds or makes a scene's thumbnails. Reading or rendering photos takes long, so a scene that failed is not tried
// again. Returns none when memory is short.
static struct vw_thumbnails set_of(struct vw_report_sets *sets, const struct vw_report_params *params,
                                   const struct vw_recorded_scene *recorded) {
    for (size_t i = 0; i < sets->count; i++)
        if (strcmp(sets->sets[i].hash, recorded->hash) == 0) return sets->sets[i].thumbnails;
    enum vw_status status = vw_grow((void **)&sets->sets, &sets->capacity, sets->count + 1, sizeof *sets->sets);
    struct vw_report_set *set = status ? NULL : &sets->sets[sets->count++];
    if (set) strncpy(set->hash, recorded->hash, sizeof set->hash - 1);
    if (set) status = make(params, recorded, &set->thumbnails);
    if (status) vw_log_warning("the report goes without thumbnails: %s", vw_error_message());
    static const struct vw_thumbnails none;
    return status || !set ? none : set->thumbnails;
}

void vw_report_sets_free(struct vw_report_sets *sets) {
    for (size_t i = 0; i < sets->count; i++) vw_thumbnails_free(&sets->sets[i].thumbnails);
    free(sets->sets);
    *sets = (struct vw_report_sets){0};
}

// ---- Of a run ------------------------------------------------------------------------------------------------------

// Compares the names, since a ledger may come from anywhere and its scene hash says nothing about its images.
static bool shows_images(const struct vw_thumbnails *thumbnails, const struct vw_ledger_image *images,
                         uint32_t image_count) {
    bool same = thumbnails->count == image_count;
    for (uint32_t i = 0; i < image_count && same; i++) same = strcmp(thumbnails->names[i], images[i].name) == 0;
    return same;
}

const struct vw_report_picture *vw_report_sets_of_run(struct vw_report_sets *sets,
                                                      const struct vw_report_params *params,
                                                      const struct vw_recorded_scene *recorded,
                                                      const struct vw_ledger_image *images, uint32_t image_count) {
    if (params->options.no_thumbnails) return NULL;
    const struct vw_thumbnails thumbnails = set_of(sets, params, recorded);
    if (!thumbnails.count) return NULL;
    if (shows_images(&thumbnails, images, image_count)) return thumbnails.pictures;
    vw_log_warning(
        "the report goes without thumbnails: %s: its ledger names other photos than its scene has; verify it",
        recorded->out);
    return NULL;
}

// ---- Of a comparison -----------------------------------------------------------------------------------------------

static bool is_shown(const struct vw_report_run *runs, size_t run_count, const char *hash) {
    for (size_t i = 0; i < run_count; i++)
        if (runs[i].thumbnails && strcmp(runs[i].row->scene_hash, hash) == 0) return true;
    return false;
}

static void lend(const struct vw_thumbnails *thumbnails, const char *name, struct vw_report_document *document) {
    for (uint32_t i = 0; i < thumbnails->count; i++) {
        if (strcmp(thumbnails->names[i], name) != 0) continue;
        ((const char **)document->thumbnail_names)[document->thumbnail_count] = thumbnails->names[i];
        ((struct vw_report_picture *)document->thumbnails)[document->thumbnail_count++] = thumbnails->pictures[i];
        return;
    }
}

static enum vw_status lend_all(const struct vw_thumbnails *thumbnails, const json_t *disagreements,
                               struct vw_report_document *document) {
    size_t count = json_array_size(disagreements);
    document->thumbnail_names = vw_allocate(count, sizeof *document->thumbnail_names);
    document->thumbnails = vw_allocate(count, sizeof *document->thumbnails);
    if (!document->thumbnail_names || !document->thumbnails) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++)
        lend(thumbnails, json_string_value(json_object_get(json_array_get(disagreements, i), "photo")), document);
    return VW_OK;
}

// Reads path and divisor from compare.json; a scene that was split by further options has another hash.
enum vw_status vw_report_sets_of_comparison(struct vw_report_sets *sets, const struct vw_report_params *params,
                                            const struct vw_report_run *runs, size_t run_count,
                                            struct vw_report_document *document) {
    const char *path, *hash;
    int downscale;
    json_t *compare = vw_json_load(document->json, strlen(document->json), 0, NULL), *disagreements;
    enum vw_status status = VW_OK;
    if (json_unpack(compare, "{s:s, s:s, s:i, s:o}", "scene", &path, "scene_hash", &hash, "downscale", &downscale,
                    "disagreements", &disagreements))
        status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory for compare.json", document->label);
    else if (!params->options.no_thumbnails && json_array_size(disagreements) && !is_shown(runs, run_count, hash)) {
        char *scene_options = vw_format_text("{\"downscale\":%d}", downscale);
        const struct vw_recorded_scene recorded = {document->label, path, scene_options, hash};
        struct vw_thumbnails thumbnails = {0};
        if (scene_options) thumbnails = set_of(sets, params, &recorded);
        status = scene_options ? lend_all(&thumbnails, disagreements, document) : VW_ERROR_MEMORY;
        free(scene_options);
    }
    json_decref(compare);
    return status;
}

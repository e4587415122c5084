#include "run/outputs/thumbnails.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "image/image.h"
#include "run/imported/imported_run.h"
#include "run/session.h"
#include "viewworth/log.h"

// A scene as a folder recorded it. All is borrowed.
struct recorded_scene {
    const char *out;                        // the folder
    const char *path, *options_json, *hash; // as vw_reopen_scene() takes them, and its hash in hex
};

enum { THUMBNAIL_HEIGHT_PX = 96, LARGE_HEIGHT_PX = 240, LARGE_AT_MOST = 200 }; // larger where a page can hold them

static enum vw_status make_one(const struct vw_scene *scene, uint32_t view, struct vw_thumbnails *made) {
    const struct vw_image *image = &scene->views[view].image;
    struct vw_report_picture *picture = &made->pictures[view];
    made->names[view] = vw_copy_text(scene->views[view].name);
    if (!made->names[view]) return VW_ERROR_MEMORY;
    if (scene->views[view].split == VW_SPLIT_EXCLUDED || !image->pixels) return VW_OK;
    return vw_image_make_thumbnail(image, scene->view_count > LARGE_AT_MOST ? THUMBNAIL_HEIGHT_PX : LARGE_HEIGHT_PX,
                                   scene->background, &picture->data, &picture->size_bytes);
}

double vw_thumbnails_estimate_s(const struct vw_scene *scene) {
    double started_s = 0;
    uint32_t made = 0;
    for (uint32_t v = 0; v < scene->view_count && made < 2; v++) { // the first also loads the library
        const struct vw_image *image = &scene->views[v].image;
        void *data = NULL;
        size_t size_bytes = 0;
        if (scene->views[v].split == VW_SPLIT_EXCLUDED || vw_scene_decode(scene, &v, 1) || !image->pixels) continue;
        started_s = vw_now_s();
        (void)vw_image_make_thumbnail(image, THUMBNAIL_HEIGHT_PX, scene->background, &data,
                                      &size_bytes); // that fails again, in its place
        free(data);
        made++;
    }
    return made ? (vw_now_s() - started_s) * scene->view_count : 0;
}

static void free_thumbnails(struct vw_thumbnails *thumbnails) {
    for (uint32_t i = 0; i < thumbnails->count; i++) {
        free(thumbnails->names[i]);
        free(thumbnails->pictures[i].data);
    }
    free(thumbnails->names);
    free(thumbnails->pictures);
    *thumbnails = (struct vw_thumbnails){0};
}

static enum vw_status make_all(const struct vw_scene *scene, struct vw_thumbnails *thumbnails) {
    struct vw_thumbnails made = {.names = vw_allocate(scene->view_count, sizeof *made.names),
                                 .pictures = vw_allocate(scene->view_count, sizeof *made.pictures)};
    enum vw_status status = made.names && made.pictures ? VW_OK : VW_ERROR_MEMORY;
    if (!status) made.count = scene->view_count;
    if (!status) status = vw_scene_decode_all(scene);
    for (uint32_t i = 0; i < made.count && !status; i++) status = make_one(scene, i, &made);
    if (status) free_thumbnails(&made);
    else *thumbnails = made;
    return status;
}

// Opens the scene again; only recipes, which are files, may need a device.
static enum vw_status reopen(const struct recorded_scene *recorded, const char *device, struct vw_gpu **gpu,
                             struct vw_scene **scene) {
    if (!vw_reopen_scene(recorded->path, recorded->options_json, NULL, scene)) return VW_OK;
    if (!vw_file_exists(recorded->path)) return vw_fail_context(VW_ERROR_INPUT, "%s", recorded->out);
    enum vw_status status = vw_open_gpu(device, false, gpu);
    return status ? status : vw_reopen_scene(recorded->path, recorded->options_json, *gpu, scene);
}

// Makes the thumbnails of a recorded scene, which is opened for it; recipes need `device`.
static enum vw_status make_again(const struct recorded_scene *recorded, const char *device,
                                 struct vw_thumbnails *thumbnails) {
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    char hash[VW_HASH_HEX_BYTES];
    enum vw_status status = reopen(recorded, device, &gpu, &scene);
    if (!status) vw_hash_to_hex(scene->hash, hash);
    if (!status && strcmp(hash, recorded->hash) != 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that %s was made of", recorded->path, recorded->out);
    if (!status) status = make_all(scene, thumbnails);
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu); // reports only what validation layers said, which are off here
    return status;
}

// ---- Once per scene ------------------------------------------------------------------------------------------------

static enum vw_status make_set(const struct vw_report_params *params, const struct recorded_scene *recorded,
                               struct vw_thumbnails *thumbnails) {
    char hash[VW_HASH_HEX_BYTES] = "";
    if (params->scene) vw_hash_to_hex(params->scene->hash, hash);
    if (strcmp(hash, recorded->hash) == 0) return make_all(params->scene, thumbnails);
    if (!recorded->path) return vw_fail(VW_ERROR_INPUT, "%s: was imported and has no photos", recorded->out);
    return make_again(recorded, params->device, thumbnails);
}

// Finds or makes a scene's thumbnails. Reading or rendering photos takes long, so a scene that failed is not tried
// again. Returns none when memory is short.
static struct vw_thumbnails set_of(struct vw_report_sets *sets, const struct vw_report_params *params,
                                   const struct recorded_scene *recorded) {
    for (size_t i = 0; i < sets->count; i++)
        if (strcmp(sets->sets[i].hash, recorded->hash) == 0) return sets->sets[i].thumbnails;
    enum vw_status status = vw_grow((void **)&sets->sets, &sets->capacity, sets->count + 1, sizeof *sets->sets);
    struct vw_report_set *set = status ? NULL : &sets->sets[sets->count++];
    if (set) strncpy(set->hash, recorded->hash, sizeof set->hash - 1);
    if (set) status = make_set(params, recorded, &set->thumbnails);
    if (status) vw_log_warning("the report goes without thumbnails: %s", vw_error_message());
    static const struct vw_thumbnails none;
    return status || !set ? none : set->thumbnails;
}

void vw_report_sets_free(struct vw_report_sets *sets) {
    for (size_t i = 0; i < sets->count; i++) free_thumbnails(&sets->sets[i].thumbnails);
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

void vw_report_sets_of_run(struct vw_report_sets *sets, const struct vw_report_params *params, struct vw_results *run) {
    const struct recorded_scene recorded = {run->label, vw_is_imported(&run->row) ? NULL : run->row.scene_path,
                                            run->row.scene_options_json, run->row.scene_hash};
    if (params->options.no_thumbnails) return;
    const struct vw_thumbnails thumbnails = set_of(sets, params, &recorded);
    if (!thumbnails.count) return;
    if (shows_images(&thumbnails, run->input.images, run->input.image_count)) run->thumbnails = thumbnails.pictures;
    else
        vw_log_warning(
            "the report goes without thumbnails: %s: its ledger names other photos than its scene has; verify it",
            run->label);
}

// ---- Of a comparison -----------------------------------------------------------------------------------------------

static bool is_shown(const struct vw_results *const *runs, size_t run_count, const char *hash) {
    for (size_t i = 0; i < run_count; i++)
        if (runs[i]->thumbnails && strcmp(runs[i]->row.scene_hash, hash) == 0) return true;
    return false;
}

static void lend(const struct vw_thumbnails *thumbnails, const char *name, struct vw_report_document *document) {
    for (uint32_t i = 0; name && i < thumbnails->count; i++) {
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
                                            const struct vw_results *const *runs, size_t run_count,
                                            struct vw_report_document *document) {
    const char *path, *hash;
    int downscale;
    json_t *disagreements;
    enum vw_status status = VW_OK;
    if (json_unpack(document->content, "{s:s, s:s, s:i, s:o}", "scene", &path, "scene_hash", &hash, "downscale",
                    &downscale, "disagreements", &disagreements))
        status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory for compare.json", document->label);
    else if (!params->options.no_thumbnails && json_array_size(disagreements) && !is_shown(runs, run_count, hash)) {
        char *scene_options = vw_format_text("{\"downscale\":%d}", downscale);
        const struct recorded_scene recorded = {document->label, path, scene_options, hash};
        struct vw_thumbnails thumbnails = {0};
        if (scene_options) thumbnails = set_of(sets, params, &recorded);
        status = scene_options ? lend_all(&thumbnails, disagreements, document) : VW_ERROR_MEMORY;
        free(scene_options);
    }
    return status;
}

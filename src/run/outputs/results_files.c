#include "run/outputs/results_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "report/advice.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/residuals.h"

enum { LIMIT_BYTES = 16 << 20 };

// ---- The map -------------------------------------------------------------------------------------------------------

static json_t *real(double value) { return vw_json_rounded(value, VW_SCENE_MAP_DIGITS); }

static void append_column(json_t **array, const struct vw_view *view, int column, double factor) {
    for (int row = 0; row < 3; row++) vw_json_append(array, real(factor * view->camera_to_world[row][column]));
}

static json_t *up_of(const struct vw_scene *scene) {
    double sum[3] = {0}, squares = 0;
    json_t *up = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int row = 0; row < 3; row++) sum[row] += scene->views[v].camera_to_world[row][1];
    for (int row = 0; row < 3; row++) squares += sum[row] * sum[row];
    for (int row = 0; row < 3; row++) vw_json_append(&up, real(squares > 0 ? sum[row] / sqrt(squares) : row == 2));
    return up;
}

static json_t *points_of(const struct vw_scene *scene) {
    json_t *points = json_array();
    uint64_t count = scene->point_count < VW_SCENE_MAP_POINTS_MAX ? scene->point_count : VW_SCENE_MAP_POINTS_MAX;
    for (uint64_t i = 0; i < count; i++) {
        const struct vw_point *point = &scene->points[i * scene->point_count / count];
        for (int axis = 0; axis < 3; axis++) vw_json_append(&points, real(point->position_world[axis]));
    }
    return points;
}

static json_t *defects_to_json(const struct vw_photo_finding *findings, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t v = 0; v < count; v++)
        vw_json_append(&array, findings[v].word ? json_pack("{s:s, s:o}", "defect", findings[v].word, "description",
                                                            vw_json_string(findings[v].description))
                                                : json_null());
    return array;
}

json_t *vw_scene_map_make(const struct vw_scene *scene, const struct vw_photo_finding *findings) {
    json_t *map = json_object(), *positions = json_array(), *directions = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++) {
        append_column(&positions, &scene->views[v], 3, 1);
        append_column(&directions, &scene->views[v], 2, -1); // cameras look along -z
    }
    vw_json_set(&map, "scene_hash", vw_scene_hash_to_json(scene));
    vw_json_set(&map, "up", up_of(scene));
    vw_json_set(&map, "positions", positions);
    vw_json_set(&map, "directions", directions);
    vw_json_set(&map, "points", points_of(scene));
    vw_json_set(&map, "defects", defects_to_json(findings, scene->view_count));
    return map;
}

// ---- Writing -------------------------------------------------------------------------------------------------------

// Writes a value with so many digits; 0: all that its numbers have.
static enum vw_status write_json(const char *out, const char *name, const json_t *value, unsigned digits) {
    char *text = vw_json_to_text(value, JSON_COMPACT | JSON_REAL_PRECISION(digits));
    enum vw_status status = text ? vw_result_write(out, name, text, strlen(text))
                                 : vw_fail(VW_ERROR_MEMORY, "%s: out of memory for %s", out, name);
    free(text);
    return status;
}

enum vw_status vw_results_write_files(const struct vw_results *results, const struct vw_scene *scene, const char *out) {
    json_t *reconstruction = vw_reconstruction_to_json(&results->reconstruction);
    vw_json_set(&reconstruction, "scene_hash", vw_scene_hash_to_json(scene));
    enum vw_status status = write_json(out, VW_RECONSTRUCTION_FILE, reconstruction, 0);
    json_decref(reconstruction);
    if (!status) status = write_json(out, VW_SCENE_MAP_FILE, results->map, VW_SCENE_MAP_DIGITS);
    if (status || !results->residuals) return status;
    return write_json(out, VW_RESIDUALS_FILE, results->residuals, VW_RESIDUALS_DIGITS);
}

// ---- Reading -------------------------------------------------------------------------------------------------------

// Reads a file, if it is there, and refuses one of another scene or without an array that the page needs. SHA256SUMS
// tells whether it was changed; the page takes what is in the arrays for data. The caller drops the reference, also
// after a failure.
static enum vw_status read_json(const char *out, const char *name, const struct vw_results *results,
                                const char *const *arrays, size_t array_count, json_t **value) {
    static const char remedy[] = "remove it, or value the photos again";
    json_error_t error;
    void *text = NULL;
    size_t size_bytes = 0;
    if (!vw_file_exists_inside(out, name)) return vw_file_check_inside(out, name);
    enum vw_status status = vw_file_read_inside(out, name, LIMIT_BYTES, &text, &size_bytes);
    if (!status && !(*value = vw_json_load(text, size_bytes, 0, &error)))
        status = vw_fail(VW_ERROR_INPUT, "%s/%s: line %d: %s", out, name, error.line, error.text);
    free(text);
    if (status) return status;
    const char *hash = json_string_value(json_object_get(*value, "scene_hash"));
    if (!hash || strcmp(hash, results->row.scene_hash) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s/%s: is of another scene than the ledger; %s", out, name, remedy);
    for (size_t i = 0; i < array_count; i++)
        if (!json_is_array(json_object_get(*value, arrays[i])))
            return vw_fail(VW_ERROR_INPUT, "%s/%s: %s: is not an array; %s", out, name, arrays[i], remedy);
    return VW_OK;
}

static enum vw_status read_reconstruction(const char *out, struct vw_results *results) {
    json_t *json = NULL;
    struct vw_reconstruction *read = &results->reconstruction;
    enum vw_status status = read_json(out, VW_RECONSTRUCTION_FILE, results, NULL, 0, &json);
    const char *broken = json && !status ? vw_reconstruction_from_json(json, read) : NULL;
    if (broken)
        status = vw_fail(VW_ERROR_INPUT,
                         "%s/" VW_RECONSTRUCTION_FILE ": %s: is not what a run writes; remove it, or value "
                         "the photos again",
                         out, broken);
    if (!json || status) *read = vw_reconstruction_unknown;
    json_decref(json);
    return status;
}

// Reads the defects of photos from the map: kinds that are known.
static enum vw_status read_defects(struct vw_results *results) {
    const json_t *defects = json_object_get(results->map, "defects");
    results->findings = vw_allocate(results->input.image_count, sizeof *results->findings);
    for (uint32_t i = 0; results->findings && i < results->input.image_count; i++) {
        const json_t *defect = json_array_get(defects, i);
        const char *text = json_string_value(json_object_get(defect, "description"));
        struct vw_photo_finding *finding = &results->findings[i];
        *finding = vw_photo_finding_unknown;
        finding->word = text ? vw_defect_find_word(json_string_value(json_object_get(defect, "defect"))) : NULL;
        if (finding->word) snprintf(finding->description, sizeof finding->description, "%s", text);
        vw_text_make_line(finding->description);
    }
    return results->findings ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_results_read_next(const char *out, bool no_photos, struct vw_results *results) {
    static const char *const arrays[] = {"proposals"};
    enum vw_status status = read_json(out, VW_NEXT_FILE, results, arrays, VW_ARRAY_COUNT(arrays), &results->next);
    if (no_photos) json_object_del(results->next, "pictures");
    return status;
}

enum vw_status vw_results_read_files(const char *out, bool no_photos, struct vw_results *results) {
    static const char *const of_map[] = {"up", "positions", "directions", "points"}, *const of_residuals[] = {"photos"};
    enum vw_status status = read_json(out, VW_SCENE_MAP_FILE, results, of_map, VW_ARRAY_COUNT(of_map), &results->map);
    if (!status) status = read_defects(results);
    if (!status) status = read_reconstruction(out, results);
    if (!status) status = vw_results_read_next(out, no_photos, results);
    if (status || no_photos) return status;
    return read_json(out, VW_RESIDUALS_FILE, results, of_residuals, VW_ARRAY_COUNT(of_residuals), &results->residuals);
}

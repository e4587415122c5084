#include "run/outputs/scene_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "report/told.h"

enum { REAL_DIGITS = 7 };

// ---- Writing -------------------------------------------------------------------------------------------------------

static void append_column(json_t **array, const struct vw_view *view, int column, double factor) {
    for (int row = 0; row < 3; row++) vw_json_append(array, vw_json_real(factor * view->camera_to_world[row][column]));
}

static json_t *up_of(const struct vw_scene *scene) {
    double sum[3] = {0}, squares = 0;
    json_t *up = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int row = 0; row < 3; row++) sum[row] += scene->views[v].camera_to_world[row][1];
    for (int row = 0; row < 3; row++) squares += sum[row] * sum[row];
    for (int row = 0; row < 3; row++)
        vw_json_append(&up, vw_json_real(squares > 0 ? sum[row] / sqrt(squares) : row == 2));
    return up;
}

static json_t *points_of(const struct vw_scene *scene) {
    json_t *points = json_array();
    uint64_t count = scene->point_count < VW_SCENE_MAP_POINTS_MAX ? scene->point_count : VW_SCENE_MAP_POINTS_MAX;
    for (uint64_t i = 0; i < count; i++) {
        const struct vw_point *point = &scene->points[i * scene->point_count / count];
        for (int axis = 0; axis < 3; axis++) vw_json_append(&points, vw_json_real(point->position_world[axis]));
    }
    return points;
}

static json_t *reasons_to_json(const char *const *reasons, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t v = 0; v < count; v++) vw_json_append(&array, reasons[v] ? vw_json_string(reasons[v]) : json_null());
    return array;
}

static char *map_to_text(const struct vw_scene *scene, const char *const *reasons) {
    char hash[VW_HASH_HEX_BYTES];
    json_t *map = json_object(), *positions = json_array(), *directions = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++) {
        append_column(&positions, &scene->views[v], 3, 1);
        append_column(&directions, &scene->views[v], 2, -1); // cameras look along -z
    }
    vw_hash_to_hex(scene->hash, hash);
    vw_json_set(&map, "scene_hash", vw_json_string(hash));
    vw_json_set(&map, "up", up_of(scene));
    vw_json_set(&map, "positions", positions);
    vw_json_set(&map, "directions", directions);
    vw_json_set(&map, "points", points_of(scene));
    vw_json_set(&map, "reasons", reasons_to_json(reasons, scene->view_count));
    char *text = vw_json_to_text(map, JSON_COMPACT | JSON_REAL_PRECISION(REAL_DIGITS));
    json_decref(map);
    return text;
}

enum vw_status vw_scene_map_write(const struct vw_scene *scene, const char *const *reasons, const char *out,
                                  struct vw_checksums *made) {
    char *text = map_to_text(scene, reasons);
    enum vw_status status = text ? vw_result_write(out, VW_SCENE_MAP_FILE, text, strlen(text), made)
                                 : vw_fail(VW_ERROR_MEMORY, "%s: out of memory for " VW_SCENE_MAP_FILE, out);
    free(text);
    return status;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

// Returns whether a list has `count` triples of numbers; null means a number that is not finite.
static bool has_triples(const json_t *map, const char *key, size_t count) {
    const json_t *array = json_object_get(map, key);
    bool fits = json_is_array(array) && json_array_size(array) == 3 * count;
    for (size_t i = 0; fits && i < 3 * count; i++) {
        const json_t *number = json_array_get(array, i);
        fits = json_is_number(number) || json_is_null(number);
    }
    return fits;
}

// Returns whether each image has a word that advice knows, or none. A map of an earlier version has no list.
static bool has_reasons(const json_t *array, size_t count) {
    bool fits = !array || (json_is_array(array) && json_array_size(array) == count);
    for (size_t i = 0; fits && i < json_array_size(array); i++) {
        const json_t *reason = json_array_get(array, i);
        fits = json_is_null(reason) || vw_told_known_reason(json_string_value(reason));
    }
    return fits;
}

enum vw_status vw_scene_map_check(const char *path, json_t *map, const char *scene_hash, uint32_t image_count) {
    static const char remedy[] = "remove it, or value the photos again";
    const char *hash = json_string_value(json_object_get(map, "scene_hash"));
    size_t point_count = json_array_size(json_object_get(map, "points")) / 3;
    const char *broken = !has_triples(map, "up", 1)                     ? "up"
                         : !has_triples(map, "positions", image_count)  ? "positions"
                         : !has_triples(map, "directions", image_count) ? "directions"
                         : point_count > VW_SCENE_MAP_POINTS_MAX || !has_triples(map, "points", point_count) ? "points"
                         : !has_reasons(json_object_get(map, "reasons"), image_count)                        ? "reasons"
                                                                                                             : NULL;
    if (!hash || strcmp(hash, scene_hash) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: is of another scene than the ledger; %s", path, remedy);
    return broken ? vw_fail(VW_ERROR_INPUT, "%s: %s: is not what the ledger's photos need; %s", path, broken, remedy)
                  : VW_OK;
}

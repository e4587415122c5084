#include "run/outputs/report_shape.h"

#include <stdbool.h>
#include <string.h>

#include "base/memory.h"

// ---- Tables --------------------------------------------------------------------------------------------------------

static bool has_text(const json_t *array, const char *text) {
    for (size_t i = 0; i < json_array_size(array); i++)
        if (strcmp(json_string_value(json_array_get(array, i)), text) == 0) return true;
    return false;
}

enum vw_status vw_report_shape_of_table(const char *path, const char *const *columns, const json_t *header) {
    for (; *columns; columns++)
        if (!has_text(header, *columns))
            return vw_fail(VW_ERROR_INPUT, "%s: lacks the column %s; make it again, or remove it", path, *columns);
    return VW_OK;
}

// ---- A comparison --------------------------------------------------------------------------------------------------

// Checks each item and returns 0 for a match, like jansson; `error` says what does not match.
static int check_each(json_t *array, int (*check)(json_t *, json_error_t *), json_error_t *error) {
    for (size_t i = 0; i < json_array_size(array); i++)
        if (check(json_array_get(array, i), error)) return -1;
    return 0;
}

static int check_text(json_t *text, json_error_t *error) {
    return json_unpack_ex(text, error, JSON_VALIDATE_ONLY, "s");
}

static int check_seed(json_t *seed, json_error_t *error) {
    return json_unpack_ex(seed, error, JSON_VALIDATE_ONLY, "I");
}

static int check_outcome(json_t *outcome, json_error_t *error) {
    return json_unpack_ex(outcome, error, JSON_VALIDATE_ONLY, "{s:I, s:I}", "seed", "photo_count");
}

static int check_list(json_t *list, json_error_t *error) {
    return json_unpack_ex(list, error, JSON_VALIDATE_ONLY, "{s:s, s:[], s:{}, s:{}}", "name", "outcomes", "mean",
                          "stderr") ||
           check_each(json_object_get(list, "outcomes"), check_outcome, error);
}

static int check_pair(json_t *pair, json_error_t *error) {
    return json_unpack_ex(pair, error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:s, s:b}", "list", "against", "measure",
                          "beyond_noise");
}

static int check_disagreement(json_t *photo, json_error_t *error) {
    return json_unpack_ex(photo, error, JSON_VALIDATE_ONLY, "{s:s, s:[], s:[]}", "photo", "in", "not_in") ||
           check_each(json_object_get(photo, "in"), check_text, error) ||
           check_each(json_object_get(photo, "not_in"), check_text, error);
}

static int check_render(json_t *render, json_error_t *error) {
    return json_unpack_ex(render, error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:s, s:[]}", "view", "split", "file",
                          "columns") ||
           check_each(json_object_get(render, "columns"), check_text, error);
}

enum vw_status vw_report_shape_of_comparison(const char *path, json_t *compare) {
    static const struct {
        const char *name;
        int (*check)(json_t *, json_error_t *);
    } arrays[] = {{"seeds", check_seed},
                  {"lists", check_list},
                  {"pairs", check_pair},
                  {"disagreements", check_disagreement},
                  {"renders", check_render}};
    json_error_t error;
    const char *where = "the whole";
    int broken = json_unpack_ex(
        compare, &error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:i, s:i, s?b, s:[], s:[], s:[], s:[], s:[]}", "scene",
        "scene_hash", "downscale", "epochs", "half_views", "seeds", "lists", "pairs", "disagreements", "renders");
    for (size_t i = 0; i < VW_ARRAY_COUNT(arrays) && !broken; i++) {
        where = arrays[i].name;
        broken = check_each(json_object_get(compare, where), arrays[i].check, &error);
    }
    return broken ? vw_fail(VW_ERROR_INPUT, "%s: %s: %s; compare again", path, where, error.text) : VW_OK;
}

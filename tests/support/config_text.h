// Configs that differ from another in settings that are written as in their JSON, with single quotes: 'rays':1,'seed':2
#ifndef VIEWWORTH_TESTS_SUPPORT_CONFIG_TEXT_H
#define VIEWWORTH_TESTS_SUPPORT_CONFIG_TEXT_H

#include "support/cmocka_test.h"

#include "base/json.h"
#include "base/memory.h"
#include "viewworth/train.h"

// Returns the config's JSON with other settings in it; to be freed.
static inline char *config_json_with(const struct vw_config *config, const char *settings) {
    AUTO_FREE char *text = vw_format_text("{%s}", settings), *usual = vw_config_to_json(config, false);
    for (char *quote = text; (quote = strchr(quote, '\''));) *quote = '"';
    json_t *object = json_loads(usual, 0, NULL), *changes = json_loads(text, 0, NULL);
    assert_non_null(changes);
    assert_int_equal(json_object_update_existing(object, changes), 0);
    char *json = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(changes);
    json_decref(object);
    return json;
}

static inline struct vw_config config_with(const struct vw_config *config, const char *settings) {
    struct vw_config changed;
    AUTO_FREE char *json = config_json_with(config, settings);
    ASSERT_OK(vw_config_from_json(json, &changed));
    return changed;
}

#endif

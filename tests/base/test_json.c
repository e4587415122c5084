// Building JSON: a failure anywhere leaves NULL at the end.
#include "support/cmocka_test.h"

#include "base/json.h"

static void assert_json(json_t *value, const char *expected) {
    AUTO_FREE char *text = json_dumps(value, JSON_COMPACT | JSON_SORT_KEYS | JSON_ENCODE_ANY);
    assert_string_equal(text, expected);
    json_decref(value);
}

TEST(values_are_appended_and_set) {
    json_t *array = json_array(), *object = json_object();
    vw_json_append(&array, json_integer(1));
    vw_json_append(&array, vw_json_real(NAN));
    vw_json_set(&object, "a", array);
    vw_json_set(&object, "b", json_true());
    assert_json(object, "{\"a\":[1,null],\"b\":true}");
}

TEST(a_missing_value_drops_the_container) {
    json_t *array = json_array(), *object = json_object();
    vw_json_append(&array, NULL);
    assert_null(array);
    vw_json_append(&array, json_integer(1)); // dropped, too
    assert_null(array);
    vw_json_set(&object, "a", array);
    assert_null(object);
    vw_json_set(&object, "b", json_true());
    assert_null(object);
}

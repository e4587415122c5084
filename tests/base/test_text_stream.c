// Texts are printed into memory whole or not at all.
// wrap: reallocarray
#include "support/cmocka_test.h"

#include <unistd.h>

#include "base/csv.h"
#include "base/json.h"
#include "base/text_stream.h"
#include "support/temporary_folder.h"

enum { LINES = 20000 };
static bool memory_is_short;

WRAPS(reallocarray);

// Replaces the C library's function at link time.
void *__wrap_reallocarray(void *memory, size_t count, size_t item_bytes) {
    return memory_is_short && count * item_bytes > 8192 ? NULL : __real_reallocarray(memory, count, item_bytes);
}

static void print_lines(FILE *stream, const void *context) {
    (void)context;
    for (int i = 0; i < LINES; i++) fprintf(stream, "%05d\n", i);
}

TEST(what_was_printed_is_there) {
    struct vw_text_stream stream;
    AUTO_FREE char *text = NULL;
    size_t size_bytes = 0;
    assert_non_null(vw_text_stream_open(&stream));
    print_lines(stream.stream, NULL);
    ASSERT_OK(vw_text_stream_close(&stream, "lines", &text, &size_bytes));
    assert_int_equal(size_bytes, LINES * 6);
    assert_int_equal(strlen(text), size_bytes);
    assert_string_equal(text + size_bytes - 6, "19999\n");
}

TEST(nothing_printed_is_an_empty_text) {
    struct vw_text_stream stream;
    AUTO_FREE char *text = NULL;
    size_t size_bytes = 1;
    assert_non_null(vw_text_stream_open(&stream));
    ASSERT_OK(vw_text_stream_close(&stream, "nothing", &text, &size_bytes));
    assert_string_equal(text, "");
    assert_int_equal(size_bytes, 0);
}

TEST(a_text_without_memory_is_refused) {
    struct vw_text_stream stream;
    char *text = NULL;
    size_t size_bytes = 0;
    memory_is_short = true;
    assert_non_null(vw_text_stream_open(&stream));
    print_lines(stream.stream, NULL);
    ASSERT_FAILS(vw_text_stream_close(&stream, "lines", &text, &size_bytes), VW_ERROR_MEMORY, "lines: out of memory");
    memory_is_short = false;
    assert_null(text);
}

TEST(a_table_without_memory_is_not_written) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "table.csv");
    memory_is_short = true;
    assert_int_equal(vw_csv_write_file(path, print_lines, NULL), VW_ERROR_MEMORY);
    memory_is_short = false;
    assert_false(vw_file_exists(path));
}

TEST(a_document_without_memory_is_not_printed) {
    json_t *array = json_array();
    for (int i = 0; i < LINES; i++) vw_json_append(&array, json_pack("{s:i}", "key", i));
    AUTO_FREE char *text = vw_json_to_text(array, JSON_COMPACT);
    assert_non_null(text);
    memory_is_short = true;
    assert_null(vw_json_to_text(array, JSON_COMPACT));
    memory_is_short = false;
    json_decref(array);
    assert_null(vw_json_to_text(NULL, JSON_COMPACT));
}

TEST(failures_name_a_remedy) {
    vw_fail(VW_ERROR_MEMORY, "out of memory for a string");
    assert_string_equal(vw_error_message(), "out of memory for a string; close other programs or use --downscale");
    vw_fail(VW_ERROR_MISMATCH, "a row was edited");
    assert_string_equal(vw_error_message(),
                        "a row was edited; get the folder again from a copy or from where it was made");
    vw_fail(VW_ERROR_MEMORY, "it is full; empty it");
    assert_string_equal(vw_error_message(), "it is full; empty it");
}

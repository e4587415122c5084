// Split files of NeRF-W: any column order, strange ids, every refusal; and the real ones.
#include "support/cmocka_test.h"

#include "scene/formats/nerfw_tsv.h"
#include "support/temporary_folder.h"

static struct vw_tsv read(const char *path) {
    struct vw_tsv tsv = {0};
    if (vw_tsv_read(NULL, path, &tsv)) fail_msg("%s", vw_error_message());
    return tsv;
}

static void check_row(const struct vw_tsv_row *row, const char *name, bool test, bool has_id, int line) {
    assert_string_equal(row->name, name);
    assert_int_equal(row->test, test);
    assert_int_equal(row->has_id, has_id);
    assert_int_equal(row->line, line);
}

FOLDER_TEST(columns_come_in_any_order) {
    static const char *const texts[] = {
        "filename\tid\tsplit\tdataset\nb.jpg\t1091.0\ttest\tx\na.jpg\t\ttrain\tx\n\nc d.jpg\t7\ttrain\tx\n",
        "id\tsplit\tfilename\tdataset\r\n24\ttest\tb.jpg\tx\r\n\ttrain\ta.jpg\tx\r\n\r\n9\ttrain\tc d.jpg\tx\r\n",
        "note\tsplit\tother\tid\tfilename\n\ttest\t\t5\tb.jpg\n\ttrain\t\t\ta.jpg\n\n\ttrain\t\t5\tc d.jpg",
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(texts); i++) {
        AUTO(vw_tsv_clear) struct vw_tsv tsv = read(temporary_file(*state, "a.tsv", texts[i]));
        assert_int_equal(tsv.row_count, 3);
        assert_int_equal(tsv.test_count, 1);
        check_row(&tsv.rows[0], "b.jpg", true, true, 2);
        check_row(&tsv.rows[1], "a.jpg", false, false, 3);
        check_row(&tsv.rows[2], "c d.jpg", false, true, 5);
    }
    struct vw_tsv tsv = read(temporary_file(*state, "a.tsv", "split\tfilename\ntrain\ta.jpg\n")); // ids are not needed
    check_row(&tsv.rows[0], "a.jpg", false, false, 2);
    vw_tsv_clear(&tsv);
    vw_tsv_clear(&tsv); // an empty one is fine
}

FOLDER_TEST(bad_files_are_refused) {
    static const struct refused_text cases[] = {
        {"", "a.tsv:1", "header"},
        {"filename\tid\n", "a.tsv:1", "filename or split"},
        {"filename,split\na.jpg,train\n", "a.tsv:1", "header"},
        {"filename\tsplit\n", "a.tsv", "no rows"},
        {"filename\tsplit\na.jpg\n", "a.tsv:2", "1 fields, but the header has 2"},
        {"filename\tsplit\na.jpg\ttrain\tx\n", "a.tsv:2", "3 fields"},
        {"filename\tsplit\n\na.jpg\tval\n", "a.tsv:3", "\"val\" is neither"},
        {"filename\tsplit\na.jpg\t\n", "a.tsv:2", "field split"},
        {"filename\tsplit\n\ttrain\n", "a.tsv:2", "field filename"},
        {"filename\tsplit\n../a.jpg\ttrain\n", "a.tsv:2", "../a.jpg"},
        {"filename\tsplit\n/etc/passwd\ttest\n", "a.tsv:2", "/etc/passwd"},
        {"filename\tsplit\na\x01.jpg\ttest\n", "a.tsv:2", "field filename"},
        {"filename\tsplit\na.jpg\ttrain\nb.jpg\ttrain\na.jpg\ttrain\n", "a.tsv:4",
         "a.jpg appears twice (first in line 2)"},
        {"filename\tsplit\na.jpg\ttest\na.jpg\ttrain\n", "a.tsv:3", "a.jpg is in two splits"},
    };
    struct vw_tsv tsv = {0};
    ASSERT_TEXTS_REFUSED(*state, "a.tsv", cases, vw_tsv_read(NULL, path, &tsv));
    assert_null(tsv.text);
    const char zero[] = "filename\tsplit\na.jpg\ttrain\0\n";
    ASSERT_OK(vw_file_write(temporary_path(*state, "a.tsv"), zero, sizeof zero - 1));
    assert_int_equal(vw_tsv_read(NULL, temporary_path(*state, "a.tsv"), &tsv), VW_ERROR_INPUT);
    assert_int_equal(vw_tsv_read(NULL, temporary_path(*state, "none.tsv"), &tsv), VW_ERROR_INPUT);
}

FOLDER_TEST(the_header_is_recognised) {
    assert_true(vw_tsv_has_header(NULL, temporary_file(*state, "a.tsv", "id\tsplit\tfilename\r\n")));
    assert_false(vw_tsv_has_header(NULL, temporary_file(*state, "a.tsv", "id\tsplit\n")));
    assert_false(vw_tsv_has_header(NULL, temporary_file(*state, "a.tsv", "")));
    assert_false(vw_tsv_has_header(NULL, temporary_path(*state, "none.tsv")));
    assert_false(vw_tsv_has_header(NULL, *state));
}

// Counts of the published files: rows = train with id + train without + test.
TEST(published_files_are_read) {
    static const struct {
        const char *name;
        size_t with_id, without_id, test;
    } files[] = {
        {"brandenburg.tsv", 763, 96, 10}, {"sacre.tsv", 830, 120, 21}, {"trevi.tsv", 1689, 27, 19},
        {"taj_mahal.tsv", 899, 0, 27},    {"hagia.tsv", 835, 0, 29},   {"prague.tsv", 2083, 0, 27},
    };
    const char *folder = real_scene_path("nerfw_splits");
    if (!folder) skip();
    for (size_t f = 0; f < VW_ARRAY_COUNT(files); f++) {
        AUTO(vw_tsv_clear) struct vw_tsv tsv = read(temporary_path(folder, files[f].name));
        size_t without_id = 0;
        for (size_t i = 0; i < tsv.row_count; i++) without_id += !tsv.rows[i].test && !tsv.rows[i].has_id;
        print_message("%s: %zu rows, %zu test, %zu train without id\n", files[f].name, tsv.row_count, tsv.test_count,
                      without_id);
        assert_int_equal(tsv.row_count, files[f].with_id + files[f].without_id + files[f].test);
        assert_int_equal(tsv.test_count, files[f].test);
        assert_int_equal(without_id, files[f].without_id);
    }
}

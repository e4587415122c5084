// One list of columns: the CSV, the JSON and the cells of its rows, and what is unknown in each.
#include "support/cmocka_test.h"

#include <math.h>

#include "base/rows.h"

struct photo {
    const char *name;
};

struct row {
    const struct photo *photo;
    const char *label;
    double value, amount;
    uint64_t cents;
    uint32_t count, rank;
    bool flag;
    char chars[8];
};

static const struct vw_column columns[] = {
    {VW_CELL_VIA("name", struct row, photo, TEXT, struct photo, name), .title = "photo"},
    VW_COLUMN(struct row, TEXT_OR_NULL, label),
    {VW_CELL("value", struct row, REAL_OR_NULL, value), .title = "value", .digits = 2, .has_sign = true},
    {VW_CELL("amount", struct row, CENTS_OR_NULL, amount), .left_out = VW_NOT_IN_JSON},
    {VW_CELL("cents", struct row, CENTS, cents), .left_out = VW_NOT_IN_CSV},
    VW_COLUMN(struct row, COUNT, count),
    VW_COLUMN(struct row, RANK, rank),
    VW_COLUMN(struct row, FLAG, flag),
    VW_COLUMN(struct row, CHARS, chars),
};
static const struct photo photo = {"a,b.png"};
static const struct row rows[] = {{&photo, "x", -0.1, 1234, 1205, 7, 2, true, "t"},
                                  {NULL, NULL, NAN, NAN, 5, 0, 0, false, ""}};

TEST(csv_has_empty_fields_for_what_is_unknown) {
    const struct vw_rows all = VW_ROWS(columns, rows, 2);
    struct vw_csv_text made = {0};
    ASSERT_OK(vw_rows_make_csv("rows.csv", &all, &made));
    assert_string_equal(made.text, "name,label,value,amount,count,rank,flag,chars\n"
                                   "\"a,b.png\",x,-0.1,12.34,7,2,true,t\n"
                                   ",,,,0,,false,\n");
    free(made.text);
}

static void assert_json(json_t *value, const char *wanted) {
    char *text = json_dumps(value, JSON_COMPACT);
    assert_string_equal(text, wanted);
    free(text);
    json_decref(value);
}

TEST(json_has_null) {
    const struct vw_rows all = VW_ROWS(columns, rows, 2);
    assert_json(vw_rows_to_json(&all),
                "[{\"name\":\"a,b.png\",\"label\":\"x\",\"value\":-0.10000000000000001,\"cents\":\"12.05\",\"count\":7,"
                "\"rank\":2,\"flag\":true,\"chars\":\"t\"},{\"name\":\"\",\"label\":null,\"value\":null,\"cents\":"
                "\"0.05\",\"count\":0,\"rank\":null,\"flag\":false,\"chars\":null}]");
    const struct vw_rows two = {columns, 2, rows, 2, sizeof rows[0]};
    assert_json(vw_rows_to_arrays(&two), "{\"name\":[\"a,b.png\",\"\"],\"label\":[\"x\",null]}");
    assert_json(vw_rows_to_texts(&two), "{\"header\":[\"name\",\"label\"],\"rows\":[[\"a,b.png\",\"x\"],[\"\",\"\"]]}");
}

TEST(cells_have_the_digits_of_their_column) {
    const struct vw_rows all = VW_ROWS(columns, rows, 2);
    char text[VW_CELL_BYTES];
    assert_string_equal(vw_rows_cell(&all, 0, &columns[2], text), "-0.10");
    assert_null(vw_rows_cell(&all, 1, &columns[2], text));
    assert_null(vw_rows_cell(&all, 1, &columns[0], text));
}

// Reading CSV as RFC 4180 has it, and what is refused, with its line; that what is written reads back.
#include "support/cmocka_test.h"

#include "base/csv.h"
#include "base/random.h"
#include "support/temporary_folder.h"

// Returns all records as text: fields in brackets, records after their line number.
static char *all_of(const char *path) {
    AUTO(vw_csv_close) struct vw_csv csv;
    bool found = false;
    char *text = vw_copy_text("");
    if (vw_csv_open(path, 1 << 20, &csv)) fail_msg("%s", vw_error_message());
    for (;;) {
        if (vw_csv_next(&csv, &found)) fail_msg("%s", vw_error_message());
        if (!found) break;
        char *longer = vw_format_text("%s%u:", text, csv.line);
        free(text);
        text = longer;
        for (uint32_t i = 0; i < csv.field_count; i++) {
            longer = vw_format_text("%s[%s]", text, csv.fields[i]);
            free(text);
            text = longer;
        }
    }
    return text;
}

FOLDER_TEST(records_are_read) {
    static const struct {
        const char *text, *expected;
    } cases[] = {
        {"", ""},
        {"\n\r\n\n", ""},
        {"a,b\nc,d", "1:[a][b]2:[c][d]"},
        {"a,b\r\n\r\nc,d\r\n", "1:[a][b]3:[c][d]"},
        {"\xef\xbb\xbf"
         "a,b\n",
         "1:[a][b]"},
        {",\n,,", "1:[][]2:[][][]"},
        {"\"a,b\",\"c\"\"d\"\n\"\"", "1:[a,b][c\"d]2:[]"},
        {"\"two\nlines\",x\ny\n", "1:[two\nlines][x]3:[y]"},
        {"\"two\r\nlines\"\r\ny", "1:[two\r\nlines]3:[y]"},
        {"\"\"\"\"\"\",\"a\"\n", "1:[\"\"][a]"},
        {" a , b\n", "1:[ a ][ b]"}, // spaces are part of a field
        {"a\rb\n", "1:[a\rb]"},
        {"a\n\"\"", "1:[a]2:[]"},
        {"'=1,'a,'',-1,=2\n", "1:[=1]['a][''][-1][=2]"}, // the guard is taken away, and nothing else
        {"\"'-a,b\",''+c,'\n", "1:[-a,b]['+c][']"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        AUTO_FREE char *records = all_of(temporary_file(*state, "a.csv", cases[i].text));
        assert_string_equal(records, cases[i].expected);
    }
}

static enum vw_status read_whole(const char *path) {
    AUTO(vw_csv_close) struct vw_csv csv;
    bool found = true;
    enum vw_status status = vw_csv_open(path, 1 << 20, &csv);
    while (!status && found) status = vw_csv_next(&csv, &found);
    return status;
}

FOLDER_TEST(broken_records_are_refused) {
    static const struct refused_text cases[] = {
        {"a\nb,\"c\n", "a.csv:2: a quote is not closed"},
        {"a\n\"b\n\n\nc", "a.csv:2: a quote is not closed"}, // where it begins
        {"\"a\"b,c\n", "a.csv:1: text follows a closing quote"},
        {"\"a\n\n\"b,c\n", "a.csv:3: text follows a closing quote"},
        {"x\na\"b\"\n", "a.csv:2: a quote within a field"},
        {"\"", "a.csv:1: a quote is not closed"},
        {"\"a\"\"", "a.csv:1: a quote is not closed"},
    };
    ASSERT_TEXTS_REFUSED(*state, "a.csv", cases, read_whole(path));
    struct vw_csv csv;
    assert_int_equal(vw_csv_open(temporary_path(*state, "none.csv"), 1 << 20, &csv), VW_ERROR_INPUT);
    vw_csv_close(&csv);
    assert_int_equal(vw_csv_open(temporary_file(*state, "a.csv", "12345"), 4, &csv), VW_ERROR_INPUT);
    vw_csv_close(&csv);
    temporary_write(temporary_path(*state, "a.csv"), "a\0b", 3);
    ASSERT_FAILS(vw_csv_open(temporary_path(*state, "a.csv"), 1 << 20, &csv), VW_ERROR_INPUT, "zero byte");
    vw_csv_close(&csv);
}

struct fields {
    char texts[40][8];
    uint32_t count;
};

// A field costs a pointer, eight times its comma.
FOLDER_TEST(a_record_has_a_limit_of_fields) {
    static char text[VW_CSV_FIELDS_MAX + 2];
    for (int more = 0; more < 2; more++) {
        AUTO(vw_csv_close) struct vw_csv csv;
        bool found = false;
        memset(text, 0, sizeof text);
        memset(text, ',', (size_t)VW_CSV_FIELDS_MAX - 1 + more);
        ASSERT_OK(vw_csv_open(temporary_file(*state, "wide.csv", text), sizeof text, &csv));
        enum vw_status status = vw_csv_next(&csv, &found);
        if (more) ASSERT_FAILS(status, VW_ERROR_INPUT, "wide.csv:1: more than 4096 fields");
        else assert_int_equal(csv.field_count, VW_CSV_FIELDS_MAX);
    }
}

static void print_fields(FILE *stream, const void *context) {
    const struct fields *fields = context;
    for (uint32_t i = 0; i < fields->count; i++) {
        if (i > 0) fputc(',', stream);
        vw_csv_write_text(stream, fields->texts[i]);
    }
    fputc('\n', stream);
}

// Any text comes back, as one record of as many fields.
FOLDER_TEST(what_is_written_reads_back) {
    static const char letters[] = "a,\"\n\r ;'=+-@\t";
    const uint64_t seed = 20261121;
    for (uint32_t round = 0; round < 50; round++) {
        struct fields fields = {.count = VW_ARRAY_COUNT(fields.texts)};
        for (uint32_t i = 0; i < fields.count; i++) {
            uint32_t words[4];
            vw_random_words(seed, VW_RANDOM_JITTER, round, i, 0, words);
            uint32_t length = words[0] % 7;
            for (uint32_t c = 0; c < length; c++)
                fields.texts[i][c] = letters[(words[1] >> 4 * c) % (sizeof letters - 1)];
        }
        const char *path = temporary_path(*state, "a.csv");
        ASSERT_OK(vw_csv_write_file(path, print_fields, &fields));
        AUTO(vw_csv_close) struct vw_csv csv;
        bool found = false;
        ASSERT_OK(vw_csv_open(path, 1 << 20, &csv));
        if (vw_csv_next(&csv, &found))
            fail_msg("seed %llu, round %u: %s", (unsigned long long)seed, round, vw_error_message());
        assert_true(found && csv.field_count == fields.count);
        for (uint32_t i = 0; i < fields.count; i++) assert_string_equal(csv.fields[i], fields.texts[i]);
        ASSERT_OK(vw_csv_next(&csv, &found));
        assert_false(found);
    }
}

// A spreadsheet takes nothing for a formula, and everything else stays as it is.
TEST(formulas_are_guarded) {
    static const struct {
        const char *text, *written;
    } cases[] = {
        {"=cmd|'/C calc'!A0", "'=cmd|'/C calc'!A0"},
        {"+1", "'+1"},
        {"-1+1", "'-1+1"},
        {"@SUM(A1)", "'@SUM(A1)"},
        {"\t=1", "'\t=1"},
        {"\r=1", "\"'\r=1\""},
        {"\n=1", "\"'\n=1\""},
        {"=1,\"2\"", "\"'=1,\"\"2\"\"\""},
        {"'=1", "''=1"},
        {"'''@", "''''@"},
        {"", ""},
        {"'", "'"},
        {"'a", "'a"},
        {"a=1", "a=1"},
        {" =1", " =1"},
        {"\xef\xbc\x9d"
         "1",
         "'\xef\xbc\x9d"
         "1"}, // in full width
        {"\xef\xbc\x8c"
         "1",
         "\xef\xbc\x8c"
         "1"},                     // a comma in full width
        {"a;=1;b", "\"a;'=1;b\""}, // a cell of its own where commas separate decimals
        {"a;\"=1;", "\"a;'\"\"=1;\""},
        {"\"=1", "\"'\"\"=1\""},
        {"1-2", "1-2"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        char text[64] = "";
        FILE *stream = fmemopen(text, sizeof text, "w");
        assert_non_null(stream);
        vw_csv_write_text(stream, cases[i].text);
        fclose(stream);
        assert_string_equal(text, cases[i].written);
    }
}

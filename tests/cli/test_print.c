// Text from files on a terminal: what is replaced, in messages, log lines, tables and JSON, and what a shell makes of a
// path that a command advises.
#include "support/ledger_fixture.h"

#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "support/printed.h"
#include "viewworth/log.h"

static const struct {
    const char *text, *shown;
} texts[] = {
    {"photo 1.png", "photo 1.png"},
    {"d\xc3\xb6ner \xe5\x86\x99\xe7\x9c\x9f \xf0\x9f\x93\xb7",
     "d\xc3\xb6ner \xe5\x86\x99\xe7\x9c\x9f \xf0\x9f\x93\xb7"},
    {"\x1b]0;title\a\x1b[2J", "?]0;title??[2J"}, // C0: escape sequences
    {"a\r\nb\tc\x7f", "a??b?c?"},                // C0 and DEL
    {"a\xc2\x9b"
     "2J",
     "a?2J"},                          // C1: control sequence introducer
    {"\xc2\xa0\xc2\x80", "\xc2\xa0?"}, // the first character after C1, and the first of it
    {"a\xe2\x80\xae"
     "gnp.b",
     "a?gnp.b"},                                       // right-to-left override
    {"\xe2\x81\xa6x\xe2\x81\xa9\xe2\x80\x8f", "?x??"}, // isolates, and a mark
    {"a\xe2\x80\xa8"
     "b\xd8\x9c",
     "a?b?"},                                      // line separator, Arabic letter mark
    {"a\xe2\x80\x8b\xef\xbb\xbf\xc2\xad", "a???"}, // zero width space and no-break space, soft hyphen
    {"\xf3\xa0\x81\x81z", "?z"},                   // a tag
    {"\xff\xfe", "??"},                            // never in UTF-8
    {"\xc0\xaf\xe0\x80\xaf", "?????"},             // overlong
    {"\xed\xa0\x80", "???"},                       // a surrogate
    {"\xf4\x90\x80\x80", "????"},                  // beyond U+10FFFF
    {"ab\xe2\x82", "ab??"},                        // cut
    {"\xc3(", "?("},                               // its second byte is a character of its own
};

static void keep_line(void *context, enum vw_log_level level, const char *line) {
    (void)level;
    snprintf(context, 64, "%s", line);
}

TEST(what_acts_is_replaced) {
    char line[64];
    vw_log_set_sink(keep_line, line);
    for (size_t i = 0; i < VW_ARRAY_COUNT(texts); i++) {
        char text[64];
        snprintf(text, sizeof text, "%s", texts[i].text);
        vw_text_make_line(text);
        assert_string_equal(text, texts[i].shown);
        assert_int_equal(vw_text_is_clean(texts[i].text), strcmp(texts[i].text, texts[i].shown) == 0);
        assert_true(vw_text_is_clean(text));
        vw_fail(VW_ERROR_INPUT, "%s", texts[i].text);
        assert_string_equal(vw_error_message(), texts[i].shown);
        vw_log_info("%s", texts[i].text);
        assert_string_equal(line, texts[i].shown);
    }
    vw_log_set_sink(NULL, NULL);
}

// ---- Tables ----

struct table_row {
    const char *name, *note;
    double value, unknown;
};

static void print_table(const void *context) {
    static const struct vw_column columns[] = {
        {VW_CELL("name", struct table_row, TEXT, name), .title = "name"},
        {VW_CELL("value", struct table_row, REAL_OR_NULL, value), .title = "dB", .digits = 1},
        {VW_CELL("unknown", struct table_row, REAL_OR_NULL, unknown), .title = "left out"},
        {VW_CELL("note", struct table_row, TEXT_OR_NULL, note), .title = "note"},
    };
    const struct vw_rows rows = VW_ROWS(columns, (const struct table_row *)context, 2);
    vw_print_rows(&rows);
}

TEST(columns_stand_below_their_title) {
    const struct table_row rows[] = {{"a\x1b[2J", "so", 12.25, NAN}, {"longer name", NULL, NAN, NAN}};
    AUTO_FREE char *text = printed_on(stdout, print_table, rows);
    assert_string_equal(text, "name           dB  note\n"
                              "a?[2J        12.2  so\n"
                              "longer name     -\n");
}

static void print_row(const void *name) { vw_print("photo    %s\nworth    %d\n", (const char *)name, 3); }

TEST(a_name_cannot_forge_a_line) {
    static const struct {
        const char *name, *rows;
    } cases[] = {{"a.png", "photo    a.png\nworth    3\n"},
                 {"\x1b[2Ja\xe2\x80\xae.png", "photo    ?[2Ja?.png\nworth    3\n"},
                 {"a\nhead     0123", "photo    a?head     0123?worth    3\n"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        AUTO_FREE char *rows = printed_on(stdout, print_row, cases[i].name);
        assert_string_equal(rows, cases[i].rows);
    }
    char long_name[5000]; // longer than any buffer
    memset(long_name, 'x', sizeof long_name - 1);
    long_name[sizeof long_name - 1] = 0;
    AUTO_FREE char *rows = printed_on(stdout, print_row, long_name);
    assert_int_equal(strlen(rows), strlen("photo    \nworth    3\n") + strlen(long_name));
}

static void print_json(const void *name) { ASSERT_OK(vw_json_print(json_pack("{s:s}", "name", (const char *)name))); }

TEST(json_is_ascii_and_keeps_the_name) {
    const char *name = "d\xc3\xb6ner \xc2\x9b \xe2\x80\xae.png";
    AUTO_FREE char *text = printed_on(stdout, print_json, name);
    for (const char *next = text; *next; next++) assert_in_range(*next, '\n', '~');
    json_t *read = json_loads(text, 0, NULL);
    assert_string_equal(json_string_value(json_object_get(read, "name")), name);
    json_decref(read);
}

static void print_advice(const void *path) {
    vw_print("printf %%s");
    vw_print_shell_path(path);
}

// The advice is run by a shell, which must give the path to the command as one word and do nothing else.
TEST(a_shell_takes_an_advised_path_as_one_word) {
    static const char *const paths[] = {"scenes/fox_1.json",
                                        "a b",
                                        "",
                                        "it's",
                                        "''",
                                        "'",
                                        "$(echo 1)",
                                        "`echo 1`",
                                        "a;b",
                                        "a&b",
                                        "*",
                                        "~",
                                        "a\\b",
                                        "{a,b}",
                                        "#x",
                                        "!x",
                                        "\"",
                                        "d\xc3\xb6ner",
                                        "a'$(echo 1)'b"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(paths); i++) {
        char *command = printed_on(stdout, print_advice, paths[i]), word[64] = "";
        FILE *shell = popen(command, "r");
        assert_non_null(shell);
        assert_int_equal(fread(word, 1, sizeof word - 1, shell), strlen(paths[i]));
        assert_int_equal(pclose(shell), 0);
        assert_string_equal(word, paths[i]);
        free(command);
    }
    char *command = printed_on(stdout, print_advice, "-rf");
    assert_string_equal(command, "printf %s ./-rf");
    free(command);
    command = printed_on(stdout, print_advice, "-r f");
    assert_string_equal(command, "printf %s './-r f'");
    free(command);
}

TEST(one_is_singular) {
    assert_string_equal(vw_plural(1), "");
    assert_string_equal(vw_plural(0), "s");
}

TEST(a_shared_folder_is_whole) {
    assert_int_equal(vw_text_shared_folder("images/01.jpg", 13, "images/02.jpg"), 7);
    assert_int_equal(vw_text_shared_folder("images/01.jpg", 7, "images2/01.jpg"), 0);
    assert_int_equal(vw_text_shared_folder("a/b/1", 5, "a/b"), 2);
    assert_int_equal(vw_text_shared_folder("1", 1, "1"), 0);
}

// ---- Photos in their order ----

static void print_ranking(const void *context) { vw_ranking_print(context, "high", "low"); }

// Few validation photos tell no ranks, and the program says why.
TEST(ranks_need_four_validation_photos) {
    struct vw_ledger_image images[8];
    const struct vw_ledger_score scores[] = {{.image_id = 1,
                                              .method = "worth_psnr",
                                              .value = 2.34567,
                                              .unit = "dB",
                                              .ci_low = NAN,
                                              .ci_high = NAN,
                                              .rank_ci_low = 1,
                                              .rank_ci_high = 1},
                                             {.image_id = 0,
                                              .method = "worth_psnr",
                                              .value = 1,
                                              .unit = "dB",
                                              .ci_low = NAN,
                                              .ci_high = NAN,
                                              .rank_ci_low = 2,
                                              .rank_ci_high = 2}};
    char names[8][16];
    for (uint32_t i = 0; i < 8; i++) {
        snprintf(names[i], sizeof names[i], "images/%u.jpg", i);
        images[i] = (struct vw_ledger_image){.image_id = i,
                                             .name = names[i],
                                             .split = i < 2   ? "train"
                                                      : i < 5 ? "val"
                                                              : "test"};
    }
    const struct vw_ranking ranking = {.scores = scores, .count = 2, .images = images, .image_count = 8};
    AUTO_FREE char *few = printed_on(stdout, print_ranking, &ranking);
    assert_non_null(strstr(few, "+2.35 dB  1.jpg\n"));
    assert_non_null(
        strstr(few, "\nno rank intervals: 3 validation photos cannot tell how others would rank (at least 4 can)\n"));
    images[5].split = "val";
    AUTO_FREE char *enough = printed_on(stdout, print_ranking, &ranking);
    assert_non_null(strstr(enough, "+2.35 dB  rank 1-1  1.jpg\n"));
    assert_null(strstr(enough, "no rank"));
}

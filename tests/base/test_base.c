// Hashes, files, and where log messages go.
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include "base/hash.h"
#include "base/text.h"
#include "support/cmocka_test.h"
#include "support/ledger_fixture.h"
#include "viewworth/log.h"

static void assert_hex(const uint8_t hash[VW_HASH_BYTES], const char *expected) {
    char hex[VW_HASH_HEX_BYTES];
    vw_hash_to_hex(hash, hex);
    assert_string_equal(hex, expected);
}

TEST(sha256_matches_the_published_vector) {
    const char *expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"; // FIPS 180-2, "abc"
    uint8_t hash[VW_HASH_BYTES];
    vw_sha256("abc", 3, hash);
    assert_hex(hash, expected);
}

TEST(hasher_writes_tag_length_and_little_endian) {
    const uint8_t bytes[] = {'t', 2,    0,    0,    0,    0,    0,    0,    0,    'h', 'i', // text "hi"
                             'i', 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,           // integer -2
                             'r', 0,    0,    0,    0,    0,    0,    0xf8, 0x3f,           // real 1.5
                             'n',                                                           // null
                             'b', 1,    0,    0,    0,    0,    0,    0,    0,    7};       // bytes {7}
    uint8_t expected[VW_HASH_BYTES], hash[VW_HASH_BYTES];
    crypto_generichash(expected, sizeof expected, bytes, sizeof bytes, NULL, 0);
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "hi");
    vw_hasher_add_integer(&hasher, -2);
    vw_hasher_add_real(&hasher, 1.5);
    vw_hasher_add_null(&hasher);
    vw_hasher_add_bytes(&hasher, "\7", 1);
    vw_hasher_end(&hasher, hash);
    assert_memory_equal(hash, expected, sizeof hash);
}

static void add_sequence(struct vw_hasher *hasher, int sequence) {
    switch (sequence) {
    case 0: break;
    case 1: vw_hasher_add_null(hasher); break;
    case 2: vw_hasher_add_text(hasher, ""); break;
    case 3: vw_hasher_add_integer(hasher, 0); break;
    case 4: vw_hasher_add_real(hasher, 0.0); break;
    case 5: vw_hasher_add_real(hasher, -0.0); break;
    case 6: vw_hasher_add_bytes(hasher, "", 0); break;
    case 7: vw_hasher_add_text(hasher, "ab"), vw_hasher_add_text(hasher, "c"); break;
    case 8: vw_hasher_add_text(hasher, "a"), vw_hasher_add_text(hasher, "bc"); break;
    case 9: vw_hasher_add_text(hasher, "abc"); break;
    case 10: vw_hasher_add_bytes(hasher, "abc", 3); break;
    default: vw_hasher_add_integer(hasher, 0), vw_hasher_add_integer(hasher, 0); break;
    }
}

TEST(different_sequences_hash_differently) {
    enum { SEQUENCES = 12 };
    uint8_t hashes[SEQUENCES][VW_HASH_BYTES];
    for (int i = 0; i < SEQUENCES; i++) {
        struct vw_hasher hasher;
        vw_hasher_begin(&hasher);
        add_sequence(&hasher, i);
        vw_hasher_end(&hasher, hashes[i]);
        for (int j = 0; j < i; j++)
            if (memcmp(hashes[i], hashes[j], 32) == 0) fail_msg("sequences %d and %d of add_sequence hash alike", j, i);
    }
    struct vw_hasher hasher;
    uint8_t of_null[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, NULL);
    vw_hasher_end(&hasher, of_null);
    assert_memory_equal(of_null, hashes[1], 32);
}

FOLDER_TEST(a_file_reads_back_with_a_zero_after_it) {
    AUTO_FREE char *path = vw_path_join(*state, "large");
    size_t size_bytes = 100003, read_bytes = 0;
    AUTO_FREE char *text = malloc(size_bytes);
    for (size_t i = 0; i < size_bytes; i++) text[i] = (char)(i * 7 + i / 251);
    ASSERT_OK(vw_file_write(path, text, size_bytes));
    void *data = NULL;
    ASSERT_OK(vw_file_read(path, size_bytes, &data, &read_bytes));
    assert_int_equal(read_bytes, size_bytes);
    assert_memory_equal(data, text, size_bytes);
    assert_int_equal(((char *)data)[size_bytes], 0);
    free(data);
    data = text;
    assert_int_equal(vw_file_read(path, size_bytes - 1, &data, &read_bytes), VW_ERROR_INPUT);
    assert_ptr_equal(data, text); // untouched on failure
    assert_int_equal(vw_file_read(*state, 100, &data, &read_bytes), VW_ERROR_INPUT);
}

FOLDER_TEST(an_empty_file_is_fine) {
    AUTO_FREE char *path = vw_path_join(*state, "empty");
    AUTO_FREE void *data = NULL;
    size_t size_bytes = 9;
    ASSERT_OK(vw_file_write(path, "", 0));
    ASSERT_OK(vw_file_read(path, 0, &data, &size_bytes));
    assert_int_equal(size_bytes, 0);
    assert_string_equal(data, "");
}

static int count_entries(const char *folder) {
    DIR *listing = opendir(folder);
    assert_non_null(listing);
    int count = -2; // "." and ".."
    while (readdir(listing)) count++;
    closedir(listing);
    return count;
}

FOLDER_TEST(a_write_replaces_whole_or_leaves_the_old) {
    AUTO_FREE char *path = vw_path_join(*state, "file");
    ASSERT_OK(vw_file_write(path, "old", 3));
    int reader = open(path, O_RDONLY); // one who reads the old file goes on reading it
    ASSERT_OK(vw_file_write(path, "new text", 8));
    char seen[16] = "";
    assert_int_equal(read(reader, seen, sizeof seen), 3);
    assert_string_equal(seen, "old");
    close(reader);
    AUTO_FREE void *data = temporary_read(path, NULL);
    assert_string_equal(data, "new text");
    assert_int_equal(count_entries(*state), 1); // no temporary file stays

    AUTO_FREE char *taken = vw_path_join(*state, "file/below");
    ASSERT_FAILS(vw_file_write(taken, "x", 1), VW_ERROR_IO, taken);
    unlink(path);
    assert_int_equal(mkdir(path, 0777), 0); // a folder in the way: the rename fails after the write
    assert_int_equal(vw_file_write(path, "x", 1), VW_ERROR_IO);
    assert_int_equal(count_entries(*state), 1);
}

// Stands in for that of the C library, to make the next temporary name one that an attacker has guessed.
static bool guessed;

int getentropy(void *buffer, size_t size_bytes) {
    if (guessed) memset(buffer, 0, size_bytes);
    else if (syscall(SYS_getrandom, buffer, size_bytes, 0) != (long)size_bytes) return -1;
    return 0;
}

FOLDER_TEST(a_hostile_link_is_replaced_and_not_followed) {
    const char *victim = temporary_file(*state, "victim", "precious"), *path = temporary_path(*state, "file");
    const char *guess = temporary_path(*state, ".viewworth-00000000000000000000000000000000.part");
    assert_int_equal(symlink(victim, path), 0);
    assert_int_equal(symlink(victim, guess), 0);
    guessed = true;
    assert_int_equal(vw_file_write(path, "new", 3), VW_ERROR_IO);
    guessed = false;
    ASSERT_OK(vw_file_write(path, "new", 3));
    AUTO_FREE void *data = temporary_read(victim, NULL);
    assert_string_equal(data, "precious");
    struct stat info;
    assert_int_equal(lstat(path, &info), 0);
    assert_true(S_ISREG(info.st_mode));
}

// Stands in for that of the C library, to refuse like a file system that cannot rename without replacing.
static bool refuse_to_keep;

int renameat2(int old_folder, const char *old_name, int new_folder, const char *new_name, unsigned flags) {
    errno = EINVAL;
    if (refuse_to_keep) return -1;
    return (int)syscall(SYS_renameat2, old_folder, old_name, new_folder, new_name, flags);
}

static void check_created_file(const char *folder) {
    AUTO_FREE char *path = vw_path_join(folder, "file");
    ASSERT_OK(vw_file_create(path, "first", 5));
    ASSERT_FAILS(vw_file_create(path, "second", 6), VW_ERROR_USAGE, path);
    AUTO_FREE void *data = temporary_read(path, NULL);
    assert_string_equal(data, "first");
    unlink(path);
    assert_int_equal(symlink("nowhere", path), 0);
    assert_int_equal(vw_file_create(path, "x", 1), VW_ERROR_USAGE);
    assert_int_equal(count_entries(folder), 1);
}

FOLDER_TEST(a_created_file_replaces_nothing) { check_created_file(*state); }

FOLDER_TEST(a_file_system_without_such_renames_links) {
    refuse_to_keep = true;
    check_created_file(*state);
    refuse_to_keep = false;
}

FOLDER_TEST(leftovers_of_killed_writers_go_and_all_else_stays) {
    static const char *const names[] = {".viewworth-0123456789abcdef0123456789abcdef.part", // ours
                                        ".viewworth-0123456789abcdef0123456789abcdef.part2",
                                        ".viewworth-0123456789abcdef0123456789abcde.part",
                                        ".viewworth-0123456789abcdef0123456789abcdeg.part", "scores.csv"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) temporary_file(*state, names[i], "x");
    vw_folder_remove_leftovers(*state);
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++)
        assert_int_equal(vw_file_exists(temporary_path(*state, names[i])), i > 0);
}

TEST(messages_are_one_line) {
    assert_int_equal(vw_fail(VW_ERROR_INPUT, "%s: wrong", "a\nb\x1b[2J\x7f\xc3\xa4"), VW_ERROR_INPUT);
    assert_string_equal(vw_error_message(), "a?b?[2J?\xc3\xa4: wrong"); // UTF-8 stays
    vw_fail_context(VW_ERROR_INPUT, "frame\r\n1");
    assert_string_equal(vw_error_message(), "frame??1: a?b?[2J?\xc3\xa4: wrong");
}

FOLDER_TEST(pipes_and_folders_are_no_files) {
    const char *folder = *state;
    assert_true(vw_file_exists(temporary_file(folder, "file", "")));
    assert_false(vw_file_exists(folder));
    assert_int_equal(mkfifo(temporary_path(folder, "pipe"), 0666), 0);
    assert_false(vw_file_exists(temporary_path(folder, "pipe")));
    assert_false(vw_file_exists("/dev/null"));
    void *data = NULL;
    size_t size_bytes;
    alarm(20); // instead of waiting for ever
    assert_int_equal(vw_file_read(temporary_path(folder, "pipe"), 100, &data, &size_bytes), VW_ERROR_INPUT);
    assert_int_equal(vw_file_read("/dev/zero", 100, &data, &size_bytes), VW_ERROR_INPUT);
    alarm(0);
}

FOLDER_TEST(folders_and_names) {
    AUTO_FREE char *deep = vw_path_join(*state, "a/b//c/");
    assert_false(vw_folder_exists(deep));
    ASSERT_OK(vw_folder_create(deep));
    assert_true(vw_folder_exists(deep));
    assert_false(vw_file_exists(deep));
    ASSERT_OK(vw_folder_create(deep));
    AUTO_FREE char *file = vw_path_join(deep, "file");
    ASSERT_OK(vw_file_write(file, "", 0));
    assert_true(vw_file_exists(file));
    assert_false(vw_folder_exists(file));
    AUTO_FREE char *below = vw_path_join(file, "d");
    assert_int_equal(vw_folder_create(below), VW_ERROR_IO);

    const struct {
        const char *folder, *name, *joined;
    } joins[] = {{"a", "b", "a/b"}, {"a/", "b", "a/b"}, {"", "b", "b"}, {"a", "/b", "/b"}, {"/", "b", "/b"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(joins); i++) {
        AUTO_FREE char *joined = vw_path_join(joins[i].folder, joins[i].name);
        assert_string_equal(joined, joins[i].joined);
    }
    const char *folders[][2] = {{"a/b.c", "a"}, {"b.c", "."}, {"/b", "/"}, {"/a/b", "/a"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(folders); i++) {
        AUTO_FREE char *folder = vw_path_folder(folders[i][0]);
        assert_string_equal(folder, folders[i][1]);
    }
}

static void take_line(void *context, enum vw_log_level level, const char *line) {
    char *text = context;
    snprintf(text + strlen(text), 3000 - strlen(text), "%d %s\n", level, line);
}

TEST(messages_go_to_the_sink) {
    char text[3000] = "", expected[3000], name[1500] = "";
    vw_log_info("nobody hears %d", 0); // the library is silent by default
    vw_log_set_sink(take_line, text);
    vw_log_info("told %d", 1);
    vw_log_warning("warned %d", 2);
    memset(name, 'x', sizeof name - 1);
    vw_log_info("long %s", name);
    vw_log_set_sink(NULL, NULL);
    vw_log_warning("nobody hears");
    snprintf(expected, sizeof expected, "%d told 1\n%d warned 2\n%d long %s\n", VW_LOG_INFO, VW_LOG_WARNING,
             VW_LOG_INFO, name);
    assert_string_equal(text, expected);
}

TEST(durations_are_for_people) {
    static const struct {
        double seconds;
        const char *text;
    } cases[] = {{0.04, "0 s"},  {7.25, "7.2 s"},  {9.96, "10 s"},  {45, "45 s"},    {99, "99 s"},
                 {180, "3 min"}, {5400, "90 min"}, {9000, "2.5 h"}, {36000, "10 h"}, {1e6, "278 h"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        char text[VW_DURATION_BYTES];
        vw_text_duration(cases[i].seconds, text);
        assert_string_equal(text, cases[i].text);
    }
    char about[VW_ABOUT_BYTES];
    vw_text_about(45, about);
    assert_string_equal(about, ", about 45 s");
    vw_text_about(NAN, about);
    assert_string_equal(about, "");
}

// ---- Lists of words ------------------------------------------------------------------------------------------------

// Lists of words with commas between.
TEST(words_come_in_order) {
    const char *rest = "rays,val-rays,,+sky";
    static const char *const expected[] = {"rays", "val-rays", "", "+sky"};
    struct vw_word word;
    for (size_t i = 0; i < 4; i++) {
        assert_true(vw_word_list_next(&rest, &word));
        assert_true(vw_word_is(word, expected[i]));
    }
    assert_false(vw_word_list_next(&rest, &word));
    assert_null(rest);
}

TEST(an_empty_list_and_a_last_comma_give_an_empty_word) {
    const char *empty = "", *ended = "a,";
    struct vw_word word;
    assert_true(vw_word_list_next(&empty, &word) && word.length == 0);
    assert_false(vw_word_list_next(&empty, &word));
    assert_true(vw_word_list_next(&ended, &word) && vw_word_is(word, "a"));
    assert_true(vw_word_list_next(&ended, &word) && word.length == 0);
    assert_false(vw_word_list_next(&ended, &word));
}

TEST(a_word_is_found_whole) {
    assert_true(vw_word_list_has("rays,val-rays", "rays"));
    assert_true(vw_word_list_has("samples,val-rays", "val-rays"));
    assert_false(vw_word_list_has("val-rays", "rays"));
    assert_false(vw_word_list_has("rays", "val-rays"));
    assert_false(vw_word_list_has("rays", "ray"));
    assert_false(vw_word_list_has(NULL, "rays"));
}

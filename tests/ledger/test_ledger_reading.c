// Reading changes nothing: not the ledger, not its folder, also when it fails; beside a process that appends, after one
// that was killed, and where nothing can be written.
#include "support/ledger_sql.h"

#include <dirent.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

// ---- A folder: its names, and the bytes and times of its files -----------------------------------------------------

struct vw_snapshot {
    char *text;
    size_t size_bytes;
};

static int is_name(const struct dirent *entry) { return entry->d_name[0] != '.' || strlen(entry->d_name) > 2; }

static struct vw_snapshot look_at(const char *folder) {
    struct vw_snapshot snapshot = {0};
    FILE *stream = open_memstream(&snapshot.text, &snapshot.size_bytes);
    struct dirent **entries = NULL;
    int count = scandir(folder, &entries, is_name, alphasort);
    assert_true(stream && count >= 0);
    for (int i = 0; i < count; i++) {
        AUTO_FREE char *path = vw_path_join(folder, entries[i]->d_name);
        size_t size_bytes = 0;
        struct stat info;
        assert_int_equal(stat(path, &info), 0);
        AUTO_FREE void *bytes = temporary_read(path, &size_bytes);
        fprintf(stream, "%s %ld.%ld %zu\n", entries[i]->d_name, (long)info.st_mtim.tv_sec, info.st_mtim.tv_nsec,
                size_bytes);
        fwrite(bytes, 1, size_bytes, stream);
        free(entries[i]);
    }
    free(entries);
    assert_int_equal(fclose(stream), 0);
    test_own(snapshot.text, free);
    return snapshot;
}

static void assert_unchanged(const char *folder, struct vw_snapshot before) {
    struct vw_snapshot after = look_at(folder);
    assert_int_equal(after.size_bytes, before.size_bytes);
    assert_memory_equal(after.text, before.text, before.size_bytes);
}

// ---- Reading -------------------------------------------------------------------------------------------------------

FOLDER_TEST(reading_changes_nothing) {
    uint64_t step_count = 0;
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    struct vw_snapshot before = look_at(*state);
    ASSERT_OK(test_ledger_read(path, &step_count));
    assert_unchanged(*state, before);
    sql_change(path, "UPDATE step SET val_psnr = val_psnr + 1 WHERE step = 3");
    before = look_at(*state);
    assert_int_equal(test_ledger_read(path, &step_count), VW_ERROR_MISMATCH);
    assert_unchanged(*state, before);
    sql_run(path, "CREATE INDEX extra ON score (method)");
    before = look_at(*state);
    assert_int_equal(test_ledger_read(path, &step_count), VW_ERROR_INPUT);
    assert_unchanged(*state, before);
}

// A reader's handle cannot write at all, whatever it is asked to do.
FOLDER_TEST(a_reader_cannot_write) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    struct vw_snapshot before = look_at(*state);
    struct vw_ledger *ledger = test_ledger_open(path);
    assert_int_equal(vw_ledger_finish(ledger, "failed", "2026-11-21T04:00:00Z", NULL, 0), VW_ERROR_IO);
    assert_int_equal(sqlite3_exec(ledger->database.handle, "DELETE FROM step", NULL, NULL, NULL), SQLITE_READONLY);
    vw_ledger_close(&ledger);
    assert_unchanged(*state, before);
}

FOLDER_TEST(a_folder_without_rights_is_read) {
    uint64_t step_count = 0;
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    assert_int_equal(chmod(path, 0400), 0);
    assert_int_equal(chmod(*state, 0500), 0);
    ASSERT_OK(test_ledger_read(path, &step_count));
    assert_int_equal(step_count, 1 + 4 * TEST_TRAIN_COUNT);
    assert_int_equal(chmod(*state, 0700), 0);
}

// ---- Beside a writer -----------------------------------------------------------------------------------------------

static void append_step_by_step(const char *path) {
    struct test_trainer longer = test_four_epochs;
    longer.epochs = TEST_EPOCHS_MOST;
    struct test_recording *recording = test_record(&longer);
    struct vw_ledger *ledger = NULL;
    if (vw_ledger_open_to_append(path, &ledger)) _exit(1);
    for (uint32_t i = 0; i < recording->count; i++)
        if (vw_ledger_append(ledger, &recording->records[i], 1, test_validation_views)) _exit(2);
    if (vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", NULL, 0)) _exit(3);
    _exit(0);
}

FOLDER_TEST(a_growing_ledger_is_read_without_harm) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = test_ledger_create(path);
    vw_ledger_close(&ledger);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) append_step_by_step(path);
    int result = 0;
    uint32_t reads = 0;
    uint64_t step_count = 0, before = 0;
    while (waitpid(child, &result, WNOHANG) == 0) {
        ASSERT_OK(test_ledger_read(path, &step_count));
        assert_true(step_count >= before);
        before = step_count;
        reads++;
    }
    assert_true(WIFEXITED(result) && WEXITSTATUS(result) == 0);
    ASSERT_OK(test_ledger_read(path, &step_count));
    assert_int_equal(step_count, TEST_RECORDS_MOST);
    print_message("%u reads while %u steps were appended\n", reads, TEST_RECORDS_MOST);
}

// ---- After a kill --------------------------------------------------------------------------------------------------

static void die_in_a_transaction(const char *path) {
    struct vw_ledger *ledger = NULL;
    if (vw_ledger_open_to_append(path, &ledger)) _exit(1);
    const char *sql = "PRAGMA cache_spill = 1; PRAGMA cache_size = 1; BEGIN IMMEDIATE;"
                      "UPDATE step SET val_psnr = 99; UPDATE image SET name = name || printf('%0100000d', 0);";
    if (sqlite3_exec(ledger->database.handle, sql, NULL, NULL, NULL) != SQLITE_OK) _exit(2);
    raise(SIGKILL);
}

// A reader is told what to do and leaves the files as they are; a writer puts them right.
FOLDER_TEST(after_a_kill_only_who_appends_repairs) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    AUTO_FREE char *journal = vw_path_join(*state, "ledger.db-journal");
    struct vw_ledger *ledger = NULL;
    uint64_t step_count = 0;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        die_in_a_transaction(path);
        _exit(3);
    }
    int result = 0;
    assert_int_equal(waitpid(child, &result, 0), child);
    assert_true(WIFSIGNALED(result) && vw_file_exists(journal)); // or this test shows nothing
    struct vw_snapshot before = look_at(*state);
    ASSERT_FAILS(vw_ledger_open(path, &ledger), VW_ERROR_INPUT, path, "--resume");
    assert_unchanged(*state, before);
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    vw_ledger_close(&ledger);
    assert_false(vw_file_exists(journal));
    ASSERT_OK(test_ledger_read(path, &step_count));
    assert_int_equal(step_count, 1 + 4 * TEST_TRAIN_COUNT);
}

// The weights of validation photos are texts in the run row.
FOLDER_TEST(weights_of_photos_are_read_or_refused) {
    static const struct {
        const char *options_json;
        enum vw_status status;
    } cases[] = {{"{\"weights\":{\"images/4.png\":3.0}}", VW_OK},
                 {"{\"weights\":{\"images/1.png\":3.0}}", VW_ERROR_INPUT}, // a photo to train on
                 {"{\"weights\":[]}", VW_ERROR_INPUT},
                 {"{\"weights\":{\"images/4.png\":\"3\"}}", VW_ERROR_INPUT},
                 {"{\"weights\":{\"gone.png\":3.0}}", VW_ERROR_INPUT},
                 {"{\"weights\":{\"images/4.png\":-1}}", VW_ERROR_INPUT}};
    AUTO_FREE char *path = vw_path_join(*state, "weighted.db");
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_ledger_run run = test_run("{}");
        struct vw_ledger *ledger = NULL;
        const struct vw_ledger_image *images = NULL;
        uint32_t count = 0;
        unlink(path);
        run.scene_options_json = cases[i].options_json;
        ASSERT_OK(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger));
        assert_int_equal(vw_ledger_get_images(ledger, &images, &count), cases[i].status);
        if (!cases[i].status) assert_true(vw_ledger_find_image(images, count, 4)->weight == 3);
        vw_ledger_close(&ledger);
    }
}

// A reader reads what it checked, even if another program changes the file without a lock of SQLite.
FOLDER_TEST(an_exchanged_file_changes_nothing_that_was_opened) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 1 + 4 * TEST_TRAIN_COUNT);
    AUTO_FREE struct vw_step_record *records = NULL;
    uint64_t count = 0;
    char zeros[512] = {0};
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(path);
    FILE *file = fopen(path, "r+");
    assert_non_null(file);
    while (ftell(file) < 1 << 16) assert_int_equal(fwrite(zeros, 1, sizeof zeros, file), sizeof zeros);
    assert_int_equal(fclose(file), 0);
    ASSERT_OK(vw_ledger_verify(ledger));
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &count));
    assert_int_equal(count, 1 + 4 * TEST_TRAIN_COUNT);
}

// Files that another program left beside a ledger or store: a journal that would make SQLite delete a file is refused
// before SQLite sees it, and so are links and the files of another journal mode. Journals that a
// killed process leaves are rolled back: see test_ledger_reading.c and test_ledger_power_cut.c.
#include "support/ledger_sql.h"

#include <sys/stat.h>

#include "ledger/retraining.h"

enum { PAGE_BYTES = 4096, SECTOR_BYTES = 512, JOURNAL_BYTES_MOST = 4 * PAGE_BYTES };

struct journal {
    unsigned char bytes[JOURNAL_BYTES_MOST];
    size_t size_bytes;
};

static void put(struct journal *journal, const void *bytes, size_t size_bytes) {
    assert_true(journal->size_bytes + size_bytes <= JOURNAL_BYTES_MOST);
    memcpy(journal->bytes + journal->size_bytes, bytes, size_bytes);
    journal->size_bytes += size_bytes;
}

static void put_u32(struct journal *journal, uint32_t value) {
    const unsigned char bytes[] = {(unsigned char)(value >> 24), (unsigned char)(value >> 16),
                                   (unsigned char)(value >> 8), (unsigned char)value};
    put(journal, bytes, sizeof bytes);
}

static const unsigned char magic[] = {0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};

static void put_header(struct journal *journal, uint32_t pages, uint32_t sector_bytes, uint32_t page_bytes) {
    put(journal, magic, sizeof magic);
    put_u32(journal, 0); // records
    put_u32(journal, 0); // nonce
    put_u32(journal, pages);
    put_u32(journal, sector_bytes);
    put_u32(journal, page_bytes);
    journal->size_bytes = SECTOR_BYTES;
}

// Adds the end of a transaction over several files: SQLite deletes the file of that name when it has rolled back.
static void put_name(struct journal *journal, const char *name) {
    uint32_t sum = 0;
    for (const char *at = name; *at; at++) sum += (unsigned char)*at;
    put_u32(journal, 0x40000000 / PAGE_BYTES + 1);
    put(journal, name, strlen(name));
    put_u32(journal, (uint32_t)strlen(name));
    put_u32(journal, sum);
    put(journal, magic, sizeof magic);
}

struct place {
    const char *folder, *path, *journal_path, *victim_path;
    struct kept_file ledger;
};

static struct place make_place(const char *folder) {
    const char *out = temporary_path(folder, "out");
    ASSERT_OK(vw_folder_create(out));
    AUTO_FREE char *path = test_ledger_record(out, "ledger.db", &test_four_epochs, 6);
    return (struct place){out, temporary_path(out, "ledger.db"), temporary_path(out, "ledger.db-journal"),
                          temporary_file(folder, "victim.txt", "my thesis"), temporary_keep(path)};
}

static void assert_same_file(const char *path, const void *bytes, size_t size_bytes) {
    size_t now_bytes = 0;
    AUTO_FREE void *now = temporary_read(path, &now_bytes);
    assert_int_equal(now_bytes, size_bytes);
    assert_memory_equal(now, bytes, size_bytes);
}

// Checks that neither a reader nor a writer changes anything, and that the writer is told which file to remove.
static void assert_harmless(const struct place *place, const char *what) {
    struct vw_ledger *ledger = NULL;
    (void)vw_ledger_open(place->path, &ledger);
    vw_ledger_close(&ledger);
    ASSERT_CASE_FAILS(what, vw_ledger_open_to_append(place->path, &ledger), VW_ERROR_INPUT, place->path, "remove");
    assert_same_file(place->victim_path, "my thesis", 9);
    assert_same_file(place->path, place->ledger.bytes, place->ledger.size_bytes);
}

FOLDER_TEST(a_journal_that_names_a_file_deletes_nothing) {
    struct place place = make_place(*state);
    struct journal whole = {.size_bytes = 0}, end_only = {.size_bytes = 0};
    put_header(&whole, (uint32_t)(place.ledger.size_bytes / PAGE_BYTES), SECTOR_BYTES, PAGE_BYTES);
    put_name(&whole, place.victim_path);
    ASSERT_OK(vw_file_write(place.journal_path, whole.bytes, whole.size_bytes));
    assert_harmless(&place, "journal that names a file");
    put_name(&end_only, place.victim_path);
    end_only.bytes[0] = 'x'; // or SQLite takes it for an ended one
    ASSERT_OK(vw_file_write(place.journal_path, end_only.bytes, end_only.size_bytes));
    assert_harmless(&place, "name without a header");
}

FOLDER_TEST(a_journal_that_is_not_a_plain_file_is_refused) {
    struct place place = make_place(*state);
    assert_int_equal(symlink(place.victim_path, place.journal_path), 0);
    assert_harmless(&place, "link");
    unlink(place.journal_path);
    assert_int_equal(symlink("nowhere", place.journal_path), 0);
    assert_harmless(&place, "link to nowhere");
    unlink(place.journal_path);
    assert_int_equal(mkfifo(place.journal_path, 0600), 0);
    assert_harmless(&place, "pipe");
    unlink(place.journal_path);
    struct vw_ledger *ledger = test_ledger_open_to_append(place.path);
    vw_ledger_close(&ledger);
}

FOLDER_TEST(a_write_ahead_log_beside_is_refused) {
    static const char *const names[] = {"ledger.db-wal", "ledger.db-shm"};
    struct place place = make_place(*state);
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        AUTO_FREE char *path = vw_path_join(place.folder, names[i]);
        struct vw_ledger *ledger = NULL;
        ASSERT_OK(vw_file_write(path, "x", 1));
        assert_harmless(&place, names[i]);
        ASSERT_FAILS(vw_ledger_open(place.path, &ledger), VW_ERROR_INPUT, path);
        assert_same_file(path, "x", 1);
        unlink(path);
    }
}

FOLDER_TEST(a_linked_ledger_is_refused) {
    struct place place = make_place(*state);
    AUTO_FREE char *link_path = vw_path_join(*state, "link.db");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(symlink(place.path, link_path), 0);
    assert_int_equal(vw_ledger_open(link_path, &ledger), VW_ERROR_INPUT);
    ASSERT_FAILS(vw_ledger_open_to_append(link_path, &ledger), VW_ERROR_INPUT, "is a link");
}

// SQLite takes such a name as a URI, which may name another file and how it is opened.
FOLDER_TEST(the_name_of_a_folder_is_no_uri) {
    AUTO_FREE char *before = getcwd(NULL, 0);
    assert_int_equal(chdir(*state), 0);
    ASSERT_OK(vw_folder_create("file:x?mode=memory&y="));
    AUTO_FREE char *path = test_ledger_record("file:x?mode=memory&y=", "ledger.db", &test_four_epochs, 6);
    struct vw_ledger *ledger = NULL;
    assert_true(vw_file_exists("file:x?mode=memory&y=/ledger.db"));
    ASSERT_OK(vw_ledger_open(path, &ledger));
    assert_int_equal(vw_ledger_next_step(ledger), 1 + 4 * TEST_TRAIN_COUNT);
    vw_ledger_close(&ledger);
    assert_int_equal(chdir(before), 0);
}

// Files under names that a creation might use are neither followed nor changed.
FOLDER_TEST(a_new_ledger_follows_no_link) {
    static const char *const endings[] = {"", "-journal", "-wal", "-shm"};
    struct vw_ledger_run run = test_run("{}");
    AUTO_FREE char *folder = vw_path_join(*state, "hostile"), *victim = vw_path_join(*state, "victim.txt");
    ASSERT_OK(vw_folder_create(folder));
    for (size_t i = 0; i < VW_ARRAY_COUNT(endings); i++) {
        struct vw_ledger *ledger = NULL;
        AUTO_FREE char *link_path = vw_format_text("%s/ledger.db%s", folder, endings[i]);
        AUTO_FREE char *path = vw_path_join(folder, "ledger.db");
        assert_int_equal(symlink(victim, link_path), 0);
        ASSERT_FAILS(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger),
                     i ? VW_ERROR_INPUT : VW_ERROR_USAGE, link_path);
        assert_null(ledger);
        assert_false(vw_file_exists(victim));
        unlink(link_path);
    }
}

FOLDER_TEST(a_journal_beside_a_store_deletes_nothing) {
    AUTO_FREE char *victim = vw_path_join(*state, "victim.txt"), *path = vw_path_join(*state, "retrainings.db"),
                   *journal_path = vw_path_join(*state, "retrainings.db-journal");
    struct vw_retraining_store *retrainings = NULL;
    struct journal journal = {.size_bytes = 0};
    ASSERT_OK(vw_file_write(victim, "my thesis", 9));
    ASSERT_OK(vw_retraining_store_open(path, &retrainings));
    vw_retraining_store_close(&retrainings);
    put_header(&journal, 1, SECTOR_BYTES, PAGE_BYTES);
    put_name(&journal, victim);
    ASSERT_OK(vw_file_write(journal_path, journal.bytes, journal.size_bytes));
    assert_int_equal(vw_retraining_store_open(path, &retrainings), VW_ERROR_INPUT);
    assert_same_file(victim, "my thesis", 9);
    unlink(path); // now the journal is that of a removed store
    assert_int_equal(vw_retraining_store_open(path, &retrainings), VW_ERROR_INPUT);
    assert_same_file(victim, "my thesis", 9);
}

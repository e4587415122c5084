// A power cut at every moment of an append: afterwards the ledger has all of the submission or none of it, verifies,
// and goes on as if nothing had been.
//
// What a cut can leave behind. SQLite writes the old pages to the journal, syncs it, and only then writes to the
// database; once the database is synced it removes the journal, and that is the commit. What a process wrote but did
// not sync, a cut may lose:
// - A journal may end anywhere after the bytes that were synced, and may be missing altogether while none were. What
// was synced stays:
//   a journal that was used for overwriting the database cannot shrink any more, and no program could survive it if it
//   did.
// - Pages of the database that were written since its last sync may be there or not, each independently.
// A child that is killed leaves all it wrote; the parent then takes away what a cut may take.
#include "support/ledger_sql.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>

#include "ledger/ledger_private.h"

enum { FIRST_COUNT = 4, RECORD_COUNT = 1 + 4 * TEST_TRAIN_COUNT, PAGE_BYTES = 4096 };

// ---- A file system that counts what is done to the ledger, and dies when told to ------------------------------------

// Shared by parent and child.
struct observation {
    bool counting;
    uint32_t operations;        // writes, syncs, truncations and removals so far
    uint32_t dies_in;           // the operation that the child does not survive; 0: it does
    int64_t journal_bytes;      // written
    int64_t journal_kept_bytes; // the synced part of these
    bool database_unsynced;     // it was written to since its last sync
    bool removal_synced;        // the journal's removal, the commit, was synced too
    bool appended;              // vw_ledger_append said so
};
static struct observation *observed;

static sqlite3_vfs *system_vfs, watching_vfs;
static const sqlite3_io_methods *system_journal, *system_database;
static sqlite3_io_methods watching_journal, watching_database;

// Returns whether the child is to die in the operation that begins.
static bool ends_here(void) { return observed->counting && ++observed->operations == observed->dies_in; }

static void die_if(bool ends) {
    if (ends) raise(SIGKILL);
}

// Writes to the journal; half of the data of the last operation still arrives.
static int write_journal(sqlite3_file *file, const void *data, int size_bytes, sqlite3_int64 offset) {
    bool ends = ends_here();
    int written = ends ? size_bytes / 2 : size_bytes;
    int result = system_journal->xWrite(file, data, written, offset);
    if (offset + written > observed->journal_bytes) observed->journal_bytes = offset + written;
    die_if(ends);
    return result;
}

static int sync_journal(sqlite3_file *file, int flags) {
    die_if(ends_here());
    int result = system_journal->xSync(file, flags);
    observed->journal_kept_bytes = observed->journal_bytes;
    return result;
}

static int write_database(sqlite3_file *file, const void *data, int size_bytes, sqlite3_int64 offset) {
    bool ends = ends_here();
    observed->database_unsynced = true;
    int result = system_database->xWrite(file, data, ends ? size_bytes / 2 : size_bytes, offset);
    die_if(ends);
    return result;
}

static int sync_database(sqlite3_file *file, int flags) {
    die_if(ends_here());
    int result = system_database->xSync(file, flags);
    observed->database_unsynced = false;
    return result;
}

static int truncate_database(sqlite3_file *file, sqlite3_int64 size_bytes) {
    die_if(ends_here());
    observed->database_unsynced = true;
    return system_database->xTruncate(file, size_bytes);
}

static int watch_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags, int *out_flags) {
    (void)vfs;
    int result = system_vfs->xOpen(system_vfs, name, file, flags, out_flags);
    if (result == SQLITE_OK && flags & SQLITE_OPEN_MAIN_JOURNAL) {
        system_journal = file->pMethods;
        watching_journal = *system_journal;
        watching_journal.xWrite = write_journal;
        watching_journal.xSync = sync_journal;
        file->pMethods = &watching_journal;
    } else if (result == SQLITE_OK && flags & SQLITE_OPEN_MAIN_DB) {
        system_database = file->pMethods;
        watching_database = *system_database;
        watching_database.xWrite = write_database;
        watching_database.xSync = sync_database;
        watching_database.xTruncate = truncate_database;
        file->pMethods = &watching_database;
    }
    return result;
}

static int watch_delete(sqlite3_vfs *vfs, const char *name, int sync_folder) {
    (void)vfs;
    die_if(ends_here());
    observed->removal_synced = sync_folder;
    return system_vfs->xDelete(system_vfs, name, sync_folder);
}

static void watch_files(void) {
    system_vfs = sqlite3_vfs_find(NULL);
    watching_vfs = *system_vfs;
    watching_vfs.zName = "watching";
    watching_vfs.xOpen = watch_open;
    watching_vfs.xDelete = watch_delete;
    sqlite3_vfs_register(&watching_vfs, 1);
}

// ---- The cut --------------------------------------------------------------------------------------------------------

struct scene {
    const char *folder;
    struct test_recording *recording;
    const char *path, *journal_path, *chain; // the chain of a run that was never disturbed
    struct kept_file before;                 // the ledger before the append
    bool spills;                             // pages reach the database before the commit
    uint32_t cuts;
};

// Appends, in the child, the rest of the steps to a run that had ended. Ends with 0 when it was not killed.
static void append_and_die(const struct scene *scene) {
    struct vw_ledger *ledger = NULL;
    watch_files();
    if (vw_ledger_open_to_append(scene->path, &ledger)) _exit(1);
    const char *small = "PRAGMA cache_spill = 1; PRAGMA cache_size = 1";
    if (scene->spills && sqlite3_exec(ledger->database.handle, small, NULL, NULL, NULL) != SQLITE_OK) _exit(2);
    observed->counting = true;
    const struct vw_step_record *rest = &scene->recording->records[FIRST_COUNT];
    if (vw_ledger_append(ledger, rest, RECORD_COUNT - FIRST_COUNT, test_validation_views)) _exit(3);
    observed->appended = true;
    _exit(0);
}

// Restores the ledger and lets a child append to it up to an operation. Gives whether it was killed.
static bool append_in_child(const struct scene *scene, uint32_t dies_in) {
    unlink(scene->journal_path);
    temporary_put_back(&scene->before);
    *observed = (struct observation){.dies_in = dies_in};
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) append_and_die(scene);
    int result = 0;
    assert_int_equal(waitpid(child, &result, 0), child);
    if (WIFEXITED(result) && WEXITSTATUS(result) == 0) return false;
    if (!WIFSIGNALED(result) || WTERMSIG(result) != SIGKILL)
        fail_msg("operation %u: the child ended with %d", dies_in, result);
    return true;
}

// Checks that the ledger has all of the append or nothing, verifies, and is ready to go on.
static void assert_unharmed(const struct scene *scene, uint32_t operation, const char *cut) {
    struct vw_ledger_run run;
    struct vw_ledger *ledger = test_ledger_open_to_append(scene->path);
    enum vw_status status = vw_ledger_verify(ledger);
    uint64_t next = vw_ledger_next_step(ledger);
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    bool none = next == FIRST_COUNT && strcmp(run.status, "finished") == 0;
    bool all = next == RECORD_COUNT && strcmp(run.status, "running") == 0;
    if (status || !(observed->appended ? all : none))
        fail_msg("%s cache, operation %u, %s: %llu steps, %s, %s", scene->spills ? "small" : "usual", operation, cut,
                 (unsigned long long)next, run.status, status ? vw_error_message() : "verifies");
    if (none) assert_answer(scene->path, "SELECT count(*) FROM score", "3");
    ASSERT_OK(vw_ledger_append(ledger, &scene->recording->records[next], RECORD_COUNT - (uint32_t)next,
                               test_validation_views));
    ASSERT_OK(vw_ledger_verify(ledger));
    vw_ledger_close(&ledger);
    assert_answer(scene->path, SQL_CHAIN, scene->chain);
    assert_false(vw_file_exists(scene->journal_path));
}

// Puts back what the database held before, in every page (`every` 1) or every second (2).
static void lose_pages(const struct scene *scene, unsigned char *bytes, size_t size_bytes, size_t every) {
    for (size_t page = 0; page * PAGE_BYTES < size_bytes; page += every) {
        size_t first = page * PAGE_BYTES, count = size_bytes - first < PAGE_BYTES ? size_bytes - first : PAGE_BYTES;
        if (first < scene->before.size_bytes) memcpy(bytes + first, (const char *)scene->before.bytes + first, count);
        else memset(bytes + first, 0, count);
    }
}

// Tries all that a cut may leave of the files that the killed child left.
static void cut_power(struct scene *scene, uint32_t operation) {
    size_t journal_bytes = 0, left_bytes;
    AUTO_FREE void *left = temporary_read(scene->path, &left_bytes);
    AUTO_FREE void *journal =
        vw_file_exists(scene->journal_path) ? temporary_read(scene->journal_path, &journal_bytes) : NULL;
    AUTO_FREE unsigned char *database = vw_allocate(left_bytes, 1);
    int64_t kept = observed->journal_kept_bytes, written = (int64_t)journal_bytes,
            shortest = kept > 0 ? kept : -1; // -1: no journal
    const int64_t ends[] = {written, written - 1, kept + (written - kept) / 2, kept, shortest};
    for (size_t every = 0; every <= (observed->database_unsynced ? 2u : 0u); every++)
        for (size_t i = 0; i < VW_ARRAY_COUNT(ends); i++) {
            if (ends[i] < shortest || (i > 0 && ends[i] >= ends[i - 1])) continue;
            AUTO_FREE char *cut =
                vw_format_text("journal of %lld bytes cut to %lld, %zu", (long long)written, (long long)ends[i], every);
            memcpy(database, left, left_bytes);
            if (every) lose_pages(scene, database, left_bytes, every);
            temporary_write(scene->path, database, left_bytes);
            unlink(scene->journal_path);
            if (ends[i] >= 0) temporary_write(scene->journal_path, journal ? journal : "", (size_t)ends[i]);
            assert_unharmed(scene, operation, cut);
            scene->cuts++;
        }
}

static void set_scene(struct scene *scene) {
    AUTO_FREE char *whole = vw_path_join(scene->folder, "whole.db");
    scene->recording = test_own(test_record(&test_four_epochs), free);
    test_corruption(scene->recording);
    scene->path = test_own(vw_path_join(scene->folder, "ledger.db"), free);
    scene->journal_path = test_own(vw_path_join(scene->folder, "ledger.db-journal"), free);
    struct vw_ledger *ledger = test_ledger_create(whole);
    ASSERT_OK(vw_ledger_append(ledger, scene->recording->records, RECORD_COUNT, test_validation_views));
    vw_ledger_close(&ledger);
    scene->chain = test_own(sql_ask(whole, SQL_CHAIN), free);
    ledger = test_ledger_create(scene->path);
    ASSERT_OK(vw_ledger_append(ledger, scene->recording->records, FIRST_COUNT, test_validation_views));
    test_ledger_finish(ledger, "finished");
    vw_ledger_close(&ledger);
    scene->before = temporary_keep(scene->path);
}

static void cut_everywhere(const char *folder, bool spills) {
    struct scene scene = {.folder = folder, .spills = spills};
    set_scene(&scene);
    assert_false(append_in_child(&scene, 0));
    assert_true(observed->appended &&
                observed->removal_synced); // a step that is reported as recorded has reached the disk
    uint32_t operations = observed->operations;
    cut_power(&scene, operations + 1);
    uint32_t stride = spills && !test_is_full() ? 3 : 1;
    for (uint32_t operation = 1 + (operations - 1) % stride; operation <= operations; operation += stride) {
        assert_true(append_in_child(&scene, operation));
        cut_power(&scene, operation);
    }
    print_message("%s cache: %u cuts in %u operations of an append\n", spills ? "small" : "usual", scene.cuts,
                  operations);
}

FOLDER_TEST(a_cut_before_the_commit_changes_nothing) { cut_everywhere(*state, false); }
FOLDER_TEST(a_cut_while_pages_spill_changes_nothing) { cut_everywhere(*state, true); }

static int share_memory(void **state) {
    (void)state;
    observed = mmap(NULL, sizeof *observed, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return observed == MAP_FAILED;
}

TEST_GROUP(share_memory, NULL)

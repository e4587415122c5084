// The writer gives the ledger that plain appends give, takes no more than it may, and tells of failures.
// wrap: vw_ledger_append
#include "support/ledger_fixture.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include "run/ledger_writer.h"

enum { SUBMISSION = 3, RECORDS_MOST = 21, PATIENCE_S = 5 };

// ---- A disk that stands still or fails when told to
// ------------------------------------------------------------------

static struct {
    pthread_mutex_t lock;
    pthread_cond_t opened;
    bool closed, waited_in_vain;
    uint32_t transactions; // begun since it was set
    uint64_t fails_at;     // the step that a failing submission begins with; 0: none
} disk = {.lock = PTHREAD_MUTEX_INITIALIZER, .opened = PTHREAD_COND_INITIALIZER};

WRAPS(vw_ledger_append);

enum vw_status __wrap_vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                       const uint32_t *validation_views) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += PATIENCE_S;
    pthread_mutex_lock(&disk.lock);
    disk.transactions++;
    while (disk.closed && !disk.waited_in_vain)
        disk.waited_in_vain = pthread_cond_timedwait(&disk.opened, &disk.lock, &until) != 0;
    bool fails = disk.fails_at && records[0].step == disk.fails_at;
    pthread_mutex_unlock(&disk.lock);
    return fails ? vw_fail(VW_ERROR_IO, "the disk is gone; get another")
                 : __real_vw_ledger_append(ledger, records, count, validation_views);
}

static void set_disk(bool closed, uint64_t fails_at) {
    pthread_mutex_lock(&disk.lock);
    assert_false(disk.waited_in_vain); // somebody waited for the disk
    disk.closed = closed;
    disk.transactions = 0;
    disk.fails_at = fails_at;
    pthread_cond_broadcast(&disk.opened);
    pthread_mutex_unlock(&disk.lock);
}

static uint32_t transactions_begun(void) {
    pthread_mutex_lock(&disk.lock);
    uint32_t count = disk.transactions;
    pthread_mutex_unlock(&disk.lock);
    return count;
}

// ---- What is written ------------------------------------------------------------------------------------------------

struct writing {
    struct test_recording *recording;
    struct vw_ledger *ledger;
    struct vw_ledger_writer *writer;
    struct vw_step_statistics statistics;
    uint32_t added;
    void *lent[RECORDS_MOST]; // by each call of add(), and void since
    uint32_t lent_count;
};

static struct writing begin(const char *folder) {
    struct writing writing = {.recording = test_record(&test_four_epochs), .statistics = vw_step_statistics_begin()};
    test_corruption(writing.recording);
    AUTO_FREE char *path = vw_path_join(folder, "written.db");
    writing.ledger = test_ledger_create(path);
    set_disk(false, 0);
    ASSERT_OK(vw_ledger_writer_create(writing.ledger, test_validation_views, &writing.statistics, &writing.writer));
    return writing;
}

// Lends the next steps for the call alone.
static enum vw_status add(struct writing *writing) {
    const struct test_recording *recording = writing->recording;
    struct test_recording *lent = vw_allocate(1, sizeof *lent);
    uint32_t count = recording->count - writing->added < SUBMISSION ? recording->count - writing->added : SUBMISSION;
    memcpy(lent, recording, sizeof *lent);
    for (uint32_t i = 0; i < recording->count; i++) {
        struct vw_step_record *record = &lent->records[i];
        if (record->views) record->views = lent->errors + (record->views - recording->errors);
    }
    for (uint32_t i = 0; i < count; i++)
        vw_step_statistics_add(&writing->statistics, &lent->records[writing->added + i]);
    assert_int_equal(vw_ledger_writer_next_step(writing->writer), writing->added);
    enum vw_status status =
        vw_ledger_writer_add(writing->writer, &lent->records[writing->added], count, &writing->statistics);
    if (!status) writing->added += count;
    memset(lent, 0x55, sizeof *lent);
    writing->lent[writing->lent_count++] = lent;
    return status;
}

static void end(struct writing *writing) {
    vw_ledger_writer_destroy(&writing->writer);
    assert_null(writing->writer);
    ASSERT_OK(vw_ledger_verify(writing->ledger));
    vw_ledger_close(&writing->ledger);
    for (uint32_t i = 0; i < writing->lent_count; i++) free(writing->lent[i]);
    free(writing->recording);
}

// Checks that the ledger is the one that appending the first `count` steps one by one gives.
static void assert_has(const struct writing *writing, const char *folder, uint32_t count) {
    char head[VW_HASH_HEX_BYTES], expected[VW_HASH_HEX_BYTES];
    AUTO_FREE char *path = vw_path_join(folder, "expected.db");
    struct vw_ledger *ledger = test_ledger_create(path);
    for (uint32_t i = 0; i < count; i++)
        ASSERT_OK(vw_ledger_append(ledger, &writing->recording->records[i], 1, test_validation_views));
    vw_ledger_chain_head(ledger, expected);
    vw_ledger_chain_head(writing->ledger, head);
    assert_string_equal(head, expected);
    vw_ledger_close(&ledger);
    remove(path);
}

// ---- Tests ----------------------------------------------------------------------------------------------------------

FOLDER_TEST(writes_the_rows_that_plain_appends_write) {
    struct writing writing = begin(*state);
    while (writing.added < writing.recording->count) ASSERT_OK(add(&writing));
    ASSERT_OK(vw_ledger_writer_drain(writing.writer));
    assert_int_equal(vw_ledger_writer_recorded(writing.writer).steps, writing.recording->count - 1);
    assert_has(&writing, *state, writing.recording->count);
    end(&writing);
}

FOLDER_TEST(what_waits_is_written_when_it_ends) {
    struct writing writing = begin(*state);
    set_disk(true, 0);
    ASSERT_OK(add(&writing));
    ASSERT_OK(add(&writing));
    set_disk(false, 0);
    vw_ledger_writer_destroy(&writing.writer);
    assert_has(&writing, *state, 2 * SUBMISSION);
    end(&writing);
}

FOLDER_TEST(what_waits_becomes_one_transaction) {
    struct writing writing = begin(*state);
    ASSERT_OK(add(&writing));
    ASSERT_OK(vw_ledger_writer_drain(writing.writer));
    set_disk(true, 0);
    ASSERT_OK(add(&writing));
    while (!transactions_begun()) usleep(100); // until the thread has taken it
    while (writing.added < writing.recording->count) ASSERT_OK(add(&writing));
    assert_int_equal(vw_ledger_writer_recorded(writing.writer).steps, SUBMISSION - 1); // the steps on disk
    set_disk(false, 0);
    ASSERT_OK(vw_ledger_writer_drain(writing.writer));
    assert_int_equal(transactions_begun(), 1); // since the disk moves again
    assert_int_equal(vw_ledger_writer_recorded(writing.writer).steps, writing.recording->count - 1);
    assert_has(&writing, *state, writing.recording->count);
    end(&writing);
}

// Adds many steps without validation.
enum { MANY = VW_LEDGER_WRITER_WAITING_MOST, ADDED_MOST = MANY + 3 };
struct adding {
    struct vw_ledger_writer *writer;
    struct vw_step_record records[ADDED_MOST];
    atomic_bool done;
    enum vw_status status;
};

static enum vw_status add_many(struct adding *adding, uint32_t first, uint32_t count) {
    const struct vw_step_statistics statistics = {.steps = first + count - 1};
    return vw_ledger_writer_add(adding->writer, &adding->records[first], count, &statistics);
}

static void *add_last(void *context) {
    struct adding *adding = context;
    adding->status = add_many(adding, 2 + MANY, 1);
    atomic_store(&adding->done, true);
    return NULL;
}

// Writes step 0. Then MANY steps wait for step 1, whose transaction stands still and may fail, while another thread
// adds one more. The result is to be freed.
static struct adding *overfill(struct writing *writing, bool fails) {
    pthread_t thread;
    struct adding *adding = vw_allocate(1, sizeof *adding);
    adding->writer = writing->writer;
    for (uint32_t i = 0; i < ADDED_MOST; i++)
        adding->records[i] = (struct vw_step_record){
            .step = i, .view = i ? 1 : (uint32_t)VW_RECORD_UNTRAINED, .train_loss = i ? 0.5 : NAN};
    ASSERT_OK(add_many(adding, 0, 1));
    ASSERT_OK(vw_ledger_writer_drain(adding->writer));
    set_disk(true, fails ? 1 : 0);
    ASSERT_OK(add_many(adding, 1, 1));
    while (!transactions_begun()) usleep(100); // until the thread has taken it
    ASSERT_OK(add_many(adding, 2, MANY));
    assert_int_equal(pthread_create(&thread, NULL, add_last, adding), 0);
    usleep(50000);
    assert_false(atomic_load(&adding->done));
    set_disk(false, fails ? 1 : 0);
    pthread_join(thread, NULL);
    return adding;
}

FOLDER_TEST(a_failure_reaches_every_later_call) {
    struct writing writing = begin(*state);
    ASSERT_OK(add(&writing));
    ASSERT_OK(vw_ledger_writer_drain(writing.writer));
    set_disk(true, SUBMISSION);
    ASSERT_OK(add(&writing)); // fails later
    ASSERT_OK(add(&writing)); // waits, and is dropped
    set_disk(false, SUBMISSION);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(vw_ledger_writer_drain(writing.writer), VW_ERROR_IO);
        assert_string_equal(vw_error_message(), "the disk is gone; get another");
        vw_fail(VW_ERROR_USAGE, "something else; do it otherwise");
        assert_int_equal(add(&writing), VW_ERROR_IO);
        assert_string_equal(vw_error_message(), "the disk is gone; get another");
    }
    assert_int_equal(vw_ledger_writer_recorded(writing.writer).steps, SUBMISSION - 1);
    assert_has(&writing, *state, SUBMISSION);
    end(&writing);
}

FOLDER_TEST(more_steps_wait_for_room) {
    struct writing writing = begin(*state);
    AUTO_FREE struct adding *adding = overfill(&writing, false);
    ASSERT_OK(adding->status);
    ASSERT_OK(vw_ledger_writer_drain(writing.writer));
    assert_int_equal(vw_ledger_next_step(writing.ledger), ADDED_MOST);
    end(&writing);
}

FOLDER_TEST(a_failure_ends_the_wait_for_room) {
    struct writing writing = begin(*state);
    AUTO_FREE struct adding *adding = overfill(&writing, true);
    assert_int_equal(adding->status, VW_ERROR_IO);
    assert_int_equal(vw_ledger_next_step(writing.ledger), 1);
    end(&writing);
}

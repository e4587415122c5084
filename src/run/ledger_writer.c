#include "run/ledger_writer.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// The steps of a transaction. What records lend is copied in their order, and linked when no more are added.
struct transaction {
    struct vw_step_record *records;
    struct vw_view_error *views;
    size_t count, view_count; // count 0: empty
    size_t record_capacity, view_capacity;
    struct vw_step_statistics statistics; // after its last step
};

struct vw_ledger_writer {
    struct vw_ledger *ledger;
    const uint32_t *validation_views;
    uint64_t next_step; // for who adds
    pthread_t thread;
    pthread_mutex_t lock; // guards all that follows
    pthread_cond_t changed;
    struct transaction waiting;
    struct transaction writing; // while it is not empty, the thread alone reads what it contains
    bool ends;
    enum vw_status status; // status of the first transaction that failed
    struct vw_saved_error error;
    struct vw_step_statistics recorded;
};

// ---- Copying -------------------------------------------------------------------------------------------------------

static enum vw_status make_room(struct transaction *to, const struct vw_step_record *records, uint32_t count) {
    size_t views = to->view_count;
    for (uint32_t i = 0; i < count; i++)
        if (records[i].views) views += records[i].view_count;
    enum vw_status status =
        vw_grow((void **)&to->records, &to->record_capacity, to->count + count, sizeof *to->records);
    return status ? status : vw_grow((void **)&to->views, &to->view_capacity, views, sizeof *to->views);
}

static enum vw_status copy(struct transaction *to, const struct vw_step_record *records, uint32_t count) {
    enum vw_status status = make_room(to, records, count);
    if (status) return status;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_step_record *record = &records[i];
        to->records[to->count++] = *record;
        if (record->views && record->view_count)
            memcpy(to->views + to->view_count, record->views, record->view_count * sizeof *to->views);
        if (record->views) to->view_count += record->view_count;
    }
    return VW_OK;
}

static void link_records(struct transaction *transaction) {
    const struct vw_view_error *views = transaction->views;
    for (size_t i = 0; i < transaction->count; i++) {
        struct vw_step_record *record = &transaction->records[i];
        if (record->views) record->views = views;
        if (record->views) views += record->view_count;
    }
}

static void clear(struct transaction *transaction) { transaction->count = transaction->view_count = 0; }

static void free_transaction(struct transaction *transaction) {
    free(transaction->records);
    free(transaction->views);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

static void lock(struct vw_ledger_writer *writer) { (void)pthread_mutex_lock(&writer->lock); }
static void unlock(struct vw_ledger_writer *writer) { (void)pthread_mutex_unlock(&writer->lock); }
static void await_change(struct vw_ledger_writer *writer) { (void)pthread_cond_wait(&writer->changed, &writer->lock); }
static void tell_change(struct vw_ledger_writer *writer) { (void)pthread_cond_broadcast(&writer->changed); }

// Ends a transaction, under the lock like all functions up to write_transactions(). Error messages are thread-local, so
// this saves the message of this thread.
static void end_transaction(struct vw_ledger_writer *writer, enum vw_status status,
                            const struct vw_step_statistics *statistics) {
    if (status) {
        writer->status = status;
        writer->error = vw_error_save();
        clear(&writer->waiting);
    } else writer->recorded = *statistics;
    clear(&writer->writing);
    tell_change(writer);
}

static void take_waiting(struct vw_ledger_writer *writer) {
    struct transaction empty = writer->writing;
    writer->writing = writer->waiting;
    writer->waiting = empty;
    link_records(&writer->writing);
    tell_change(writer);
}

static enum vw_status failure(const struct vw_ledger_writer *writer) {
    if (writer->status) vw_error_restore(&writer->error);
    return writer->status;
}

static enum vw_status await_room(struct vw_ledger_writer *writer, uint32_t count) {
    while (!writer->status && writer->waiting.count && writer->waiting.count + count > VW_LEDGER_WRITER_WAITING_MOST)
        await_change(writer);
    return failure(writer);
}

static void *write_transactions(void *context) {
    struct vw_ledger_writer *writer = context;
    const struct transaction *writing = &writer->writing;
    lock(writer);
    for (;;) {
        while (!writer->waiting.count && !writer->ends) await_change(writer);
        if (!writer->waiting.count) break;
        take_waiting(writer);
        unlock(writer);
        enum vw_status status =
            vw_ledger_append(writer->ledger, writing->records, (uint32_t)writing->count, writer->validation_views);
        lock(writer);
        end_transaction(writer, status, &writing->statistics);
    }
    unlock(writer);
    return NULL;
}

enum vw_status vw_ledger_writer_add(struct vw_ledger_writer *writer, const struct vw_step_record *records,
                                    uint32_t count, const struct vw_step_statistics *statistics) {
    if (!count) return VW_OK;
    lock(writer);
    enum vw_status status = await_room(writer, count);
    if (!status) status = copy(&writer->waiting, records, count);
    if (!status) writer->waiting.statistics = *statistics;
    tell_change(writer);
    unlock(writer);
    if (!status) writer->next_step += count;
    return status;
}

enum vw_status vw_ledger_writer_drain(struct vw_ledger_writer *writer) {
    lock(writer);
    while (writer->waiting.count || writer->writing.count) await_change(writer);
    enum vw_status status = failure(writer);
    unlock(writer);
    return status;
}

uint64_t vw_ledger_writer_next_step(const struct vw_ledger_writer *writer) { return writer->next_step; }

struct vw_step_statistics vw_ledger_writer_recorded(struct vw_ledger_writer *writer) {
    lock(writer);
    struct vw_step_statistics recorded = writer->recorded;
    unlock(writer);
    return recorded;
}

// ---- Life ----------------------------------------------------------------------------------------------------------

// Starts the thread with signals blocked: they must end the waits of the thread that runs the loop.
static bool start_thread(struct vw_ledger_writer *writer) {
    sigset_t all, before;
    sigfillset(&all);
    if (pthread_sigmask(SIG_SETMASK, &all, &before)) return false;
    bool started = !pthread_create(&writer->thread, NULL, write_transactions, writer);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

enum vw_status vw_ledger_writer_create(struct vw_ledger *ledger, const uint32_t *validation_views,
                                       const struct vw_step_statistics *recorded, struct vw_ledger_writer **writer) {
    struct vw_ledger_writer *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->ledger = ledger;
    made->validation_views = validation_views;
    made->next_step = vw_ledger_next_step(ledger);
    made->recorded = *recorded;
    made->lock = (pthread_mutex_t)PTHREAD_MUTEX_INITIALIZER;
    made->changed = (pthread_cond_t)PTHREAD_COND_INITIALIZER;
    if (start_thread(made)) {
        *writer = made;
        return VW_OK;
    }
    free(made);
    return vw_fail(VW_ERROR_MEMORY, "cannot start a thread that writes the ledger; close other programs");
}

void vw_ledger_writer_destroy(struct vw_ledger_writer **writer) {
    struct vw_ledger_writer *dying = *writer;
    if (!dying) return;
    lock(dying);
    dying->ends = true;
    tell_change(dying);
    unlock(dying);
    (void)pthread_join(dying->thread, NULL);
    (void)pthread_cond_destroy(&dying->changed);
    (void)pthread_mutex_destroy(&dying->lock);
    free_transaction(&dying->waiting);
    free_transaction(&dying->writing);
    free(dying);
    *writer = NULL;
}

#include "run/ledger_writer.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// The records of a batch with what they lend.
struct batch {
    uint32_t count; // 0: empty
    struct vw_step_record *records;
    struct vw_view_error *views;
    struct vw_probe *probes;
    size_t record_capacity, view_capacity, probe_capacity;
    struct vw_step_statistics statistics;
};

struct vw_ledger_writer {
    struct vw_ledger *ledger;
    const uint32_t *validation_views;
    uint64_t next_step; // for who adds
    bool threaded;
    pthread_t thread;
    pthread_mutex_t lock; // of all that follows, but for what a batch holds:
    pthread_cond_t changed;
    struct batch waiting; // filled by who adds while it is empty,
    struct batch writing; // read by the thread while it is not
    bool ends;
    enum vw_status status; // of the first batch that failed
    struct vw_saved_error error;
    struct vw_step_statistics recorded;
};

// ---- Copying -------------------------------------------------------------------------------------------------------

static enum vw_status make_room(struct batch *batch, const struct vw_step_record *records, uint32_t count) {
    size_t view_count = 0, probe_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        view_count += records[i].view_count;
        probe_count += records[i].probe_count;
    }
    enum vw_status status = vw_grow((void **)&batch->records, &batch->record_capacity, count, sizeof *batch->records);
    if (!status) status = vw_grow((void **)&batch->views, &batch->view_capacity, view_count, sizeof *batch->views);
    return status ? status
                  : vw_grow((void **)&batch->probes, &batch->probe_capacity, probe_count, sizeof *batch->probes);
}

static void copy(struct batch *batch, const struct vw_step_record *records, uint32_t count) {
    struct vw_view_error *views = batch->views;
    struct vw_probe *probes = batch->probes;
    for (uint32_t i = 0; i < count; i++) {
        struct vw_step_record *record = &batch->records[i];
        *record = records[i];
        if (record->views) record->views = memcpy(views, record->views, record->view_count * sizeof *views);
        if (record->probes) record->probes = memcpy(probes, record->probes, record->probe_count * sizeof *probes);
        views += record->view_count;
        probes += record->probe_count;
    }
}

static void free_batch(struct batch *batch) {
    free(batch->records);
    free(batch->views);
    free(batch->probes);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

static void lock(struct vw_ledger_writer *writer) { (void)pthread_mutex_lock(&writer->lock); }
static void unlock(struct vw_ledger_writer *writer) { (void)pthread_mutex_unlock(&writer->lock); }
static void await_change(struct vw_ledger_writer *writer) { (void)pthread_cond_wait(&writer->changed, &writer->lock); }
static void tell_change(struct vw_ledger_writer *writer) { (void)pthread_cond_broadcast(&writer->changed); }

// Under the lock. Messages of errors belong to a thread, so that this one's is kept.
static void end_batch(struct vw_ledger_writer *writer, enum vw_status status,
                      const struct vw_step_statistics *statistics) {
    if (status) {
        writer->status = status;
        writer->error = vw_error_save();
        writer->waiting.count = 0;
    } else writer->recorded = *statistics;
    writer->writing.count = 0;
    tell_change(writer);
}

static void take_waiting(struct vw_ledger_writer *writer) {
    struct batch empty = writer->writing;
    writer->writing = writer->waiting;
    writer->waiting = empty;
    tell_change(writer);
}

static void *write_batches(void *context) {
    struct vw_ledger_writer *writer = context;
    const struct batch *batch = &writer->writing;
    lock(writer);
    for (;;) {
        while (!writer->waiting.count && !writer->ends) await_change(writer);
        if (!writer->waiting.count) break;
        take_waiting(writer);
        unlock(writer);
        enum vw_status status =
            vw_ledger_append(writer->ledger, batch->records, batch->count, writer->validation_views);
        lock(writer);
        end_batch(writer, status, &batch->statistics);
    }
    unlock(writer);
    return NULL;
}

// Under the lock.
static enum vw_status failure(const struct vw_ledger_writer *writer) {
    if (writer->status) vw_error_restore(&writer->error);
    return writer->status;
}

static enum vw_status write_here(struct vw_ledger_writer *writer, const struct vw_step_record *records, uint32_t count,
                                 const struct vw_step_statistics *statistics) {
    if (writer->status) return failure(writer);
    end_batch(writer, vw_ledger_append(writer->ledger, records, count, writer->validation_views), statistics);
    return writer->status;
}

static enum vw_status await_room(struct vw_ledger_writer *writer) {
    lock(writer);
    while (writer->waiting.count && !writer->status) await_change(writer);
    enum vw_status status = failure(writer);
    unlock(writer);
    return status;
}

static enum vw_status hand_over(struct vw_ledger_writer *writer, const struct vw_step_record *records, uint32_t count,
                                const struct vw_step_statistics *statistics) {
    enum vw_status status = await_room(writer);
    if (!status) status = make_room(&writer->waiting, records, count);
    if (status) return status;
    copy(&writer->waiting, records, count);
    writer->waiting.statistics = *statistics;
    lock(writer);
    status = failure(writer); // of the batch that was written meanwhile
    if (!status) writer->waiting.count = count;
    tell_change(writer);
    unlock(writer);
    return status;
}

enum vw_status vw_ledger_writer_add(struct vw_ledger_writer *writer, const struct vw_step_record *records,
                                    uint32_t count, const struct vw_step_statistics *statistics) {
    if (!count) return VW_OK;
    enum vw_status status = writer->threaded ? hand_over(writer, records, count, statistics)
                                             : write_here(writer, records, count, statistics);
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

// Signals are for the thread that runs the loop, whose waits they end.
static bool start_thread(struct vw_ledger_writer *writer) {
    sigset_t all, before;
    sigfillset(&all);
    if (pthread_sigmask(SIG_SETMASK, &all, &before)) return false;
    bool started = !pthread_create(&writer->thread, NULL, write_batches, writer);
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
    made->threaded = start_thread(made);
    *writer = made;
    return VW_OK;
}

void vw_ledger_writer_destroy(struct vw_ledger_writer **writer) {
    struct vw_ledger_writer *dying = *writer;
    if (!dying) return;
    lock(dying);
    dying->ends = true;
    tell_change(dying);
    unlock(dying);
    if (dying->threaded) (void)pthread_join(dying->thread, NULL);
    (void)pthread_cond_destroy(&dying->changed);
    (void)pthread_mutex_destroy(&dying->lock);
    free_batch(&dying->waiting);
    free_batch(&dying->writing);
    free(dying);
    *writer = NULL;
}

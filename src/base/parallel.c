#include "base/parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { THREADS_MOST = 16 };

struct job {
    enum vw_status (*work)(void *context, uint32_t piece);
    void *context;
    uint32_t count;
    atomic_uint next;
};

// A thread and the first failure of it.
struct worker {
    struct job *job;
    pthread_t thread;
    struct vw_first_failure failure;
    uint32_t failed; // piece
};

static void *run(void *argument) {
    struct worker *worker = argument;
    struct job *job = worker->job;
    uint32_t piece;
    while (!worker->failure.status && (piece = atomic_fetch_add(&job->next, 1)) < job->count) {
        vw_first_failure_note(&worker->failure, job->work(job->context, piece));
        if (!worker->failure.status) continue;
        worker->failed = piece;
        atomic_store(&job->next, job->count); // no later piece need be begun
    }
    return NULL;
}

enum vw_status vw_parallel_for(uint32_t count, enum vw_status (*work)(void *context, uint32_t piece), void *context) {
    struct job job = {.work = work, .context = context, .count = count};
    struct worker workers[THREADS_MOST] = {{0}}, *failed = NULL;
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    uint32_t wanted = processors < 1 ? 1 : processors > THREADS_MOST ? THREADS_MOST : (uint32_t)processors, begun = 1;
    for (uint32_t i = 0; i < wanted; i++) workers[i].job = &job;
    while (begun < wanted && begun < count && !pthread_create(&workers[begun].thread, NULL, run, &workers[begun]))
        begun++;
    run(&workers[0]); // this thread is the first
    for (uint32_t i = 1; i < begun; i++) pthread_join(workers[i].thread, NULL);
    for (uint32_t i = 0; i < begun; i++)
        if (workers[i].failure.status && (!failed || workers[i].failed < failed->failed)) failed = &workers[i];
    return failed ? vw_first_failure_report(&failed->failure) : VW_OK;
}

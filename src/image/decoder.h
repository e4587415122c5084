// Photos are read and written in processes without rights, which viewworth-decode starts: files come from strangers,
// and decoders of image files have flaws. What comes back is data that nothing is believed about. A crash, or a task
// that takes too much memory or time, fails that task alone.
//
// The program is started for the first task and ends when no one uses it. All functions may be called by any thread.
#ifndef VIEWWORTH_IMAGE_DECODER_H
#define VIEWWORTH_IMAGE_DECODER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

struct vw_decoder_request;
struct vw_decoder_answer;
struct vw_decoder_job; // a task that a worker does

// Settings for tests; zero: the default. They are set before the first task, or while no one uses the program.
struct vw_decoder_params {
    const char *program; // borrowed; NULL: viewworth-decode beside the program, or where it is installed
    uint32_t time_out_s; // for an answer; 0: by the task's size
};
void vw_decoder_configure(const struct vw_decoder_params *params);

// Keeps the program for further tasks until it is released as often.
void vw_decoder_hold(void);
void vw_decoder_release(void);

// Returns how many tasks should be under way at once.
uint32_t vw_decoder_parallel_count(void);

// Gives a task to a worker: the open file that it reads, if not -1 (it stays the caller's), and a payload that it is
// sent. The worker may take `memory_bytes` of address space. Messages do not name the file.
enum vw_status vw_decoder_begin(const struct vw_decoder_request *request, int descriptor, const void *payload,
                                size_t payload_bytes, uint64_t memory_bytes, struct vw_decoder_job **job);
// Waits for the answer. A task that failed gives its own status and message; VW_ERROR_IO when the worker crashed.
enum vw_status vw_decoder_finish(struct vw_decoder_job *job, struct vw_decoder_answer *answer);
// Receives the next bytes of the answer's payload.
enum vw_status vw_decoder_receive(struct vw_decoder_job *job, void *data, size_t size_bytes);
// Frees the job. A worker that has not been heard to the end of its answer is killed.
void vw_decoder_end(struct vw_decoder_job **job);

#endif

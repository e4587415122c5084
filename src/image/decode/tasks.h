// The tasks of a worker: it turns the bytes of a file into an answer, and back. Fuzzers call these functions, too.
#ifndef VIEWWORTH_IMAGE_DECODE_TASKS_H
#define VIEWWORTH_IMAGE_DECODE_TASKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "image/decoder_protocol.h"
#include "image/image.h"

void vw_task_fail(enum vw_status status, const char *message, struct vw_decoder_answer *answer);
void vw_task_read_header(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                         struct vw_decoder_answer *answer);
// Reads a photo. `*image` is owned by the caller (vw_image_clear), and unchanged after a failure.
void vw_task_read_photo(const struct vw_decoder_request *request, const void *file, size_t file_bytes,
                        struct vw_decoder_answer *answer, struct vw_image *image);
// Writes a photo. `pixels` has the size and channels of request->header. After VW_OK `*file` is owned by the caller
// (free) and has answer->payload_bytes.
void vw_task_write_photo(const struct vw_decoder_request *request, const float *pixels,
                         struct vw_decoder_answer *answer, void **file);

// ---- The worker that does them (worker.c) ----

// Confines the process, then answers on VW_DECODER_SOCKET until that is closed. False: it could not go on.
bool vw_worker_run(const struct vw_decoder_order *order);
// Receives bytes and at most one descriptor; `*descriptor` is unchanged when none came. What recvmsg() returns.
ssize_t vw_worker_receive(int socket, void *data, size_t size_bytes, int *descriptor);

// ---- The confinement of a worker ----

struct vw_confinement {
    uint64_t memory_bytes;    // address space beyond what the process has now
    uint64_t cpu_s;           // after which the kernel kills it
    uint32_t descriptor_most; // no descriptor above this one can be opened
    bool without_seccomp;     // for tests of kernels that have none
};

// Confines the process for the rest of its life: it opens no file and no socket (the descriptors that it has, and those
// that it is sent, work), starts no process or thread, gains no privileges, leaves no core file, and has these limits.
// If the kernel has no seccomp, only the limits apply: one free descriptor is left, for the file that it is sent.
// Returns false if a limit cannot be set, or no filter although the kernel has them: the process must end.
bool vw_confine(const struct vw_confinement *confinement);

#endif

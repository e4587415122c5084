// A worker of viewworth-decode: it reads requests and writes answers.
#ifndef VIEWWORTH_IMAGE_DECODE_WORKER_H
#define VIEWWORTH_IMAGE_DECODE_WORKER_H

#include <sys/types.h>

#include "image/decoder_protocol.h"

// Confines the process, then answers on VW_DECODER_SOCKET until that is closed. False: it could not go on.
bool vw_worker_run(const struct vw_decoder_order *order, bool without_seccomp);
// Receives bytes and at most one descriptor; `*descriptor` is unchanged when none came. What recvmsg() returns.
ssize_t vw_worker_receive(int socket, void *data, size_t size_bytes, int *descriptor);

#endif

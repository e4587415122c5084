// The protocol between the library and the program viewworth-decode. Both are of one build: the program's first
// message is VW_DECODER_HELLO.
//
// The program is a server that has loaded OpenImageIO and never sees a photo. On its socket DECODER_SOCKET it takes
// orders: each brings a socket, for which it forks a worker. A worker confines itself, then does one task after the
// other: it reads a request (with the open file, for tasks that read one) and the request's payload, and writes an
// answer and the answer's payload. It ends when its socket is closed, and the server kills it then if it hangs.
#ifndef VIEWWORTH_IMAGE_DECODER_PROTOCOL_H
#define VIEWWORTH_IMAGE_DECODER_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

#include "image/pixel.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

#define VW_DECODER_HELLO "viewworth-decode " VW_VERSION
enum { VW_DECODER_SOCKET = 3, VW_DECODER_MESSAGE_BYTES = 400, VW_DECODER_WORKERS_MAX = 64 };

struct vw_decoder_order {
    uint64_t memory_bytes; // address space of the worker beyond what the server has
    uint64_t cpu_s;        // for all its tasks
};

enum vw_decoder_task { VW_DECODER_READ_HEADER, VW_DECODER_READ_PHOTO, VW_DECODER_WRITE_PHOTO };

struct vw_decoder_request {
    enum vw_decoder_task task;
    uint32_t photo_format;         // index in vw_photo_formats
    uint32_t downscale;            // factor for a photo that is read
    struct vw_image_header header; // READ_PHOTO: what READ_HEADER has found; WRITE_PHOTO: size and channels
    bool eight_bit;                // WRITE_PHOTO: 8 bit with straight alpha, otherwise float with premultiplied alpha
    char compression[16];          // WRITE_PHOTO: OpenImageIO's, for example "webp:70"; "": the format's default
};

// Only integers: any bytes are a value of them.
struct vw_decoder_answer {
    uint32_t status;                        // enum vw_status
    char message[VW_DECODER_MESSAGE_BYTES]; // after a failure: one line without the file's name
    struct vw_image_header header;          // READ_HEADER; READ_PHOTO: of what follows
    uint32_t has_alpha;                     // READ_PHOTO: this and the next as in struct vw_image
    uint64_t clamped_count, masked_count;
    uint64_t payload_bytes; // READ_PHOTO: pixels, then a byte per pixel if masked_count is not 0; WRITE_PHOTO: the file
};

#endif

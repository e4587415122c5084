// Device buffers as a file that can tell whether it is whole: a magic line, the length of a JSON text as 8 decimal
// digits and "\n", the JSON (what the file is), "\n", the buffers' bytes one after another (little-endian), and a
// SHA-256 of everything before it.
#ifndef VIEWWORTH_TRAIN_FILES_HASHED_FILE_H
#define VIEWWORTH_TRAIN_FILES_HASHED_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"

// Some buffers, whole, in the order they have in the file. NULL entries are skipped.
struct vw_buffer_list {
    struct vw_buffer *const *buffers;
    uint32_t count;
    const void *tail; // bytes of the host that follow them
    size_t tail_bytes;
};

uint64_t vw_buffer_list_bytes(const struct vw_buffer_list *list);

// Waits for the device, then writes the file beside its place, syncs it and moves it there.
enum vw_status vw_hashed_file_save(const char *path, const char *magic, const char *description,
                                   const struct vw_buffer_list *list);

struct vw_hashed_file {
    void *bytes; // owned
    char *description;
    const uint8_t *payload; // the bytes after the description; in `bytes`
    uint64_t payload_bytes;
};

// Reads a file of at most `payload_limit_bytes` of buffers. VW_ERROR_INPUT, naming the path and the `remedy`, when it
// is not such a file or damaged.
enum vw_status vw_hashed_file_open(const char *path, const char *magic, uint64_t payload_limit_bytes,
                                   const char *remedy, struct vw_hashed_file *file);
void vw_hashed_file_close(struct vw_hashed_file *file);
// Puts the payload, whose size the caller has checked, into the buffers; a tail stays in the payload.
enum vw_status vw_hashed_file_load(const struct vw_hashed_file *file, const struct vw_buffer_list *list);

#endif

// Device buffers as a file that can tell whether it is whole: a magic line, the length of a JSON text as 8 decimal
// digits and "\n", the JSON (what the file is), "\n", the buffers' bytes one after another (little-endian), and a
// SHA-256 of everything before it.
#ifndef VIEWWORTH_TRAIN_FILES_HASHED_FILE_H
#define VIEWWORTH_TRAIN_FILES_HASHED_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// Some buffers, whole, in the order they have in the file. NULL entries are skipped.
struct vw_buffer_list {
    struct vw_buffer *const *buffers;
    uint32_t count;
};

uint64_t vw_buffer_list_bytes(const struct vw_buffer_list *list);

// The binding of files to a record of their hashes, which a trainer does not know: file names ("checkpoint_0.vwc") and
// SHA-256 of whole files, 64 hex digits.
struct vw_file_binding {
    // Records the hash of a file that is about to take its place.
    enum vw_status (*keep)(void *context, const char *name, const char *sha256);
    // Returns whether the file that was read is the recorded one.
    enum vw_status (*is_kept)(void *context, const char *name, const char *sha256, bool *kept);
    void *context;
};

// Waits for the device, then writes the file beside its place, syncs it and moves it there. `binding` may be NULL.
enum vw_status vw_hashed_file_save(const char *path, const char *magic, const char *description,
                                   const struct vw_buffer_list *list, const struct vw_file_binding *binding);

struct vw_hashed_file {
    void *bytes; // owned
    char *description;
    const uint8_t *payload; // the bytes after the description; in `bytes`
    uint64_t payload_bytes;
    char sha256[VW_HASH_HEX_BYTES]; // hash of the whole file
};

// Reads a file of at most `payload_limit_bytes` of buffers. VW_ERROR_INPUT, naming the path and the `remedy`, when it
// is not such a file or damaged.
enum vw_status vw_hashed_file_open(const char *path, const char *magic, uint64_t payload_limit_bytes,
                                   const char *remedy, struct vw_hashed_file *file);
// Returns VW_ERROR_INPUT for a file that the binding does not know; without a binding (NULL) every file is believed.
enum vw_status vw_hashed_file_check_kept(const struct vw_hashed_file *file, const char *path, const char *remedy,
                                         const struct vw_file_binding *binding);
void vw_hashed_file_close(struct vw_hashed_file *file);
// Puts the payload, whose size the caller has checked, into the buffers.
enum vw_status vw_hashed_file_load(const struct vw_hashed_file *file, const struct vw_buffer_list *list);

#endif

#include "train/files/hashed_file.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "gpu/compute.h"

enum { LENGTH_BYTES = 9, HASH_BYTES = 32, DESCRIPTION_BYTES_MAX = 1 << 20 };

uint64_t vw_buffer_list_bytes(const struct vw_buffer_list *list) {
    uint64_t sum = list->tail_bytes;
    for (uint32_t i = 0; i < list->count; i++) sum += list->buffers[i] ? vw_buffer_size_bytes(list->buffers[i]) : 0;
    return sum;
}

static enum vw_status read_buffers(const struct vw_buffer_list *list, uint8_t *next) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < list->count && !status; i++) {
        if (!list->buffers[i]) continue;
        uint64_t size_bytes = vw_buffer_size_bytes(list->buffers[i]);
        status = vw_buffer_read(list->buffers[i], 0, next, size_bytes);
        next += size_bytes;
    }
    if (!status && list->tail_bytes) memcpy(next, list->tail, list->tail_bytes);
    return status;
}

enum vw_status vw_hashed_file_save(const char *path, const char *magic, const char *description,
                                   const struct vw_buffer_list *list) {
    char *header = vw_format_text("%s%08zu\n%s\n", magic, strlen(description), description);
    size_t header_bytes = header ? strlen(header) : 0, body_bytes = header_bytes + vw_buffer_list_bytes(list);
    uint8_t *file = header ? vw_allocate(body_bytes + HASH_BYTES, 1) : NULL;
    enum vw_status status = file ? VW_OK : VW_ERROR_MEMORY;
    if (!status) {
        memcpy(file, header, header_bytes);
        status = read_buffers(list, file + header_bytes);
    }
    if (!status) vw_sha256(file, body_bytes, file + body_bytes);
    if (!status) status = vw_file_write(path, file, body_bytes + HASH_BYTES);
    free(header);
    free(file);
    return status;
}

// Splits a file into its parts. The hash vouches for the rest, so that what it covers needs no further check.
static enum vw_status take_apart(const char *path, const char *magic, const char *remedy, size_t size_bytes,
                                 struct vw_hashed_file *file) {
    const size_t start = strlen(magic) + LENGTH_BYTES;
    uint8_t *bytes = file->bytes, hash[HASH_BYTES];
    if (size_bytes < start + 1 + HASH_BYTES || memcmp(bytes, magic, strlen(magic)))
        return vw_fail(VW_ERROR_INPUT, "%s: begins with another line than %.*s; %s", path, (int)strlen(magic) - 1,
                       magic, remedy);
    vw_sha256(bytes, size_bytes - HASH_BYTES, hash);
    size_t length = strtoul((const char *)bytes + strlen(magic), NULL, 10);
    if (memcmp(hash, bytes + size_bytes - HASH_BYTES, HASH_BYTES) || length > size_bytes - start - 1 - HASH_BYTES)
        return vw_fail(VW_ERROR_INPUT, "%s: damaged (its hash does not match); %s", path, remedy);
    file->description = (char *)bytes + start;
    file->description[length] = 0; // in the place of the line end
    file->payload = bytes + start + length + 1;
    file->payload_bytes = size_bytes - HASH_BYTES - (start + length + 1);
    return VW_OK;
}

enum vw_status vw_hashed_file_open(const char *path, const char *magic, uint64_t payload_limit_bytes,
                                   const char *remedy, struct vw_hashed_file *file) {
    *file = (struct vw_hashed_file){0};
    size_t size_bytes = 0;
    if (!vw_file_exists(path)) return vw_fail(VW_ERROR_INPUT, "%s: no such file; %s", path, remedy);
    enum vw_status status = vw_file_read(path, payload_limit_bytes + DESCRIPTION_BYTES_MAX, &file->bytes, &size_bytes);
    if (!status) status = take_apart(path, magic, remedy, size_bytes, file);
    if (status) vw_hashed_file_close(file);
    return status;
}

void vw_hashed_file_close(struct vw_hashed_file *file) {
    free(file->bytes);
    *file = (struct vw_hashed_file){0};
}

enum vw_status vw_hashed_file_load(const struct vw_hashed_file *file, const struct vw_buffer_list *list) {
    const uint8_t *next = file->payload;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < list->count && !status; i++) {
        if (!list->buffers[i]) continue;
        uint64_t size_bytes = vw_buffer_size_bytes(list->buffers[i]);
        status = vw_buffer_write(list->buffers[i], 0, next, size_bytes);
        next += size_bytes;
    }
    return status;
}

// A file of ours that somebody changes, with a right hash of its own at its end.
#ifndef VIEWWORTH_TESTS_SUPPORT_FORGED_FILE_H
#define VIEWWORTH_TESTS_SUPPORT_FORGED_FILE_H

#include "base/hash.h"
#include "support/temporary_folder.h"

// Hashes the changed bytes of a file anew, writes it and frees them.
static inline void forge_bytes(const char *path, uint8_t *bytes, size_t size_bytes) {
    vw_sha256(bytes, size_bytes - VW_HASH_BYTES, bytes + size_bytes - VW_HASH_BYTES);
    temporary_write(path, bytes, size_bytes);
    free(bytes);
}

// Adds `change` to the byte that is `from_end` bytes before the hash.
static inline void forge_file(const char *path, size_t from_end, uint8_t change) {
    size_t size_bytes;
    uint8_t *bytes = temporary_read(path, &size_bytes);
    assert_true(size_bytes > VW_HASH_BYTES + from_end);
    bytes[size_bytes - VW_HASH_BYTES - from_end] += change;
    forge_bytes(path, bytes, size_bytes);
}

// Changes the first numbers of the payload, after the third line.
static inline void forge_payload(const char *path) {
    enum { LINES = 3, NUMBERS = 64 };
    size_t size_bytes;
    uint8_t *bytes = temporary_read(path, &size_bytes), *payload = bytes;
    for (int line = 0; line < LINES; line++) payload = (uint8_t *)strchr((char *)payload, '\n') + 1;
    assert_true(payload + NUMBERS * sizeof(float) + VW_HASH_BYTES <= bytes + size_bytes);
    for (int i = 0; i < NUMBERS; i++) payload[i * (int)sizeof(float) + 2] ^= 0x40; // the highest bit of the fraction
    forge_bytes(path, bytes, size_bytes);
}

#endif

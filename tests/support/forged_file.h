// A file of ours that somebody changes, with a right hash of its own at its end.
#ifndef VIEWWORTH_TESTS_SUPPORT_FORGED_FILE_H
#define VIEWWORTH_TESTS_SUPPORT_FORGED_FILE_H

#include "base/file.h"
#include "base/hash.h"
#include "support/cmocka_test.h"

// Adds `change` to the byte that is `from_end` bytes before the hash, and hashes the file anew.
static inline void forge_file(const char *path, size_t from_end, uint8_t change) {
    enum { LIMIT_BYTES = 1 << 26 };
    void *bytes = NULL;
    uint8_t whole[VW_HASH_BYTES];
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(path, LIMIT_BYTES, &bytes, &size_bytes));
    assert_true(size_bytes > VW_HASH_BYTES + from_end);
    size_t body_bytes = size_bytes - VW_HASH_BYTES;
    ((uint8_t *)bytes)[body_bytes - from_end] += change;
    vw_sha256(bytes, body_bytes, whole);
    memcpy((uint8_t *)bytes + body_bytes, whole, VW_HASH_BYTES);
    ASSERT_OK(vw_file_write(path, bytes, size_bytes));
    free(bytes);
}

// Changes the first numbers of the payload, after the third line, and hashes the file anew.
static inline void forge_payload(const char *path) {
    enum { LIMIT_BYTES = 1 << 26, LINES = 3, NUMBERS = 64 };
    void *bytes = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(path, LIMIT_BYTES, &bytes, &size_bytes));
    uint8_t *payload = bytes;
    for (int line = 0; line < LINES; line++) payload = (uint8_t *)strchr((char *)payload, '\n') + 1;
    assert_true(payload + NUMBERS * sizeof(float) + VW_HASH_BYTES <= (uint8_t *)bytes + size_bytes);
    for (int i = 0; i < NUMBERS; i++) payload[i * (int)sizeof(float) + 2] ^= 0x40; // the highest bit of the fraction
    vw_sha256(bytes, size_bytes - VW_HASH_BYTES, (uint8_t *)bytes + size_bytes - VW_HASH_BYTES);
    ASSERT_OK(vw_file_write(path, bytes, size_bytes));
    free(bytes);
}

#endif

// Hashes, with libsodium: SHA-256 for files, BLAKE2b-256 for everything else.
#ifndef VIEWWORTH_BASE_HASH_H
#define VIEWWORTH_BASE_HASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"

// Hashes an opened file, whose position does not change. `path` is for messages.
enum vw_status vw_sha256_descriptor(int descriptor, const char *path, uint8_t hash[VW_HASH_BYTES]);
void vw_sha256(const void *data, size_t size_bytes, uint8_t hash[VW_HASH_BYTES]);
// An incremental BLAKE2b-256. Values are added with a type tag and in little-endian order, texts with their length, so
// that different sequences give different bytes.
struct vw_hasher {
    _Alignas(64) unsigned char state[384];
};
void vw_hasher_begin(struct vw_hasher *hasher);
void vw_hasher_add_bytes(struct vw_hasher *hasher, const void *data, size_t size_bytes);
void vw_hasher_add_text(struct vw_hasher *hasher, const char *text); // NULL is distinct from ""
void vw_hasher_add_integer(struct vw_hasher *hasher, int64_t value);
void vw_hasher_add_real(struct vw_hasher *hasher, double value); // its bits
void vw_hasher_add_null(struct vw_hasher *hasher);
void vw_hasher_end(struct vw_hasher *hasher, uint8_t hash[VW_HASH_BYTES]);

void vw_hash_to_hex(const uint8_t hash[VW_HASH_BYTES], char hex[VW_HASH_HEX_BYTES]);
// Reads 64 digits as vw_hash_to_hex() writes them, in lower case; returns false for any other text.
bool vw_hash_from_hex(const char *hex, uint8_t hash[VW_HASH_BYTES]);

#endif

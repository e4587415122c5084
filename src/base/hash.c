#include "base/hash.h"

#include <assert.h>
#include <errno.h>
#include <sodium.h>
#include <string.h>
#include <unistd.h>

_Static_assert(sizeof(struct vw_hasher) >= sizeof(crypto_generichash_state),
               "struct vw_hasher holds libsodium's state");
_Static_assert(_Alignof(struct vw_hasher) >= _Alignof(crypto_generichash_state),
               "struct vw_hasher is aligned as libsodium's state");

enum { HASH_BYTES = 32, READ_BYTES = 65536 };

void vw_sha256(const void *data, size_t size_bytes, uint8_t hash[VW_HASH_BYTES]) {
    crypto_hash_sha256(hash, data, size_bytes);
}

enum vw_status vw_sha256_descriptor(int descriptor, const char *path, uint8_t hash[VW_HASH_BYTES]) {
    crypto_hash_sha256_state state;
    crypto_hash_sha256_init(&state);
    unsigned char buffer[READ_BYTES];
    ssize_t got = 1;
    for (off_t offset = 0; got; offset += got) {
        do got = pread(descriptor, buffer, sizeof buffer, offset);
        while (got < 0 && errno == EINTR);
        if (got < 0) return vw_fail(VW_ERROR_IO, "%s: cannot read: %s; check the disk", path, strerror(errno));
        crypto_hash_sha256_update(&state, buffer, (size_t)got);
    }
    crypto_hash_sha256_final(&state, hash);
    return VW_OK;
}

static crypto_generichash_state *state_of(struct vw_hasher *hasher) {
    return (crypto_generichash_state *)hasher->state;
}

static void add_raw(struct vw_hasher *hasher, const void *data, size_t size_bytes) {
    crypto_generichash_update(state_of(hasher), data, size_bytes);
}

static void add_tag(struct vw_hasher *hasher, char tag) { add_raw(hasher, &tag, 1); }

static void add_word(struct vw_hasher *hasher, uint64_t word) {
    unsigned char bytes[8];
    for (int i = 0; i < 8; i++) bytes[i] = (unsigned char)(word >> (8 * i));
    add_raw(hasher, bytes, sizeof bytes);
}

void vw_hasher_begin(struct vw_hasher *hasher) {
    int ready = sodium_init(); // selects the fastest code for this CPU; repeated calls, from any thread, do nothing
    assert(ready >= 0);
    (void)ready;
    crypto_generichash_init(state_of(hasher), NULL, 0, HASH_BYTES);
}

void vw_hasher_add_bytes(struct vw_hasher *hasher, const void *data, size_t size_bytes) {
    add_tag(hasher, 'b');
    add_word(hasher, size_bytes);
    add_raw(hasher, data, size_bytes);
}

void vw_hasher_add_text(struct vw_hasher *hasher, const char *text) {
    if (!text) {
        vw_hasher_add_null(hasher);
        return;
    }
    size_t length = strlen(text);
    add_tag(hasher, 't');
    add_word(hasher, length);
    add_raw(hasher, text, length);
}

void vw_hasher_add_integer(struct vw_hasher *hasher, int64_t value) {
    add_tag(hasher, 'i');
    add_word(hasher, (uint64_t)value);
}

void vw_hasher_add_real(struct vw_hasher *hasher, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    add_tag(hasher, 'r');
    add_word(hasher, bits);
}

void vw_hasher_add_null(struct vw_hasher *hasher) { add_tag(hasher, 'n'); }

void vw_hasher_end(struct vw_hasher *hasher, uint8_t hash[VW_HASH_BYTES]) {
    crypto_generichash_final(state_of(hasher), hash, HASH_BYTES);
}

void vw_hash_to_hex(const uint8_t hash[VW_HASH_BYTES], char hex[VW_HASH_HEX_BYTES]) {
    sodium_bin2hex(hex, VW_HASH_HEX_BYTES, hash, HASH_BYTES);
}

bool vw_hash_from_hex(const char *hex, uint8_t hash[VW_HASH_BYTES]) {
    size_t digits = strspn(hex, "0123456789abcdef");
    return digits == 2 * HASH_BYTES && !hex[digits] &&
           sodium_hex2bin(hash, HASH_BYTES, hex, digits, NULL, NULL, NULL) == 0;
}

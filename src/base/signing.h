// Ed25519 signatures, with libsodium, and the files that hold keys. A key file has two lines: what it is, and the key
// in base64. No function puts a secret key into a message.
#ifndef VIEWWORTH_BASE_SIGNING_H
#define VIEWWORTH_BASE_SIGNING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

enum {
    VW_PUBLIC_KEY_BYTES = 32,
    VW_SECRET_KEY_BYTES = 64, // with the public key as its second half
    VW_SIGNATURE_BYTES = 64,
    VW_PUBLIC_KEY_TEXT_BYTES = 45, // in base64, with its zero byte
    VW_SIGNATURE_TEXT_BYTES = 89,
};

// Makes a pair of keys: the secret one in a new file `path` that only its owner may read, the public one in "path.pub".
// VW_ERROR_USAGE if either exists. `public_key` receives the latter in base64.
enum vw_status vw_keys_make(const char *path, char public_key[VW_PUBLIC_KEY_TEXT_BYTES]);

// VW_ERROR_INPUT if the file is no such key. Wipe the secret key also after a failure.
enum vw_status vw_secret_key_read(const char *path, uint8_t key[VW_SECRET_KEY_BYTES]);
void vw_secret_key_wipe(uint8_t key[VW_SECRET_KEY_BYTES]);
// Reads a secret key and forgets it. Warns if others may read the file.
enum vw_status vw_secret_key_check(const char *path);
enum vw_status vw_public_key_read(const char *path, uint8_t key[VW_PUBLIC_KEY_BYTES]);

void vw_sign(const uint8_t key[VW_SECRET_KEY_BYTES], const void *message, size_t size_bytes,
             uint8_t signature[VW_SIGNATURE_BYTES]);
bool vw_signature_holds(const uint8_t key[VW_PUBLIC_KEY_BYTES], const void *message, size_t size_bytes,
                        const uint8_t signature[VW_SIGNATURE_BYTES]);

const uint8_t *vw_public_key_of(const uint8_t key[VW_SECRET_KEY_BYTES]);
void vw_public_key_to_text(const uint8_t key[VW_PUBLIC_KEY_BYTES], char text[VW_PUBLIC_KEY_TEXT_BYTES]);
void vw_signature_to_text(const uint8_t signature[VW_SIGNATURE_BYTES], char text[VW_SIGNATURE_TEXT_BYTES]);
// Whether `text` is exactly what vw_signature_to_text() writes.
bool vw_signature_from_text(const char *text, uint8_t signature[VW_SIGNATURE_BYTES]);

#endif

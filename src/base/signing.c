#include "base/signing.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

_Static_assert(VW_PUBLIC_KEY_BYTES == crypto_sign_PUBLICKEYBYTES && VW_SECRET_KEY_BYTES == crypto_sign_SECRETKEYBYTES &&
                   VW_SIGNATURE_BYTES == crypto_sign_BYTES,
               "the sizes of Ed25519");

static const char secret_heading[] = "viewworth secret key 1\n", public_heading[] = "viewworth public key 1\n";
enum { BASE64 = sodium_base64_VARIANT_ORIGINAL, KEY_FILE_BYTES = 256 };

static void begin(void) {
    int ready = sodium_init(); // repeated calls do nothing
    assert(ready >= 0);
    (void)ready;
}

// Whether the text is exactly the base64 of so many bytes: libsodium's decoder takes some others for it.
static bool from_base64(const char *text, size_t length, uint8_t *bytes, size_t byte_count) {
    char again[sodium_base64_ENCODED_LEN(VW_SECRET_KEY_BYTES, BASE64)];
    size_t got = 0;
    bool same = sodium_base642bin(bytes, byte_count, text, length, NULL, &got, NULL, BASE64) == 0 &&
                got == byte_count && sodium_base64_encoded_len(byte_count, BASE64) == length + 1;
    if (same) sodium_bin2base64(again, sizeof again, bytes, byte_count, BASE64);
    same = same && sodium_memcmp(again, text, length) == 0;
    sodium_memzero(again, sizeof again);
    return same;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static bool begins_with(const char *text, const char *heading) { return strncmp(text, heading, strlen(heading)) == 0; }

static enum vw_status fail_kind(const char *path, const char *text, bool secret) {
    if (secret && begins_with(text, public_heading))
        return vw_fail(VW_ERROR_INPUT, "%s: is a public key; sign with the secret key, the file without .pub", path);
    if (!secret && begins_with(text, secret_heading))
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: is a secret key; verify with the public key, the file with .pub, and give the secret key to "
            "nobody",
            path);
    return vw_fail(VW_ERROR_INPUT, "%s: is no %s key of viewworth; make one by viewworth keygen", path,
                   secret ? "secret" : "public");
}

static enum vw_status parse_key(const char *path, const char *text, bool secret, uint8_t *key) {
    const char *heading = secret ? secret_heading : public_heading;
    if (!begins_with(text, heading)) return fail_kind(path, text, secret);
    const char *line = text + strlen(heading);
    size_t length = strcspn(line, "\n");
    bool whole = line[length] == '\n' && !line[length + 1];
    if (whole && from_base64(line, length, key, secret ? VW_SECRET_KEY_BYTES : VW_PUBLIC_KEY_BYTES)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s:2: the key is damaged; restore the file from a copy", path);
}

// The text never leaves this buffer, which the caller wipes.
static enum vw_status read_text(const char *path, char text[KEY_FILE_BYTES], bool *others_may_read) {
    int descriptor = -1;
    struct stat info = {0};
    size_t used = 0;
    ssize_t got = 1;
    enum vw_status status = vw_file_open(path, &descriptor);
    if (status) return status;
    *others_may_read = !fstat(descriptor, &info) && (info.st_mode & (S_IRWXG | S_IRWXO));
    while (got > 0 && used < KEY_FILE_BYTES - 1) {
        got = read(descriptor, text + used, KEY_FILE_BYTES - 1 - used);
        if (got > 0) used += (size_t)got;
    }
    if (got < 0) status = vw_fail(VW_ERROR_INPUT, "%s: cannot read: %s", path, strerror(errno));
    text[strlen(text) < used ? 0 : used] = 0; // a zero byte within the text: no key
    close(descriptor);
    return status;
}

static enum vw_status read_key(const char *path, bool secret, uint8_t *key, bool *others_may_read) {
    char text[KEY_FILE_BYTES] = "";
    begin();
    enum vw_status status = read_text(path, text, others_may_read);
    if (!status) status = parse_key(path, text, secret, key);
    sodium_memzero(text, sizeof text);
    return status;
}

// The second half must be the public key of the first.
static enum vw_status read_secret(const char *path, uint8_t key[VW_SECRET_KEY_BYTES], bool *others_may_read) {
    uint8_t again[VW_SECRET_KEY_BYTES], public_key[VW_PUBLIC_KEY_BYTES];
    enum vw_status status = read_key(path, true, key, others_may_read);
    if (status) return status;
    crypto_sign_seed_keypair(public_key, again, key);
    bool same = sodium_memcmp(again, key, sizeof again) == 0;
    sodium_memzero(again, sizeof again);
    return same ? VW_OK : vw_fail(VW_ERROR_INPUT, "%s:2: the key is damaged; restore the file from a copy", path);
}

enum vw_status vw_secret_key_read(const char *path, uint8_t key[VW_SECRET_KEY_BYTES]) {
    bool others_may_read = false;
    return read_secret(path, key, &others_may_read);
}

void vw_secret_key_wipe(uint8_t key[VW_SECRET_KEY_BYTES]) { sodium_memzero(key, VW_SECRET_KEY_BYTES); }

enum vw_status vw_secret_key_check(const char *path) {
    uint8_t key[VW_SECRET_KEY_BYTES];
    bool others_may_read = false;
    enum vw_status status = read_secret(path, key, &others_may_read);
    vw_secret_key_wipe(key);
    if (!status && others_may_read)
        vw_log_warning("%s: others may read this secret key, and sign in your name; set its mode to 600", path);
    return status;
}

enum vw_status vw_public_key_read(const char *path, uint8_t key[VW_PUBLIC_KEY_BYTES]) {
    bool others_may_read = false;
    return read_key(path, false, key, &others_may_read);
}

// ---- Making --------------------------------------------------------------------------------------------------------

// Does without a temporary file, which could remain with the key in it.
static enum vw_status create_secret(const char *path, const char *text) {
    int descriptor = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (descriptor < 0 && errno == EEXIST)
        return vw_fail(VW_ERROR_USAGE, "%s: is there already; name another file for the key", path);
    if (descriptor < 0)
        return vw_fail(VW_ERROR_IO, "%s: cannot create: %s; check the folder and its permissions", path,
                       strerror(errno));
    bool written = write(descriptor, text, strlen(text)) == (ssize_t)strlen(text) && fsync(descriptor) == 0;
    int cause = errno;
    if (close(descriptor) && written) written = false, cause = errno;
    if (written) return VW_OK;
    unlink(path);
    return vw_fail(VW_ERROR_IO, "%s: cannot write: %s; check the free space", path, strerror(cause));
}

static enum vw_status write_pair(const char *path, const char *public_path, const uint8_t secret[VW_SECRET_KEY_BYTES],
                                 const char *public_text) {
    char text[KEY_FILE_BYTES], base64[sodium_base64_ENCODED_LEN(VW_SECRET_KEY_BYTES, BASE64)];
    char public_file[KEY_FILE_BYTES];
    sodium_bin2base64(base64, sizeof base64, secret, VW_SECRET_KEY_BYTES, BASE64);
    snprintf(text, sizeof text, "%s%s\n", secret_heading, base64);
    snprintf(public_file, sizeof public_file, "%s%s\n", public_heading, public_text);
    enum vw_status status = create_secret(path, text);
    sodium_memzero(text, sizeof text);
    sodium_memzero(base64, sizeof base64);
    if (status) return status;
    status = vw_file_create(public_path, public_file, strlen(public_file));
    if (status) unlink(path);
    return status;
}

enum vw_status vw_keys_make(const char *path, char public_key[VW_PUBLIC_KEY_TEXT_BYTES]) {
    uint8_t secret[VW_SECRET_KEY_BYTES], public_half[VW_PUBLIC_KEY_BYTES];
    char *public_path = vw_format_text("%s.pub", path);
    if (!public_path) return VW_ERROR_MEMORY;
    begin();
    crypto_sign_keypair(public_half, secret);
    vw_public_key_to_text(public_half, public_key);
    enum vw_status status = write_pair(path, public_path, secret, public_key);
    vw_secret_key_wipe(secret);
    free(public_path);
    return status;
}

// ---- Signatures ----------------------------------------------------------------------------------------------------

void vw_sign(const uint8_t key[VW_SECRET_KEY_BYTES], const void *message, size_t size_bytes,
             uint8_t signature[VW_SIGNATURE_BYTES]) {
    begin();
    crypto_sign_detached(signature, NULL, message, size_bytes, key);
}

bool vw_signature_holds(const uint8_t key[VW_PUBLIC_KEY_BYTES], const void *message, size_t size_bytes,
                        const uint8_t signature[VW_SIGNATURE_BYTES]) {
    begin();
    return crypto_sign_verify_detached(signature, message, size_bytes, key) == 0;
}

const uint8_t *vw_public_key_of(const uint8_t key[VW_SECRET_KEY_BYTES]) {
    return key + VW_SECRET_KEY_BYTES - VW_PUBLIC_KEY_BYTES;
}

void vw_public_key_to_text(const uint8_t key[VW_PUBLIC_KEY_BYTES], char text[VW_PUBLIC_KEY_TEXT_BYTES]) {
    sodium_bin2base64(text, VW_PUBLIC_KEY_TEXT_BYTES, key, VW_PUBLIC_KEY_BYTES, BASE64);
}

void vw_signature_to_text(const uint8_t signature[VW_SIGNATURE_BYTES], char text[VW_SIGNATURE_TEXT_BYTES]) {
    sodium_bin2base64(text, VW_SIGNATURE_TEXT_BYTES, signature, VW_SIGNATURE_BYTES, BASE64);
}

bool vw_signature_from_text(const char *text, uint8_t signature[VW_SIGNATURE_BYTES]) {
    return from_base64(text, strlen(text), signature, VW_SIGNATURE_BYTES);
}

// Key files and signatures.
#include "support/cmocka_test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/signing.h"
#include "support/temporary_folder.h"

struct fixture {
    char *folder;
    char key[300], public_key[300]; // files
};

static int set_up(void **state) {
    struct fixture *fixture = vw_allocate(1, sizeof *fixture);
    char text[VW_PUBLIC_KEY_TEXT_BYTES];
    fixture->folder = temporary_folder_create();
    snprintf(fixture->key, sizeof fixture->key, "%s/key", fixture->folder);
    snprintf(fixture->public_key, sizeof fixture->public_key, "%s/key.pub", fixture->folder);
    ASSERT_OK(vw_keys_make(fixture->key, text));
    *state = fixture;
    return 0;
}

static int tear_down(void **state) {
    struct fixture *fixture = *state;
    temporary_folder_remove(fixture->folder);
    free(fixture);
    return 0;
}

// RFC 8032, section 7.1, test 2: the signature that every Ed25519 makes.
TEST(signatures_are_ed25519) {
    static const uint8_t key[VW_SECRET_KEY_BYTES] = {
        0x4c, 0xcd, 0x08, 0x9b, 0x28, 0xff, 0x96, 0xda, 0x9d, 0xb6, 0xc3, 0x46, 0xec, 0x11, 0x4e, 0x0f,
        0x5b, 0x8a, 0x31, 0x9f, 0x35, 0xab, 0xa6, 0x24, 0xda, 0x8c, 0xf6, 0xed, 0x4f, 0xb8, 0xa6, 0xfb,
        0x3d, 0x40, 0x17, 0xc3, 0xe8, 0x43, 0x89, 0x5a, 0x92, 0xb7, 0x0a, 0xa7, 0x4d, 0x1b, 0x7e, 0xbc,
        0x9c, 0x98, 0x2c, 0xcf, 0x2e, 0xc4, 0x96, 0x8c, 0xc0, 0xcd, 0x55, 0xf1, 0x2a, 0xf4, 0x66, 0x0c};
    uint8_t signature[VW_SIGNATURE_BYTES];
    char text[VW_SIGNATURE_TEXT_BYTES];
    vw_sign(key, "\x72", 1, signature);
    vw_signature_to_text(signature, text);
    assert_string_equal(text, "kqAJqfDUyrhyDoILX2QlQKKye1QWUD+Ps3YiI+vbadoIWsHkPhWZbkWPNhPQ8R2MOHsurrQwKu6w"
                              "DSkWErsMAA==");
    assert_true(vw_signature_holds(vw_public_key_of(key), "\x72", 1, signature));
    assert_false(vw_signature_holds(vw_public_key_of(key), "\x73", 1, signature));
    assert_true(vw_signature_from_text(text, signature));
    text[86] = 'x';
    assert_false(vw_signature_from_text(text, signature));
}

// A key of small order makes signatures of anything: none of them holds.
TEST(keys_of_small_order_sign_nothing) {
    static const uint8_t identity[VW_PUBLIC_KEY_BYTES] = {1};
    static const uint8_t signature[VW_SIGNATURE_BYTES] = {1};
    assert_false(vw_signature_holds(identity, "anything", 8, signature));
}

TEST(keys_are_files_of_their_owner) {
    const struct fixture *fixture = *state;
    struct stat info;
    char text[VW_PUBLIC_KEY_TEXT_BYTES];
    uint8_t key[VW_SECRET_KEY_BYTES];
    assert_int_equal(stat(fixture->key, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    assert_int_equal(vw_keys_make(fixture->key, text), VW_ERROR_USAGE);
    const char *lonely = temporary_file(fixture->folder, "lonely.pub", "mine");
    char secret[300];
    snprintf(secret, sizeof secret, "%.*s", (int)strlen(lonely) - 4, lonely);
    assert_int_equal(vw_keys_make(secret, text), VW_ERROR_USAGE);
    assert_false(vw_file_exists(secret)); // neither file is made
    ASSERT_OK(vw_secret_key_read(fixture->key, key));
    vw_secret_key_wipe(key);
    assert_int_equal(key[0] | key[31] | key[63], 0);
}

// In place, without waiting for the disk.
static void write_bytes(const char *path, const char *bytes, size_t size_bytes) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size_bytes, file), size_bytes);
    assert_int_equal(fclose(file), 0);
}

static void assert_refuses_key(const char *path, const char *bytes, size_t size_bytes) {
    uint8_t key[VW_SECRET_KEY_BYTES];
    write_bytes(path, bytes, size_bytes);
    if (vw_secret_key_read(path, key) != VW_ERROR_INPUT)
        fail_msg("a wrong key was read:\n%.*s", (int)size_bytes, bytes);
}

TEST(wrong_keys_are_refused) {
    const struct fixture *fixture = *state;
    uint8_t key[VW_SECRET_KEY_BYTES];
    void *data = NULL;
    size_t size_bytes = 0;
    assert_int_equal(vw_secret_key_read(fixture->public_key, key), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "is a public key"));
    assert_int_equal(vw_public_key_read(fixture->key, key), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "is a secret key"));
    assert_int_equal(vw_secret_key_read(temporary_path(fixture->folder, "none"), key), VW_ERROR_INPUT);
    ASSERT_OK(vw_file_read(fixture->key, 1000, &data, &size_bytes));
    char *text = data;
    const char *path = temporary_path(fixture->folder, "key");
    for (size_t length = 0; length < size_bytes; length++) // cut off
        assert_refuses_key(path, text, length);
    for (size_t bit = 0; bit < 8 * size_bytes; bit++) { // damaged
        text[bit / 8] ^= (char)(1 << bit % 8);
        assert_refuses_key(path, text, size_bytes);
        text[bit / 8] ^= (char)(1 << bit % 8);
    }
    write_bytes(path, text, size_bytes);
    free(data);
    ASSERT_OK(vw_secret_key_check(fixture->key));
}

TEST_GROUP(set_up, tear_down)

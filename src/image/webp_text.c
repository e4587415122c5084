#include "image/webp_text.h"

#include <sodium.h>
#include <stdint.h>
#include <string.h>

#include "base/memory.h"

char *vw_webp_to_text(const void *data, size_t size_bytes) {
    size_t text_bytes = sodium_base64_encoded_len(size_bytes, sodium_base64_VARIANT_ORIGINAL);
    char *text = vw_allocate(text_bytes, 1);
    return text ? sodium_bin2base64(text, text_bytes, data, size_bytes, sodium_base64_VARIANT_ORIGINAL) : NULL;
}

bool vw_is_webp_text(const char *text) {
    uint8_t head[12];
    size_t read_bytes = 0, length = text ? strlen(text) : 0;
    if (length < 16 || length % 4 != 0 || length > VW_WEBP_TEXT_LIMIT_BYTES) return false;
    size_t digits = length - (text[length - 1] == '=') - (text[length - 2] == '=');
    if (strspn(text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/") != digits) return false;
    if (sodium_base642bin(head, sizeof head, text, 16, NULL, &read_bytes, NULL, sodium_base64_VARIANT_ORIGINAL))
        return false;
    return read_bytes == sizeof head && !memcmp(head, "RIFF", 4) && !memcmp(head + 8, "WEBP", 4);
}

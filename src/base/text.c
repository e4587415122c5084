#include "base/text.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "viewworth/status.h"

// Unicode's characters that act instead of being shown, or are not shown: first and last of each range. Explicit
// bidirectional formatting (Unicode Standard Annex 9) can show a name as another one, and so can what is invisible.
// U+200C and U+200D stay: Persian and Indic names, and emoji, need them.
static const uint32_t acting_characters[][2] = {{0x00, 0x1f},      {0x7f, 0x9f},     {0xad, 0xad},     {0x61c, 0x61c},
                                                {0x180e, 0x180e},  {0x200b, 0x200b}, {0x200e, 0x200f}, {0x2028, 0x202e},
                                                {0x2060, 0x206f},  {0x3164, 0x3164}, {0xfeff, 0xfeff}, {0xfff9, 0xfffb},
                                                {0xe0000, 0xe007f}};

// Returns the number of bytes of the UTF-8 character at `text`, and the character; 0 if it is invalid (overlong, a
// surrogate, or beyond U+10FFFF).
static int decode_utf8(const unsigned char *text, uint32_t *character) {
    static const uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    int length = text[0] < 0x80 ? 1 : text[0] >= 0xf0 ? 4 : text[0] >= 0xe0 ? 3 : text[0] >= 0xc0 ? 2 : 0;
    if (!length || text[0] >= 0xf8) return 0;
    *character = length == 1 ? text[0] : text[0] & (0x7fu >> length);
    for (int i = 1; i < length; i++) {
        if ((text[i] & 0xc0) != 0x80) return 0; // also the end of the text
        *character = *character << 6 | (text[i] & 0x3fu);
    }
    bool surrogate = *character >= 0xd800 && *character < 0xe000;
    return *character < smallest[length] || surrogate || *character > 0x10ffff ? 0 : length;
}

// Returns the number of bytes of the character at `text` if it may be shown, otherwise 0.
static int shown_bytes(const char *text) {
    uint32_t character = 0;
    int length = decode_utf8((const unsigned char *)text, &character);
    for (size_t i = 0; i < VW_ARRAY_COUNT(acting_characters); i++)
        if (character >= acting_characters[i][0] && character <= acting_characters[i][1]) return 0;
    return length;
}

bool vw_text_is_clean(const char *text) {
    while (*text) {
        int length = shown_bytes(text);
        if (!length) return false;
        text += length;
    }
    return true;
}

// Replaces a character that may not be shown, and each byte that does not belong to a character, by one '?'.
static void make_harmless(char *text, bool keep_line_ends) {
    char *to = text;
    while (*text) {
        uint32_t character = 0;
        int shown = keep_line_ends && *text == '\n' ? 1 : shown_bytes(text);
        int length = shown ? shown : decode_utf8((unsigned char *)text, &character);
        if (shown) memmove(to, text, (size_t)shown);
        else *to = '?';
        to += shown ? shown : 1;
        text += length ? length : 1;
    }
    *to = 0;
}

static uint32_t lesser(uint32_t a, uint32_t b) { return a < b ? a : b; }

// Counts the letters to insert, remove, replace or exchange with a neighbour until one word is the other. At least 1 if
// they differ; words of 64 bytes or more count as far apart (UINT32_MAX).
static uint32_t distance_of(const char *a, const char *b) {
    enum { LENGTH_MOST = 63 };
    uint32_t table[LENGTH_MOST + 1][LENGTH_MOST + 1]; // distances of their first i and j letters
    size_t a_length = strlen(a), b_length = strlen(b);
    if (a_length > LENGTH_MOST || b_length > LENGTH_MOST) return UINT32_MAX;
    for (uint32_t i = 0; i <= a_length; i++)
        for (uint32_t j = 0; j <= b_length; j++) {
            uint32_t *distance = &table[i][j];
            *distance = i + j; // right where one of them is empty
            if (!i || !j) continue;
            *distance = lesser(table[i - 1][j], table[i][j - 1]) + 1;
            *distance = lesser(*distance, table[i - 1][j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                *distance = lesser(*distance, table[i - 2][j - 2] + 1);
        }
    return table[a_length][b_length];
}

void vw_take_nearer(const char *word, const char *name, uint32_t *least, const char **nearest) {
    uint32_t distance = distance_of(word, name);
    if (distance >= *least || distance > strlen(word) / 3) return;
    *least = distance;
    *nearest = name;
}

const char *vw_plural(uint64_t count) { return count == 1 ? "" : "s"; }

size_t vw_text_shared_folder(const char *name, size_t length, const char *other) {
    size_t shared = 0;
    while (shared < length && name[shared] == other[shared]) shared++;
    while (shared && name[shared - 1] != '/') shared--;
    return shared;
}

void vw_text_make_line(char *text) { make_harmless(text, false); }

void vw_text_make_lines(char *text) { make_harmless(text, true); }

// ---- Lists of words ----

bool vw_word_list_next(const char **rest, struct vw_word *word) {
    if (!*rest) return false;
    *word = (struct vw_word){*rest, strcspn(*rest, ",")};
    *rest = (*rest)[word->length] ? *rest + word->length + 1 : NULL;
    return true;
}

bool vw_word_is(struct vw_word word, const char *name) {
    return strlen(name) == word.length && !strncmp(word.text, name, word.length);
}

bool vw_word_list_has(const char *list, const char *name) {
    struct vw_word word;
    while (vw_word_list_next(&list, &word))
        if (vw_word_is(word, name)) return true;
    return false;
}

void vw_text_duration(double seconds, char text[VW_DURATION_BYTES]) {
    if (seconds < 99.5) snprintf(text, VW_DURATION_BYTES, "%.*f s", seconds >= 0.05 && seconds < 9.95, seconds);
    else if (seconds < 99.5 * 60) snprintf(text, VW_DURATION_BYTES, "%.0f min", seconds / 60);
    else snprintf(text, VW_DURATION_BYTES, "%.*f h", seconds < 9.95 * 3600, seconds / 3600);
}

void vw_text_about(double seconds, char text[VW_ABOUT_BYTES]) {
    char time[VW_DURATION_BYTES];
    *text = 0;
    if (isnan(seconds)) return;
    vw_text_duration(seconds, time);
    snprintf(text, VW_ABOUT_BYTES, ", about %s", time);
}

// Text from files is data: what may be shown, and how the rest is made harmless.
#ifndef VIEWWORTH_BASE_TEXT_H
#define VIEWWORTH_BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Returns whether a text is UTF-8 that changes only its own place on a terminal: no control characters (C0, DEL, C1),
// no line or paragraph separators, no marks, embeddings, overrides or isolates of the writing direction, no invisible
// tags. Such a text can be in JSON and in one-line messages. vw_text_make_line() (viewworth/status.h) leaves it
// unchanged.
bool vw_text_is_clean(const char *text);
// Replaces the same characters as vw_text_make_line(), but keeps line ends (LF).
void vw_text_make_lines(char *text);

// Writes a duration for people: "45 s", "3 min", "2.5 h".
enum { VW_DURATION_BYTES = 32 };
void vw_text_duration(double seconds, char text[VW_DURATION_BYTES]);
// Writes ", about 3 min"; nothing for NaN, which is unknown.
enum { VW_ABOUT_BYTES = VW_DURATION_BYTES + 8 };
void vw_text_about(double seconds, char text[VW_ABOUT_BYTES]);

// Takes a name as the nearest one to a word if it is nearer than `*least`, which begins at UINT32_MAX, and so near that
// a slip may have made the word of it: one edit for three letters.
void vw_take_nearer(const char *word, const char *name, uint32_t *least, const char **nearest);
// Returns the ending of a noun after a number: "%u photo%s".
const char *vw_plural(uint64_t count);
// Returns how many bytes of a name, of its first `length`, are a folder in which `other` lies too; a '/' ends them.
size_t vw_text_shared_folder(const char *name, size_t length, const char *other);

// ---- Lists that options take: words with commas between, "rays,samples"; an empty list is one empty word ----

// A word within a list; not terminated. For printf: "%.*s", (int)word.length, word.text.
struct vw_word {
    const char *text; // borrowed
    size_t length;    // bytes
};

// Reads the next word and moves `*rest` after it. `*rest` is the list at first and NULL after the last word; false if
// it is NULL.
bool vw_word_list_next(const char **rest, struct vw_word *word);
bool vw_word_is(struct vw_word word, const char *name);
// Returns whether a list has a word; false if the list is NULL.
bool vw_word_list_has(const char *list, const char *name);

#endif

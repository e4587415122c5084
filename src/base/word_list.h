// Lists that options take: words with commas between, "rays,samples". An empty list is one empty word.
#ifndef VIEWWORTH_BASE_WORD_LIST_H
#define VIEWWORTH_BASE_WORD_LIST_H

#include <stdbool.h>
#include <stddef.h>

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

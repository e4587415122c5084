#include "base/word_list.h"

#include <string.h>

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

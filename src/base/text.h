// Text from files is data: what may be shown, and how the rest is made harmless.
#ifndef VIEWWORTH_BASE_TEXT_H
#define VIEWWORTH_BASE_TEXT_H

#include <stdbool.h>

// Returns whether a text is UTF-8 that changes only its own place on a terminal: no control characters (C0, DEL, C1),
// no line or paragraph separators, no marks, embeddings, overrides or isolates of the writing direction, no invisible
// tags. Such a text can be in JSON and in one-line messages. vw_text_make_line() (viewworth/status.h) leaves it
// unchanged.
bool vw_text_is_clean(const char *text);
// Replaces the same characters as vw_text_make_line(), but keeps line ends (LF).
void vw_text_make_lines(char *text);

#endif

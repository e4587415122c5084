// Streams and signals as a program inherits them from the process that starts it.
#ifndef VIEWWORTH_BASE_STREAMS_H
#define VIEWWORTH_BASE_STREAMS_H

#include <stdbool.h>

// Prepares a program; it calls this before anything else. A standard stream that is closed becomes one that
// cannot be written, so that no file gets its number and then the messages meant for it. A write that cannot be
// done, into a pipe without a reader or beyond the limit of file sizes, fails instead of killing the program. False if
// a stream cannot be opened.
bool vw_streams_prepare(void);

#endif

#include "base/streams.h"

#include <fcntl.h>
#include <signal.h>

enum { STANDARD_STREAMS = 3 };

bool vw_streams_prepare(void) {
    for (int stream = 0; stream < STANDARD_STREAMS; stream++)
        if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDONLY) != stream)
            return false; // the lowest that is free
    return signal(SIGPIPE, SIG_IGN) != SIG_ERR && signal(SIGXFSZ, SIG_IGN) != SIG_ERR;
}

// Starts and ends the program viewworth-decode. Internal to decoder.c.
#ifndef VIEWWORTH_IMAGE_DECODER_SERVER_H
#define VIEWWORTH_IMAGE_DECODER_SERVER_H

#include <stdbool.h>
#include <sys/types.h>

#include "viewworth/status.h"

struct vw_decoder_server {
    pid_t process;
    int socket;
};

// Starts the program at `path` (NULL: beside this code, or where it is installed) and waits until it has loaded its
// libraries. VW_ERROR_IO if it is missing or of another version.
enum vw_status vw_decoder_server_start(const char *path, bool without_seccomp, struct vw_decoder_server *server);
// Ends it with all its workers, and leaves no zombie.
void vw_decoder_server_stop(struct vw_decoder_server *server);

#endif

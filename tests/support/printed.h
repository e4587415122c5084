// Text that a function prints, caught.
#ifndef VIEWWORTH_TESTS_SUPPORT_PRINTED_H
#define VIEWWORTH_TESTS_SUPPORT_PRINTED_H

#include <fcntl.h>
#include <unistd.h>

#include "support/temporary_folder.h"

// Returns what `print` writes to a stream; to be freed.
static inline char *printed_on(FILE *stream, void (*print)(const void *), const void *context) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "printed");
    int kept = dup(fileno(stream)), file = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);
    fflush(stream);
    dup2(file, fileno(stream));
    print(context);
    fflush(stream);
    dup2(kept, fileno(stream));
    close(kept);
    close(file);
    return temporary_read(path, NULL);
}

#endif

#include "scene/formats/name_list.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

static const size_t LIST_LIMIT_BYTES = (size_t)1 << 26;

static char *trim(char *line) {
    while (isspace((unsigned char)*line)) line++;
    char *end = line + strlen(line);
    while (end > line && isspace((unsigned char)end[-1])) end--;
    *end = 0;
    return line;
}

enum vw_status vw_names_read(const char *path, vw_name_taker *take, void *context, uint32_t *count) {
    void *text;
    size_t size_bytes;
    *count = 0;
    enum vw_status status = vw_file_read(path, LIST_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    char *rest = text;
    for (int line = 1; !status && rest; line++) {
        char *name = trim(strsep(&rest, "\n"));
        if (!*name) continue;
        status = take(context, line, name);
        ++*count;
    }
    free(text);
    return status;
}

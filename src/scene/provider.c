// Who supplied which view: a CSV file with the header name,provider.
#include <stdlib.h>
#include <string.h>

#include "scene/draft.h"
#include "viewworth/file.h"
#include "viewworth/memory.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 28;

// Cuts the next field off `*rest` (NULL after the last), in place: plain, or "quoted, with doubled "" inside". False when a quote
// stays open.
static bool next_field(char **rest, char **field) {
    char *from = *rest;
    if (*from != '"') {
        *field = strsep(rest, ",");
        return true;
    }
    char *to = *field = ++from;
    while (*from && (*from != '"' || from[1] == '"')) {
        from += *from == '"';
        *to++ = *from++;
    }
    if (*from != '"' || (from[1] && from[1] != ',')) return false;
    *rest = from[1] ? from + 2 : NULL;
    *to = 0;
    return true;
}

static enum vw_status read_row(const char *path, int line, char *row, struct vw_scene *scene) {
    char *name, *provider, *rest = row;
    if (!next_field(&rest, &name) || !rest || !next_field(&rest, &provider) || rest)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: not two fields; write name,provider", path, line);
    if (line == 1) {
        if (!strcmp(name, "name") && !strcmp(provider, "provider")) return VW_OK;
        return vw_fail(VW_ERROR_INPUT, "%s:1: the header is not name,provider; add it", path);
    }
    struct vw_view *view = vw_scene_find_named(scene, name);
    if (!view) return vw_fail(VW_ERROR_INPUT, "%s:%d: %s is not in the scene; write names as the scene file spells them", path, line, name);
    if (*view->provider) return vw_fail(VW_ERROR_INPUT, "%s:%d: %s has a provider already; keep one row of it", path, line, name);
    char *copy = vw_copy_text(provider);
    if (!copy) return VW_ERROR_MEMORY;
    free(view->provider);
    view->provider = copy;
    return VW_OK;
}

enum vw_status vw_providers_read(const char *path, struct vw_scene *scene) {
    void *text;
    size_t size_bytes;
    enum vw_status status = vw_file_read(path, FILE_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    char *rest = text;
    for (int line = 1; !status && rest; line++) {
        char *row = strsep(&rest, "\n");
        row[strcspn(row, "\r")] = 0;
        if (*row || line == 1) status = read_row(path, line, row, scene);
    }
    free(text);
    return status;
}

// Reads who supplied each view, from a CSV file with the header name,provider.
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 26;

static enum vw_status read_header(const struct vw_csv *csv) {
    if (csv->field_count == 2 && !strcmp(csv->fields[0], "name") && !strcmp(csv->fields[1], "provider")) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s:%u: the header must be name,provider; add it", csv->path, csv->line);
}

static enum vw_status read_row(const struct vw_csv *csv, struct vw_scene *scene) {
    if (csv->field_count != 2)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: there must be two fields; write name,provider", csv->path, csv->line);
    const char *name = csv->fields[0];
    struct vw_view *view = vw_scene_find_named(scene, name);
    if (!view)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %s is not in the scene; write names as the scene file spells them",
                       csv->path, csv->line, name);
    if (*view->provider)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %s has a provider already; keep one row of it", csv->path, csv->line,
                       name);
    if (!vw_text_is_clean(csv->fields[1]))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: the provider's name has control characters or is not UTF-8; correct it",
                       csv->path, csv->line);
    char *copy = vw_copy_text(csv->fields[1]);
    if (!copy) return VW_ERROR_MEMORY;
    free(view->provider);
    view->provider = copy;
    return VW_OK;
}

enum vw_status vw_providers_read(const char *path, struct vw_scene *scene) {
    struct vw_csv csv;
    bool found = false;
    enum vw_status status = vw_csv_open(path, FILE_LIMIT_BYTES, &csv);
    if (!status) status = vw_csv_next(&csv, &found);
    if (!status) status = read_header(&csv);
    while (!status && !(status = vw_csv_next(&csv, &found)) && found) status = read_row(&csv, scene);
    vw_csv_close(&csv);
    return status;
}

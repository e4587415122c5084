#include <stdlib.h>

#include "base/memory.h"
#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"

static uint32_t count_unknown(const struct vw_checked *checked) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < checked->row_count; i++)
        count += checked->rows[i].evidence->in_place != checked->rows[i].evidence->in_place; // NaN
    return count;
}

// Lists the rows that have a defect.
static enum vw_status list_found(const struct vw_checked *checked, struct vw_check_row **found, uint32_t *count) {
    *found = vw_allocate(checked->row_count, sizeof **found);
    if (!*found) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < checked->row_count; i++)
        if (checked->rows[i].defect) (*found)[(*count)++] = checked->rows[i];
    return VW_OK;
}

static json_t *to_json(const struct vw_checked *checked, uint32_t found_count) {
    const struct vw_rows rows = vw_check_rows(checked->rows, checked->row_count);
    return json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:f, s:s*, s:I, s:o}", "scene", checked->scene->path, "photos",
                     (json_int_t)checked->row_count, "found", (json_int_t)found_count, "unknown",
                     (json_int_t)count_unknown(checked), "points", (json_int_t)checked->check->point_count,
                     "made_points", (json_int_t)checked->check->made_count, "seconds", checked->seconds, "copy",
                     checked->copy, "mended", (json_int_t)checked->mended_count, "checks", vw_rows_to_json(&rows));
}

static void print(const struct vw_checked *checked, const struct vw_check_row *found, uint32_t found_count) {
    uint32_t unknown = count_unknown(checked);
    vw_print("checked  %u photos in %.1f s, by %u points of the scene and %u places that photos show alike\n",
             checked->row_count, checked->seconds, checked->check->point_count, checked->check->made_count);
    if (unknown)
        vw_print("unknown  the pose of %u photo%s, which share%s too little with other photos\n", unknown,
                 vw_plural(unknown), unknown == 1 ? "s" : "");
    vw_print("found    %u photo%s to look at\n", found_count, vw_plural(found_count));
    if (checked->table) vw_print("table    %s\n", checked->table);
    if (checked->copy) {
        vw_print("copy    ");
        vw_print_shell_path(checked->copy);
        vw_print(" (%u photo%s where found; images, masks, sparse/0, transforms.json)\n", checked->mended_count,
                 vw_plural(checked->mended_count));
    }
    if (!found_count) return;
    const struct vw_rows rows = vw_check_text_rows(found, found_count);
    vw_print("\n");
    vw_print_rows(&rows);
}

enum vw_status vw_check_print(const struct vw_checked *checked, bool json) {
    struct vw_check_row *found = NULL;
    uint32_t count = 0;
    enum vw_status status = list_found(checked, &found, &count);
    if (!status && json) status = vw_json_print(to_json(checked, count));
    else if (!status) print(checked, found, count);
    free(found);
    return status;
}

#include "run/recorded/selection_list.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "run/imported/imported_run.h"
#include "scene/formats/photo_list.h"

static enum vw_split split_of(const char *name) {
    enum vw_split split = VW_SPLIT_TRAIN;
    while (split < VW_SPLIT_EXCLUDED && strcmp(name, vw_split_name(split)) != 0) split++;
    return split;
}

enum vw_status vw_selection_list_write(const struct vw_scored_run *run, const struct vw_selection *selection,
                                       const char *to, struct vw_selection_list *list) {
    struct vw_listed_photo *photos = vw_allocate(run->image_count, sizeof *photos);
    if (!photos) return VW_ERROR_MEMORY;
    *list = (struct vw_selection_list){0};
    for (uint32_t i = 0; i < run->image_count; i++) {
        photos[i] = (struct vw_listed_photo){run->images[i].name, split_of(run->images[i].split), false};
        list->train_count += photos[i].split == VW_SPLIT_TRAIN;
    }
    for (uint32_t i = 0; i < selection->count; i++) {
        const struct vw_ledger_image *image =
            vw_ledger_find_image(run->images, run->image_count, selection->image_ids[i]);
        photos[image - run->images].chosen = true;
    }
    const struct vw_photo_list written = {
        .scene_path = vw_is_imported(&run->recorded.row) ? NULL : run->recorded.row.scene_path,
        .scene_format = json_string_value(json_object_get(run->scene_options, "format")),
        .photos = photos,
        .photo_count = run->image_count,
        .to = to,
    };
    enum vw_status status = vw_photo_list_write(&written, &list->format, &list->opens);
    free(photos);
    return status;
}

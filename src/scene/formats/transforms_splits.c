#include <string.h>

#include "scene/builder.h"
#include "scene/formats/transforms.h"

static const char *const keys[VW_SPLIT_EXCLUDED] = {"train_filenames", "val_filenames",
                                                    "test_filenames"}; // by enum vw_split

const char *vw_transforms_split_key(enum vw_split split) { return keys[split]; }

static enum vw_status read_names(const char *path, const json_t *names, enum vw_split split, json_t *splits) {
    if (!json_is_array(names))
        return vw_fail(VW_ERROR_INPUT, "%s: field %s is not a list of file paths; correct it or leave it out", path,
                       keys[split]);
    for (size_t i = 0; i < json_array_size(names); i++) {
        const char *name = json_string_value(json_array_get(names, i));
        if (!name)
            return vw_fail(VW_ERROR_INPUT, "%s: field %s: entry %zu is not a text; name a frame's photo", path,
                           keys[split], i);
        name = vw_view_name_of(name);
        const json_t *other = json_object_get(splits, name);
        if (other && json_integer_value(other) != (json_int_t)split)
            return vw_fail(VW_ERROR_INPUT, "%s: %s is in two splits, %s and %s; keep it in one", path, name,
                           keys[json_integer_value(other)], keys[split]);
        if (!other && json_object_set_new(splits, name, json_integer((json_int_t)split)))
            return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for %s", path, keys[split]);
    }
    return VW_OK;
}

enum vw_status vw_transforms_read_splits(const char *path, const json_t *file, json_t **splits) {
    json_t *read = NULL;
    enum vw_status status = VW_OK;
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++) {
        const json_t *names = json_object_get(file, keys[split]);
        if (!names) continue;
        if (!read) read = json_object();
        status = read ? read_names(path, names, split, read)
                      : vw_fail(VW_ERROR_MEMORY, "%s: out of memory for splits", path);
    }
    if (status) json_decref(read);
    else *splits = read;
    return status;
}

#include "train/files/field_file.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "train/files/hashed_file.h"

static const char magic[] = "viewworth field 1\n", remedy[] = "train again with viewworth train";

// Describes a field by the config's identity, the box and the effects that are on; the caller owns the text.
static char *describe(const struct vw_trained_field *trained) {
    const struct vw_model *model = trained->field->model;
    const struct vw_box *box = &model->box;
    char *identity = vw_config_to_json(trained->config, true);
    json_t *effects = json_array();
    for (uint32_t i = 0; i < trained->effect_count; i++)
        if (trained->effects[i].on) vw_json_append(&effects, json_string(trained->effects[i].name));
    json_t *object =
        identity ? json_pack("{s:o, s:[f,f,f], s:f, s:o, s:I}", "config",
                             vw_json_load(identity, strlen(identity), 0, NULL), "box_centre_world",
                             box->centre_world[0], box->centre_world[1], box->centre_world[2], "box_half_extent_world",
                             box->half_extent_world, "effects", effects, "param_bytes", (json_int_t)model->param_bytes)
                 : NULL;
    char *text = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    free(identity);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the field's description");
    return text;
}

enum vw_status vw_field_file_save(const char *path, const struct vw_trained_field *trained,
                                  const struct vw_file_binding *binding) {
    char *description = describe(trained);
    const struct vw_buffer_list params = {&trained->field->params, 1};
    enum vw_status status =
        description ? vw_hashed_file_save(path, magic, description, &params, binding) : VW_ERROR_MEMORY;
    free(description);
    return status;
}

enum vw_status vw_field_file_open(const char *path, const char *description, uint64_t param_bytes,
                                  struct vw_hashed_file *file) {
    enum vw_status status = vw_hashed_file_open(path, magic, param_bytes, remedy, file);
    if (status || (!strcmp(file->description, description) && file->payload_bytes == param_bytes)) return status;
    vw_hashed_file_close(file);
    return vw_fail(VW_ERROR_INPUT, "%s: trained with another configuration, box or effects than this run's; %s", path,
                   remedy);
}

enum vw_status vw_field_file_load(const char *path, const struct vw_trained_field *trained,
                                  const struct vw_file_binding *binding) {
    struct vw_hashed_file file;
    char *description = describe(trained);
    if (!description) return VW_ERROR_MEMORY;
    enum vw_status status = vw_field_file_open(path, description, trained->field->model->param_bytes, &file);
    free(description);
    if (status) return status;
    status = vw_hashed_file_check_kept(&file, path, remedy, binding);
    if (!status) status = vw_hashed_file_load(&file, &(struct vw_buffer_list){&trained->field->params, 1});
    vw_hashed_file_close(&file);
    return status;
}

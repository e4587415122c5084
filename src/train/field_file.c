// OUT/field.vwf: the params block, and what must agree for it to be rendered.
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "train/hashed_file.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

static const char magic[] = "viewworth field 1\n";

// The config's identity, the box, and the effects that are on; owned by the caller.
static char *describe(const struct vw_trainer *trainer) {
    const struct vw_box *box = &trainer->model.box;
    const struct vw_config config = vw_config_without_probes(&trainer->config);
    char *identity = vw_config_to_json(&config, true);
    json_t *effects = json_array();
    for (uint32_t i = 0; i < trainer->effect_count; i++)
        if (trainer->effects[i].on) json_array_append_new(effects, json_string(trainer->effects[i].name));
    json_t *object = identity ? json_pack("{s:o?, s:[f,f,f], s:f, s:o, s:I}", "config", json_loads(identity, 0, NULL),
                                          "box_centre_world", box->centre_world[0], box->centre_world[1],
                                          box->centre_world[2], "box_half_extent_world", box->half_extent_world,
                                          "effects", effects, "param_bytes", (json_int_t)trainer->model.param_bytes)
                              : NULL;
    char *text = object ? json_dumps(object, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
    json_decref(object);
    free(identity);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the field's description");
    return text;
}

enum vw_status vw_trainer_save_field(struct vw_trainer *trainer, const char *path) {
    char *description = describe(trainer);
    enum vw_status status =
        description ? hashed_file_save(path, magic, description, &(struct buffer_list){&trainer->field.params, 1})
                    : VW_ERROR_MEMORY;
    free(description);
    return status;
}

enum vw_status vw_trainer_load_field(struct vw_trainer *trainer, const char *path) {
    char *description = describe(trainer);
    if (!description) return VW_ERROR_MEMORY;
    struct hashed_file file;
    enum vw_status status =
        hashed_file_open(path, magic, trainer->model.param_bytes, "train again with viewworth train", &file);
    if (status == VW_OK) {
        if (strcmp(file.description, description) || file.payload_bytes != trainer->model.param_bytes)
            status =
                vw_fail(VW_ERROR_INPUT, "%s: trained with another configuration, box or effects than this run's", path);
        else status = hashed_file_load(&file, &(struct buffer_list){&trainer->field.params, 1});
        hashed_file_close(&file);
    }
    free(description);
    return status;
}

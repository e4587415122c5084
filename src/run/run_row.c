#include "run/run_row.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "detect/effects_text.h"
#include "train/identity.h"
#include "train/trainer.h"
#include "viewworth/version.h"

static json_t *find_effect(const json_t *array, const char *name) {
    size_t i;
    json_t *entry;
    json_array_foreach(array, i, entry) {
        const char *its_name = json_string_value(json_object_get(entry, "name"));
        if (its_name && strcmp(its_name, name) == 0) return entry;
    }
    return NULL;
}

// Finds the effect whose box the field sees; NULL when the field sees the scene's box.
static json_t *find_box_effect(const json_t *array) {
    static const char *const names[] = {"unbounded", "wide_box"}; // the first one wins
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        json_t *entry = find_effect(array, names[i]);
        if (json_is_true(json_object_get(entry, "on"))) return entry;
    }
    return NULL;
}

// Adds the box of an effect, which run_id covers.
static bool add_box(json_t *array, const struct vw_box *box) {
    return !box || !json_object_set_new(find_box_effect(array), "box",
                                        json_pack("[f, f, f, f]", box->centre_world[0], box->centre_world[1],
                                                  box->centre_world[2], box->half_extent_world));
}

// Adds the exposures to the effect appearance, by photo: gains minus 1, then biases. run_id covers them, too.
static bool add_exposures(json_t *array, const struct vw_run_exposure *exposures, uint32_t count) {
    json_t *object = count ? json_object() : NULL;
    for (uint32_t i = 0; i < count; i++) {
        const double *n = exposures[i].numbers;
        vw_json_set(&object, exposures[i].photo, json_pack("[f, f, f, f, f, f]", n[0], n[1], n[2], n[3], n[4], n[5]));
    }
    return !count || !json_object_set_new(find_effect(array, "appearance"), "exposures", object);
}

static enum vw_status make_effects_json(const struct vw_trainer *trainer, char **text) {
    uint32_t count = 0, exposure_count = 0;
    struct vw_run_exposure *exposures = NULL;
    const struct vw_effect_decision *decisions = vw_trainer_effects(trainer, &count);
    enum vw_status status = vw_trainer_list_exposures(trainer, &exposures, &exposure_count);
    json_t *array = status ? NULL : vw_effects_to_json(decisions, count);
    bool whole =
        array && add_box(array, vw_trainer_effect_box(trainer)) && add_exposures(array, exposures, exposure_count);
    *text = whole ? vw_json_to_text(array, JSON_COMPACT) : NULL;
    json_decref(array);
    free(exposures);
    if (status || *text) return status;
    return vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the effects");
}

enum vw_status vw_run_row_make(const struct vw_trainer *trainer, const struct vw_gpu *gpu, const struct vw_scene *scene,
                               const struct vw_config *config, struct vw_run_row *row) {
    uint8_t run_id[VW_HASH_BYTES], subset[VW_HASH_BYTES], shaders[VW_HASH_BYTES];
    const struct vw_gpu_info *device = vw_gpu_get_info(gpu);
    *row = (struct vw_run_row){.config_json = vw_config_to_json(config, false)};
    if (!row->config_json) return VW_ERROR_MEMORY;
    enum vw_status status = make_effects_json(trainer, &row->effects_json);
    if (!status) status = vw_trainer_run_id(trainer, run_id);
    if (status) return status;
    vw_trainer_subset_hash(trainer, subset);
    vw_shader_hash(shaders);
    vw_hash_to_hex(run_id, row->run_id);
    vw_hash_to_hex(subset, row->subset_hash);
    vw_hash_to_hex(shaders, row->shader_hash);
    vw_hash_to_hex(scene->hash, row->scene_hash);
    row->row = (struct vw_ledger_run){
        .run_id = row->run_id,
        .scene_hash = row->scene_hash,
        .scene_path = scene->path,
        .seed = (int64_t)config->seed,
        .config_json = row->config_json,
        .subset_hash = row->subset_hash,
        .device = device->name,
        .driver = device->driver,
        .shader_hash = row->shader_hash,
        .version = vw_version(),
        .effects_json = row->effects_json,
    };
    return VW_OK;
}

void vw_run_row_free(struct vw_run_row *row) {
    free(row->config_json);
    free(row->effects_json);
}

// ---- Comparison ----------------------------------------------------------------------------------------------------

static json_t *identity_of(const char *config_json) {
    struct vw_config config;
    char *text = vw_config_from_json(config_json, &config) ? NULL : vw_config_to_json(&config, true);
    json_t *identity = text ? vw_json_load(text, strlen(text), 0, NULL) : NULL;
    free(text);
    return identity;
}

static char *value_to_text(const json_t *value) {
    return vw_json_to_text(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(15));
}

static enum vw_status refuse_value(const char *key, const json_t *ours, const json_t *recorded, const char *out) {
    char *here = value_to_text(ours), *there = value_to_text(recorded);
    enum vw_status status =
        vw_fail(VW_ERROR_USAGE, "the run in %s has %s = %s, not %s; give the same options, or another --out", out, key,
                there ? there : "nothing", here ? here : "nothing");
    free(here);
    free(there);
    return status;
}

// Returns whether a field differs because another one does, which the user gives and the message names: base_seed is 0
// where everything varies.
static bool follows_from_another(const char *key, const json_t *ours, const json_t *recorded) {
    return strcmp(key, "base_seed") == 0 &&
           !json_equal(json_object_get(ours, "vary"), json_object_get(recorded, "vary"));
}

// Refuses the first field that differs, if any.
static enum vw_status check_config(const char *ours_json, const char *recorded_json, const char *out) {
    json_t *ours = identity_of(ours_json), *recorded = identity_of(recorded_json), *all = json_object(), *value;
    enum vw_status status = VW_OK;
    const char *key;
    if (all && !json_object_update(all, recorded) && !json_object_update(all, ours)) {
        json_object_foreach(all, key, value) {
            const json_t *here = json_object_get(ours, key), *there = json_object_get(recorded, key);
            if (status || json_equal(here, there) || follows_from_another(key, ours, recorded)) continue;
            status = refuse_value(key, here, there, out);
        }
    }
    json_decref(ours);
    json_decref(recorded);
    json_decref(all);
    return status;
}

enum vw_status vw_run_row_check_same(const struct vw_run_row *ours, const struct vw_ledger_run *recorded,
                                     const char *out) {
    if (strcmp(ours->row.run_id, recorded->run_id) == 0) return VW_OK;
    const struct {
        const char *what, *ours, *recorded;
    } columns[] = {
        {"other photos to train on", ours->row.subset_hash, recorded->subset_hash},
        {"another scene, or one that has changed since", ours->row.scene_hash, recorded->scene_hash},
        {"another version of viewworth", ours->row.version, recorded->version},
        {"other shaders (another build of viewworth)", ours->row.shader_hash, recorded->shader_hash},
        {"another device", ours->row.device, recorded->device},
        {"another driver", ours->row.driver, recorded->driver},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(columns); i++)
        if (strcmp(columns[i].ours, columns[i].recorded) != 0)
            return vw_fail(
                VW_ERROR_USAGE,
                "the run in %s has %s (%.64s, here %.64s) and cannot be continued bit for bit; use what it was made "
                "with",
                out, columns[i].what, columns[i].recorded, columns[i].ours);
    enum vw_status status = check_config(ours->row.config_json, recorded->config_json, out);
    if (status) return status;
    return vw_fail(
        VW_ERROR_USAGE,
        "the run in %s was made with other --effects, or by train instead of value, or the reverse; repeat its "
        "command",
        out);
}

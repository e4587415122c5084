#include "run/identity.h"

#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "run/effects_text.h"
#include "train/trainer.h"
#include "viewworth/version.h"
#include "base/hash.h"
#include "base/memory.h"

static enum vw_status make_effects_json(const struct vw_trainer *trainer, char **text) {
    uint32_t count = 0;
    const struct vw_effect_verdict *verdicts = vw_trainer_effects(trainer, &count);
    json_t *array = vw_effects_to_json(verdicts, count);
    *text = array ? json_dumps(array, JSON_COMPACT) : NULL;
    json_decref(array);
    return *text ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the effects");
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
    return value ? json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(15)) : NULL;
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

// These are part of the identity only with same_state and vary, which the user gives: a run that lacks them lacks
// those, too, and the message names those.
static bool follows_from_another(const char *key) {
    return strcmp(key, "epochs") == 0 || strcmp(key, "base_seed") == 0;
}

// The first field that differs, if any. A field that one of both lacks is at its default there.
static enum vw_status check_config(const char *ours_json, const char *recorded_json, const char *out) {
    json_t *ours = identity_of(ours_json), *recorded = identity_of(recorded_json), *all = json_object(), *value;
    enum vw_status status = VW_OK;
    const char *key;
    if (all && !json_object_update(all, recorded) && !json_object_update(all, ours)) {
        json_object_foreach(all, key, value) {
            const json_t *here = json_object_get(ours, key), *there = json_object_get(recorded, key);
            if (status || json_equal(here, there) || (follows_from_another(key) && !(here && there))) continue;
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

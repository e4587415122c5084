// The decisions of pilots, kept from run to run: the same scene, pilots, device and version decide at once, and alike.
//
// A file per search in the user's cache folder (base/cache.h): a BLAKE2b-256 of its key and of what follows, in hex, a
// line end, and the decisions as run.effects_json. A file that is damaged or of another key counts as missing, and the
// pilots are made again. No cache is worth an error. Files are replaced as a whole, so that several programs may share
// the folder.
#include "detect/decide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/cache.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "detect/effects_text.h"
#include "detect/pilots.h"
#include "train/effects/field_box.h"
#include "train/effects/registry.h"
#include "train/trainer.h"

enum { FILE_BYTES_MAX = 1 << 16, HEX_LENGTH = VW_HASH_HEX_BYTES - 1 };

// ---- Names ----------------------------------------------------------------------------------------------------------

// Hashes everything that decides the result of pilots, and --effects, which says where the search begins.
static enum vw_status hash_key(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned,
                               uint8_t key[VW_HASH_BYTES]) {
    const struct vw_gpu_info *device = vw_gpu_get_info(gpu);
    const char *width = getenv("LP_NATIVE_VECTOR_WIDTH"); // changes the code that lavapipe makes
    struct vw_config pilot = vw_pilots_config(planned, vw_pilot_steps(scene, planned)); // its epochs tell the steps
    char *config = vw_config_to_json(&pilot, false);
    uint8_t shaders[VW_HASH_BYTES];
    struct vw_hasher hasher;
    struct vw_box inner, wide;
    if (!config || vw_contraction_box(scene, NULL, 0, &inner) || vw_wide_box(scene, &wide)) {
        free(config);
        return VW_ERROR_MEMORY;
    }
    vw_shader_hash(shaders);
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth decisions 5");
    vw_hasher_add_bytes(&hasher, scene->hash, sizeof scene->hash);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher, vw_pilot_steps_in_doubt(scene, planned));
    vw_hasher_add_integer(&hasher, planned->field == VW_FIELD_SPLATS); // which may have fewer effects
    for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, inner.centre_world[i]);
    vw_hasher_add_real(&hasher, inner.half_extent_world);
    vw_hasher_add_real(&hasher, wide.half_extent_world);
    vw_hasher_add_text(&hasher, device->name);
    vw_hasher_add_text(&hasher, device->driver);
    vw_hasher_add_text(&hasher, width);
    vw_hasher_add_text(&hasher, vw_version());
    vw_hasher_add_bytes(&hasher, shaders, sizeof shaders);
    vw_hasher_end(&hasher, key);
    free(config);
    return VW_OK;
}

enum { NAME_BYTES = 64 };
static void name_file(const uint8_t key[VW_HASH_BYTES], char name[NAME_BYTES]) {
    char hex[VW_HASH_HEX_BYTES];
    vw_hash_to_hex(key, hex);
    snprintf(name, NAME_BYTES, "decisions-%.32s.json", hex);
}

static void hash_content(const uint8_t key[VW_HASH_BYTES], const char *json, char hex[VW_HASH_HEX_BYTES]) {
    uint8_t hash[VW_HASH_BYTES];
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_bytes(&hasher, key, VW_HASH_BYTES);
    vw_hasher_add_text(&hasher, json);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, hex);
}

// ---- Reading --------------------------------------------------------------------------------------------------------

static bool read_decisions(const char *name, const uint8_t key[VW_HASH_BYTES], struct vw_effect_decision *decisions,
                           uint32_t *count) {
    void *file = NULL;
    size_t size_bytes = 0;
    char hex[VW_HASH_HEX_BYTES];
    bool read = false;
    if (!vw_cache_read(name, FILE_BYTES_MAX, &file, &size_bytes)) return false;
    const char *text = file;
    if (size_bytes > HEX_LENGTH && text[HEX_LENGTH] == '\n' && strlen(text) == size_bytes) {
        hash_content(key, text + HEX_LENGTH + 1, hex);
        read = strncmp(text, hex, HEX_LENGTH) == 0 &&
               vw_effects_from_json(text + HEX_LENGTH + 1, decisions, count) == VW_OK;
    }
    free(file);
    return read;
}

// Puts what was measured once beside the facts, which are `decided`.
static void take_measured(const struct vw_effect_decision *kept, struct vw_effect_decision *decided, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        bool fact = isfinite(decided[i].threshold);
        if (!fact) decided[i] = kept[i];
    }
}

// ---- Writing --------------------------------------------------------------------------------------------------------

static void write_decisions(const char *name, const uint8_t key[VW_HASH_BYTES],
                            const struct vw_effect_decision *decisions, uint32_t count) {
    json_t *array = vw_effects_to_json(decisions, count);
    char *json = vw_json_to_text(array, JSON_COMPACT), hex[VW_HASH_HEX_BYTES];
    if (json) hash_content(key, json, hex);
    char *text = json ? vw_format_text("%s\n%s", hex, json) : NULL;
    if (text) vw_cache_write(name, text, strlen(text));
    json_decref(array);
    free(json);
    free(text);
}

// ---- Both -----------------------------------------------------------------------------------------------------------

enum vw_status vw_effects_decide_cached(struct vw_gpu *gpu, const struct vw_scene *scene,
                                        const struct vw_config *planned,
                                        struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count) {
    struct vw_effect_decision kept[VW_EFFECT_COUNT_MAX], decided[VW_EFFECT_COUNT_MAX];
    uint32_t kept_count = 0, decided_count = 0;
    uint8_t key[VW_HASH_BYTES];
    char name[NAME_BYTES];
    if (!vw_effects_need_pilots(gpu, scene, planned)) return vw_effects_decide(gpu, scene, planned, decisions, count);
    enum vw_status status = hash_key(gpu, scene, planned, key);
    if (status) return status;
    name_file(key, name);
    if (read_decisions(name, key, kept, &kept_count)) {
        status = vw_effects_find_facts(scene, planned->effects, decided, &decided_count);
        if (!status) take_measured(kept, decided, decided_count);
        if (!status) status = vw_effects_choose(planned->effects, decided, decided_count);
    } else {
        status = vw_effects_decide(gpu, scene, planned, decided, &decided_count);
        if (!status) write_decisions(name, key, decided, decided_count);
    }
    if (status) return status;
    memcpy(decisions, decided, decided_count * sizeof *decided);
    *count = decided_count;
    return VW_OK;
}

#include "gpu/shader_cache.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/cache.h"
#include "base/hash.h"
#include "base/memory.h"

enum { HASH_BYTES = 32, CACHE_BYTES_MAX = 256 << 20 };

static const char *vector_width(void) {
    const char *width = getenv("LP_NATIVE_VECTOR_WIDTH");
    return width ? width : "";
}

void vw_shader_cache_separate_widths(void) {
    const char *width = vector_width();
    char name[32];
    if (!*width || width[strspn(width, "0123456789")] || strlen(width) > 4 || getenv("MESA_SHADER_CACHE_DIR")) return;
    snprintf(name, sizeof name, "mesa-%s", width);
    char *path = vw_cache_folder(name);
    if (path) setenv("MESA_SHADER_CACHE_DIR", path, 1);
    free(path);
}

// Names the file for this device, driver and vector width.
static void name_file(struct vw_gpu *gpu) {
    VkPhysicalDeviceProperties device;
    struct vw_hasher hasher;
    uint8_t hash[HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    vkGetPhysicalDeviceProperties(gpu->chosen.physical, &device);
    vw_hasher_begin(&hasher);
    vw_hasher_add_integer(&hasher, device.vendorID);
    vw_hasher_add_integer(&hasher, device.deviceID);
    vw_hasher_add_integer(&hasher, device.driverVersion);
    vw_hasher_add_bytes(&hasher, device.pipelineCacheUUID, sizeof device.pipelineCacheUUID);
    vw_hasher_add_text(&hasher, vector_width());
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, hex);
    snprintf(gpu->pipeline_cache_name, sizeof gpu->pipeline_cache_name, "pipelines-%.16s.bin", hex);
}

// Reads a SHA-256 and the data that it covers: drivers do not check the data that they load.
static void read_file(struct vw_gpu *gpu, void **file, size_t *data_bytes) {
    size_t size_bytes = 0;
    *data_bytes = 0;
    if (!vw_cache_read(gpu->pipeline_cache_name, CACHE_BYTES_MAX, file, &size_bytes) || size_bytes < HASH_BYTES) return;
    uint8_t hash[HASH_BYTES];
    vw_sha256((uint8_t *)*file + HASH_BYTES, size_bytes - HASH_BYTES, hash);
    if (memcmp(*file, hash, HASH_BYTES)) return;
    memcpy(gpu->pipeline_cache_hash, hash, HASH_BYTES);
    *data_bytes = size_bytes - HASH_BYTES;
}

enum vw_status vw_shader_cache_open(struct vw_gpu *gpu) {
    void *file = NULL;
    size_t data_bytes;
    name_file(gpu);
    read_file(gpu, &file, &data_bytes);
    VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                      .initialDataSize = data_bytes,
                                      .pInitialData = data_bytes ? (uint8_t *)file + HASH_BYTES : NULL};
    VkResult result = vkCreatePipelineCache(gpu->device, &info, NULL, &gpu->pipeline_cache);
    if (result && data_bytes) { // a driver may refuse what it once gave
        info.initialDataSize = 0;
        result = vkCreatePipelineCache(gpu->device, &info, NULL, &gpu->pipeline_cache);
    }
    free(file);
    return result ? vw_gpu_fail(result, "vkCreatePipelineCache", gpu->chosen.info.name) : VW_OK;
}

// Returns the file's bytes; NULL when there is nothing new.
static uint8_t *make_file(struct vw_gpu *gpu, size_t *size_bytes) {
    size_t data_bytes = 0;
    if (vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &data_bytes, NULL) || !data_bytes ||
        data_bytes > CACHE_BYTES_MAX)
        return NULL;
    uint8_t *file = vw_allocate(HASH_BYTES + data_bytes, 1);
    if (file && !vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &data_bytes, file + HASH_BYTES)) {
        vw_sha256(file + HASH_BYTES, data_bytes, file);
        *size_bytes = HASH_BYTES + data_bytes;
        if (memcmp(file, gpu->pipeline_cache_hash, HASH_BYTES)) return file;
    }
    free(file);
    return NULL;
}

void vw_shader_cache_close(struct vw_gpu *gpu) {
    struct vw_saved_error why = vw_error_save(); // the device may be closing because something failed
    size_t size_bytes = 0;
    uint8_t *file = gpu->pipeline_cache ? make_file(gpu, &size_bytes) : NULL;
    if (file) vw_cache_write(gpu->pipeline_cache_name, file, size_bytes);
    vkDestroyPipelineCache(gpu->device, gpu->pipeline_cache, NULL);
    free(file);
    vw_error_restore(&why);
}

#include <inttypes.h>
#include <stdlib.h>

#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "viewworth/gpu.h"

static const char *const kind_names[] = {
    [VW_GPU_DISCRETE] = "discrete", [VW_GPU_INTEGRATED] = "integrated",
    [VW_GPU_VIRTUAL] = "virtual",   [VW_GPU_OTHER] = "other",
    [VW_GPU_CPU] = "cpu",
};

static void print_table(const struct vw_gpu_info *infos, uint32_t count) {
    vw_print("index  kind        memory      name and driver\n");
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_gpu_info *info = &infos[i];
        vw_print("%-5" PRIu32 "  %-10s  %6.1f GiB  %s\n%32s%s\n", info->index, kind_names[info->kind],
                 (double)info->memory_bytes / 0x1p30, info->name, "", info->driver);
        if (info->unsupported_reason[0]) vw_print("%32sunfit: %s\n", "", info->unsupported_reason);
    }
}

static json_t *arithmetic_to_json(const struct vw_gpu_arithmetic *bits) {
    return json_pack("{s:b, s:b, s:b, s:b, s:b, s:I, s:I}", "keeps_nan", bits->keeps_nan, "keeps_denormals",
                     bits->keeps_denormals, "flushes_denormals", bits->flushes_denormals, "rounds_to_even",
                     bits->rounds_to_even, "int64_atomics", bits->int64_atomics, "subgroup_size",
                     (json_int_t)bits->subgroup_size, "driver_version", (json_int_t)bits->driver_version);
}

static json_t *to_json(const struct vw_gpu_info *infos, uint32_t count) {
    json_t *devices = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_gpu_info *info = &infos[i];
        vw_json_append(&devices,
                       json_pack("{s:I, s:s, s:s, s:s, s:I, s:s, s:o}", "index", (json_int_t)info->index, "kind",
                                 kind_names[info->kind], "name", info->name, "driver", info->driver, "memory_bytes",
                                 (json_int_t)info->memory_bytes, "unsupported_reason", info->unsupported_reason,
                                 "bits_depend_on", arithmetic_to_json(&info->arithmetic)));
    }
    return json_pack("{s:o}", "devices", devices);
}

enum vw_status vw_command_devices(const struct vw_options *options) {
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_gpu_list(&infos, &count);
    if (status) return status;
    if (options->json) status = vw_json_print(to_json(infos, count));
    else print_table(infos, count);
    free(infos);
    return status;
}

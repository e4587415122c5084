#include "cli/device_list.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/word_list.h"
#include "viewworth/gpu.h"

static void add(struct vw_device_list *list, const char *name, size_t length) {
    char *text = list->names[list->count];
    snprintf(text, VW_DEVICE_NAME_BYTES, "%.*s", (int)length, name);
    list->texts[list->count++] = text;
}

// Lists all usable devices in order of preference. A CPU comes after all GPUs, and is listed only without them.
static enum vw_status list_all(struct vw_device_list *list) {
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_gpu_list(&infos, &count);
    for (uint32_t i = 0; !status && i < count && list->count < VW_SESSION_DEVICES_MAX; i++) {
        bool is_cpu = infos[i].kind == VW_GPU_CPU;
        if (infos[i].unsupported_reason[0] || (is_cpu && list->count)) continue;
        char index[16];
        add(list, index, (size_t)snprintf(index, sizeof index, "%u", infos[i].index));
        if (is_cpu) break;
    }
    free(infos);
    if (!status && !list->count)
        status = vw_fail(VW_ERROR_NO_DEVICE, "--devices all: no device can be used; see viewworth devices");
    return status;
}

static enum vw_status read_list(const char *texts, struct vw_device_list *list) {
    for (struct vw_word word; vw_word_list_next(&texts, &word);) {
        if (!word.length || word.length >= VW_DEVICE_NAME_BYTES || list->count == VW_SESSION_DEVICES_MAX)
            return vw_fail(VW_ERROR_USAGE, "--devices takes all, or 1 to %d indices or names with commas between",
                           VW_SESSION_DEVICES_MAX);
        add(list, word.text, word.length);
    }
    return VW_OK;
}

enum vw_status vw_device_list_read(const struct vw_options *options, struct vw_device_list *list) {
    list->count = 0;
    if (!options->devices) return VW_OK;
    if (options->device)
        return vw_fail(VW_ERROR_USAGE, "--device is one device and --devices are several; give one of both options");
    return strcmp(options->devices, "all") ? read_list(options->devices, list) : list_all(list);
}

struct vw_device_choice vw_device_list_choose(const struct vw_options *options, const struct vw_device_list *list) {
    if (!list->count) return (struct vw_device_choice){.first = options->device};
    return (struct vw_device_choice){list->texts[0], list->texts + 1, list->count - 1};
}

#include "cli/params.h"

#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "cli/program.h"
#include "run/plan/accuracy_levels.h"
#include "run/plan/plan.h"
#include "run/plan/training_choice.h"
#include "viewworth/gpu.h"

enum vw_status vw_params_set_memory(const struct vw_options *options) {
    static const struct {
        const char *name;
        double bytes;
    } units[] = {{"kB", 1e3},     {"MB", 1e6},     {"GB", 1e9},     {"TB", 1e12},
                 {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}, {"TiB", 0x1p40}};
    const char *text = options->memory;
    if (!text) return VW_OK;
    size_t length = strspn(text, "0123456789."); // strtod knows nan, inf, hexadecimal numbers and exponents, too
    char *end = NULL;
    double number = isdigit((unsigned char)text[0]) ? strtod(text, &end) : 0;
    for (size_t i = 0; end == text + length && i < VW_ARRAY_COUNT(units); i++) {
        if (strcmp(end, units[i].name) != 0 || number * units[i].bytes < 1 || number * units[i].bytes > 0x1p60)
            continue;
        vw_scene_set_memory((uint64_t)(number * units[i].bytes));
        return VW_OK;
    }
    return vw_fail(VW_ERROR_USAGE, "--memory takes a size above 0 with its unit, as 4GB or 512MiB, not \"%s\"", text);
}

uint64_t vw_params_explicit_fields(const struct vw_options *options) {
    uint64_t fields = 0;
    uint32_t count;
    const struct vw_config_field *field = vw_config_fields(&count);
    for (uint32_t i = 0; i < count; i++)
        if (vw_options_have(options, field[i].option)) fields |= vw_config_explicit(field[i].option);
    return fields;
}

enum vw_status vw_params_of_run(const struct vw_options *options, struct vw_run_params *params) {
    *params = (struct vw_run_params){
        .scene = options->scene,
        .config = &options->config,
        .device = options->device,
        .out = options->out,
        .resume = options->resume,
        .accuracy = options->accuracy,
        .explicit_fields = vw_params_explicit_fields(options),
        .payout = options->payout,
        .lasting = options->lasting,
        .report = options->report,
        .profile = options->profile,
    };
    return options->budget ? vw_budget_parse(options->budget, &params->budget_s) : VW_OK;
}

// ---- Devices -------------------------------------------------------------------------------------------------------

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
        int length = snprintf(index, sizeof index, "%u", infos[i].index);
        add(list, index, (size_t)length);
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
    if (options->device) return vw_fail(VW_ERROR_USAGE, "give either --device or --devices, not both");
    return strcmp(options->devices, "all") ? read_list(options->devices, list) : list_all(list);
}

struct vw_device_choice vw_device_list_choose(const struct vw_options *options, const struct vw_device_list *list) {
    if (!list->count) return (struct vw_device_choice){.first = options->device};
    return (struct vw_device_choice){list->texts[0], list->texts + 1, list->count - 1};
}

// ---- Experiments ----------------------------------------------------------------------------------------------------

// Chooses what is open; who has no device gets what a CPU would.
static enum vw_status choose(const struct vw_training_choice_params *params, const char *device,
                             struct vw_scene_params *scene, struct vw_config *config) {
    struct vw_training_choice_params with_device = *params;
    struct vw_training_choice choice;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.device = device}, &with_device.gpu);
    if (status == VW_ERROR_NO_DEVICE && !device) status = VW_OK;
    if (!status) status = vw_training_choose(&with_device, scene, config, &choice);
    (void)vw_gpu_close(&with_device.gpu);
    return status;
}

enum vw_status vw_params_settle(const struct vw_options *options, const char *device, struct vw_scene_params *scene,
                                struct vw_config *config) {
    const struct vw_training_choice_params params = {.accuracy = options->accuracy,
                                                     .explicit_fields = vw_params_explicit_fields(options),
                                                     .lasting = options->lasting.wanted};
    uint32_t level = 0;
    *scene = options->scene;
    *config = options->config;
    enum vw_status status = options->accuracy ? vw_accuracy_find(options->accuracy, &level) : VW_OK;
    if (!status && (config->field == VW_FIELD_AUTO || !scene->downscale))
        status = choose(&params, device, scene, config);
    if (status || !options->accuracy) return status;
    vw_accuracy_apply(level, params.explicit_fields, config);
    return vw_config_check(config);
}

enum vw_status vw_params_open_scene(const struct vw_scene_params *params,
                                    uint32_t (*choose_downscale)(const struct vw_scene *headers), const char *device,
                                    struct vw_gpu **gpu, struct vw_scene **scene) {
    struct vw_scene_params opened = *params;
    opened.headers_only = true;
    enum vw_status status = vw_scene_open(&opened, scene);
    if (!status && choose_downscale && !opened.downscale) opened.downscale = choose_downscale(*scene);
    if (!status && strcmp((*scene)->format, "recipe") == 0) status = vw_open_gpu(device, false, gpu);
    vw_scene_close(scene);
    opened.headers_only = false;
    opened.gpu = *gpu;
    return status ? status : vw_scene_open(&opened, scene);
}

enum vw_status vw_params_of_experiment(const struct vw_options *options, struct vw_experiment_request *request) {
    enum vw_status status = vw_device_list_read(options, &request->devices);
    request->progress.quiet = options->quiet;
    request->params = (struct vw_experiment_params){
        .config = &request->config,
        .devices = vw_device_list_choose(options, &request->devices),
        .out = options->out,
        .seeds = options->seeds,
        .together = options->together,
        .report = options->report,
        .lasting = options->lasting,
        .interrupt = vw_interrupt_watch(),
        .progress = vw_progress_show,
        .context = &request->progress,
    };
    return status ? status
                  : vw_params_settle(options, request->params.devices.first, &request->params.scene, &request->config);
}

#include "cli/params.h"

#include <ctype.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cli/parse_options.h"
#include "run/plan/budget.h"

struct vw_scene_params vw_params_of_scene(const struct vw_options *options) {
    return (struct vw_scene_params){
        .path = options->operand,
        .format = options->format,
        .pool = options->pool,
        .train_list = options->train_list,
        .val_list = options->val_list,
        .test_list = options->test_list,
        .providers = options->providers,
        .downscale = options->downscale,
        .corrupt = options->corrupt,
    };
}

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

static uint32_t list_explicit_fields(const struct vw_options *options) {
    static const struct {
        const char *option;
        uint32_t field;
    } known[] = {{"rays", VW_EXPLICIT_RAYS},         {"samples", VW_EXPLICIT_SAMPLES},
                 {"val-rays", VW_EXPLICIT_VAL_RAYS}, {"log2-table", VW_EXPLICIT_LOG2_TABLE},
                 {"width", VW_EXPLICIT_WIDTH},       {"epochs", VW_EXPLICIT_EPOCHS}};
    uint32_t fields = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(known); i++)
        if (vw_options_have(options, known[i].option)) fields |= known[i].field;
    return fields;
}

enum vw_status vw_params_of_run(const struct vw_options *options, struct vw_run_params *params) {
    *params = (struct vw_run_params){
        .scene = vw_params_of_scene(options),
        .config = &options->config,
        .device = options->device,
        .out = options->out,
        .resume = options->resume,
        .until_stable = options->until_stable,
        .accuracy = options->accuracy,
        .explicit_fields = list_explicit_fields(options),
        .payout = options->payout,
        .lasting = options->lasting,
        .report = options->report,
        .profile = options->profile,
    };
    return options->budget ? vw_budget_parse(options->budget, &params->budget_s) : VW_OK;
}

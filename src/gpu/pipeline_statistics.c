#include "gpu/pipeline_statistics.h"

#include <inttypes.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text_stream.h"

static void print_value(FILE *stream, const VkPipelineExecutableStatisticKHR *statistic) {
    const VkPipelineExecutableStatisticValueKHR *value = &statistic->value;
    switch (statistic->format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: fputs(value->b32 ? "yes" : "no", stream); break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: fprintf(stream, "%" PRId64, value->i64); break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR: fprintf(stream, "%" PRIu64, value->u64); break;
    default: fprintf(stream, "%g", value->f64);
    }
}

char *vw_statistics_format(const VkPipelineExecutableStatisticKHR *statistics, uint32_t count) {
    struct vw_text_stream text = {0};
    FILE *stream = vw_text_stream_open(&text);
    char *line = NULL;
    size_t size_bytes;
    for (uint32_t i = 0; stream && i < count; i++) {
        fprintf(stream, "%s%s ", i ? "; " : "", statistics[i].name);
        print_value(stream, &statistics[i]);
    }
    (void)vw_text_stream_close(&text, "pipeline statistics", &line, &size_bytes);
    return line;
}

static enum vw_status add_line(struct vw_gpu *gpu, const char *name, const char *role, char *line) {
    if (line) vw_text_make_line(line); // names are the driver's
    const char *before = gpu->statistics_text ? gpu->statistics_text : "";
    char *text = line ? vw_format_text("%s%s%s%s: %s\n", before, name, role ? ", " : "", role ? role : "", line) : NULL;
    if (!text) return VW_ERROR_MEMORY;
    free(gpu->statistics_text);
    gpu->statistics_text = text;
    return VW_OK;
}

// Reads the statistics of the only executable that a compute pipeline has.
enum vw_status vw_statistics_collect(struct vw_gpu *gpu, VkPipeline pipeline, const char *name, const char *role) {
    if (!gpu->has_statistics) return VW_OK;
    const VkPipelineExecutableInfoKHR executable = {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR,
                                                    .pipeline = pipeline};
    uint32_t count = 0;
    VkResult result = vkGetPipelineExecutableStatisticsKHR(gpu->device, &executable, &count, NULL);
    VkPipelineExecutableStatisticKHR *statistics = vw_allocate(count, sizeof *statistics);
    if (!statistics) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) statistics[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
    if (!result) result = vkGetPipelineExecutableStatisticsKHR(gpu->device, &executable, &count, statistics);
    enum vw_status status = VW_OK;
    if (!result && count) {
        char *line = vw_statistics_format(statistics, count);
        status = add_line(gpu, name, role, line);
        free(line);
    }
    free(statistics);
    return result ? vw_gpu_fail(result, "vkGetPipelineExecutableStatisticsKHR", name) : status;
}

const char *vw_gpu_pipeline_statistics(const struct vw_gpu *gpu) {
    return gpu->statistics_text ? gpu->statistics_text : "";
}

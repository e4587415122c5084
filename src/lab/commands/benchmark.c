#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "cli/params.h"
#include "cli/program.h"
#include "lab/benchmark.h"
#include "lab/commands/commands.h"
#include "lab/output/results.h"

static enum vw_curves curves_of(const char *list) {
    if (!list) return VW_CURVES_DEFAULT;
    if (!strcmp(list, "none")) return VW_CURVES_NONE;
    if (!strcmp(list, "gain")) return VW_CURVES_GAIN;
    return strcmp(list, "all") ? VW_CURVES_LISTED : VW_CURVES_ALL;
}

enum { SUBSETS_LEAST = 8, SUBSETS_MOST = 10000 };

static enum vw_status read_subsets(const char *text, struct vw_benchmark_params *params) {
    char *end = NULL;
    params->subsets = 200;
    if (!text) return VW_OK;
    params->all_subsets = !strcmp(text, "all");
    if (params->all_subsets) return VW_OK;
    long number = isdigit((unsigned char)text[0]) ? strtol(text, &end, 10) : 0;
    if (!end || *end || number < SUBSETS_LEAST || number > SUBSETS_MOST)
        return vw_fail(VW_ERROR_USAGE, "--subsets takes all or a whole number, %d to %d, not \"%s\"", SUBSETS_LEAST,
                       SUBSETS_MOST, text);
    params->subsets = (uint32_t)number;
    return VW_OK;
}

enum { RETRAININGS_LEAST = 8, RETRAININGS_MOST = 10000 };

static enum vw_status read_worths(const struct vw_lab_options *options, struct vw_benchmark_params *params) {
    const char *rest = options->worth_retrainings;
    struct vw_word word;
    if (rest && options->common.equal != VW_EQUAL_STEPS)
        return vw_fail(VW_ERROR_USAGE, "--worth-retrainings are of equal steps; leave --equal epochs out");
    while (vw_word_list_next(&rest, &word)) {
        char *end = NULL;
        long number = isdigit((unsigned char)*word.text) ? strtol(word.text, &end, 10) : 0;
        if (end != word.text + word.length || number < RETRAININGS_LEAST || number > RETRAININGS_MOST ||
            params->worth_count == VW_BENCHMARK_WORTHS)
            return vw_fail(VW_ERROR_USAGE, "--worth-retrainings takes up to %d whole numbers, %d to %d, not \"%s\"",
                           VW_BENCHMARK_WORTHS, RETRAININGS_LEAST, RETRAININGS_MOST, options->worth_retrainings);
        params->worth_retrainings[params->worth_count++] = (uint32_t)number;
    }
    return VW_OK;
}

enum vw_status vw_lab_benchmark(const struct vw_options *options) {
    const struct vw_lab_options *lab = vw_lab_options(options);
    struct vw_experiment_request request = {0};
    struct vw_benchmark_params params = {.evaluated = lab->evaluated,
                                         .retraining_seeds = lab->retraining_seeds,
                                         .equal = options->equal,
                                         .leave_one_out = lab->leave_one_out,
                                         .curves = curves_of(lab->curves),
                                         .curve_scorers = lab->curves};
    struct vw_benchmark benchmark = {0};
    enum vw_status status = read_subsets(lab->subsets, &params);
    if (!status) status = read_worths(lab, &params);
    if (!status) status = vw_params_of_experiment(options, &request);
    params.common = request.params;
    params.common.seeds = lab->valued_seeds;
    if (!status) status = vw_benchmark_make(&params, &benchmark);
    vw_progress_end(&request.progress);
    if (!status) status = vw_benchmark_print(&benchmark, options->json);
    vw_benchmark_free(&benchmark);
    return status;
}

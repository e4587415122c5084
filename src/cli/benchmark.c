#include <stdlib.h>
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/laboratory.h"
#include "cli/seed_runs.h"
#include "value/subsets.h"
#include "viewworth/file.h"

enum vw_status vw_command_benchmark(const struct vw_options *options) {
    struct vw_laboratory laboratory = {0};
    struct vw_subsets subsets = {0};
    enum vw_status status = getenv("NOSEEDS") ? vw_folder_create(options->out) : vw_seed_runs_make(options, 0, VW_SUBSET_SEEDS);
    vw_interrupt_watch();
    if (!status) status = vw_laboratory_open(options, &laboratory);
    if (!status) status = vw_subsets_draw(laboratory.train_count, options->subsets, &subsets);
    laboratory.planned = subsets.count * VW_SUBSET_SEEDS;
    if (!status) status = vw_subsets_try(&subsets, laboratory.train_views, options->config.seed, vw_laboratory_try, &laboratory);
    vw_subsets_free(&subsets);
    vw_laboratory_close(&laboratory);
    return status;
}

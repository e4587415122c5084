// The score fisher: sum over params of H_candidate / (H_known + lambda), H being the diagonal of the Fisher information
// of what photos see (fisher_diagonal.h), and lambda a share of its mean over params that the known photos inform about
// (FisherRF, Jiang et al., ECCV 2024).
#include <stdlib.h>

#include "base/memory.h"
#include "run/next/fisher_diagonal.h"

static const double DAMPING = 0.01; // lambda as a share of that mean

struct fisher {
    float *known;     // owned
    float **diagonal; // owned; by candidate
    double lambda;
    uint64_t param_count;
    uint32_t count;
};

static double mean_of_informed(const float *values, uint64_t count) {
    double sum = 0;
    uint64_t informed = 0;
    for (uint64_t j = 0; j < count; j++) {
        sum += values[j];
        informed += values[j] > 0;
    }
    return informed ? sum / (double)informed : 1;
}

static enum vw_status measure(const struct vw_known_views *known, const struct vw_candidate *candidates,
                              struct vw_fisher *passes, struct fisher *fisher) {
    enum vw_status status = VW_OK;
    fisher->param_count = passes->param_count;
    fisher->known = vw_allocate(fisher->param_count, sizeof *fisher->known);
    if (!fisher->known) return VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < known->count && !status; k++)
        status = vw_fisher_add(passes, &known->scene->views[known->views[k]], fisher->known);
    for (uint32_t i = 0; i < fisher->count && !status; i++) {
        fisher->diagonal[i] = vw_allocate(fisher->param_count, sizeof **fisher->diagonal);
        status =
            fisher->diagonal[i] ? vw_fisher_add(passes, &candidates[i].pose, fisher->diagonal[i]) : VW_ERROR_MEMORY;
    }
    fisher->lambda = DAMPING * mean_of_informed(fisher->known, fisher->param_count);
    return status;
}

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    struct fisher *fisher = *state = vw_allocate(1, sizeof *fisher);
    struct vw_fisher passes = {0};
    if (!fisher) return VW_ERROR_MEMORY;
    fisher->diagonal = vw_allocate(count, sizeof *fisher->diagonal);
    if (!fisher->diagonal) return VW_ERROR_MEMORY;
    fisher->count = count;
    enum vw_status status = vw_fisher_create(known, VW_FISHER_DRAWS, &passes);
    if (!status) status = measure(known, candidates, &passes, fisher);
    vw_fisher_destroy(&passes);
    return status;
}

static double gain(const void *state, uint32_t candidate) {
    const struct fisher *fisher = state;
    const float *diagonal = fisher->diagonal[candidate];
    double sum = 0;
    for (uint64_t j = 0; j < fisher->param_count; j++)
        if (diagonal[j] > 0) sum += diagonal[j] / (fisher->known[j] + fisher->lambda);
    return sum;
}

static void add(void *state, uint32_t candidate) {
    struct fisher *fisher = state;
    for (uint64_t j = 0; j < fisher->param_count; j++) fisher->known[j] += fisher->diagonal[candidate][j];
}

static void destroy(void **state) {
    struct fisher *fisher = *state;
    if (!fisher) return;
    for (uint32_t i = 0; i < fisher->count; i++) free(fisher->diagonal[i]);
    free(fisher->diagonal);
    free(fisher->known);
    free(fisher);
    *state = NULL;
}

const struct vw_candidate_score vw_score_fisher = {.name = "fisher",
                                                   .summary =
                                                       "most informative about params that known photos inform little",
                                                   .create = create,
                                                   .gain = gain,
                                                   .add = add,
                                                   .destroy = destroy};

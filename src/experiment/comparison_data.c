#include "experiment/comparison_data.h"

const struct vw_retrain_result *vw_comparison_results(const struct vw_comparison *comparison, uint32_t list) {
    return comparison->results + (size_t)list * comparison->params->common.seeds;
}

struct vw_paired_difference vw_comparison_difference(const struct vw_comparison *comparison,
                                                     const struct vw_set_pair *pair, enum vw_quality quality) {
    return vw_quality_compare(vw_comparison_results(comparison, pair->list),
                              vw_comparison_results(comparison, pair->against), comparison->params->common.seeds,
                              quality);
}

// The command line of viewworth-lab as a struct: the options of viewworth, and those that evaluate methods.
#ifndef VIEWWORTH_LAB_OPTIONS_H
#define VIEWWORTH_LAB_OPTIONS_H

#include "cli/options.h"
#include "cli/program.h"
#include "lab/method_scorers.h"

struct vw_lab_options {
    struct vw_options common; // first, so that commands are given either
    const char *subsets;      // a number, or "all"
    uint32_t retraining_seeds, valued_seeds;
    bool leave_one_out;
    const char *worth_retrainings; // numbers with commas between
    struct vw_method_params evaluated;
    const char *curves;
    uint32_t same_state;       // states that all photos are tried on; 0: none
    uint32_t lengthen_percent; // by which the steps on each photo in turn change; 0: none
    uint32_t halves;           // random halves of the train photos, by which a trade-off evaluates scores
};

// Groups of options that only commands of viewworth-lab take, after those of VW_OPTIONS_*.
enum {
    VW_LAB_BENCHMARK = VW_OPTIONS_OTHER,
    VW_LAB_REPRODUCE = VW_OPTIONS_OTHER * 2,
    VW_LAB_PROBES = VW_OPTIONS_OTHER * 4,
    VW_LAB_TRADEOFF = VW_OPTIONS_OTHER * 8,
};

extern const struct vw_option vw_lab_option_table[];
extern const uint32_t vw_lab_option_count;
extern const struct vw_lab_options vw_lab_options_default;

// Returns the options of the laboratory that these begin.
static inline const struct vw_lab_options *vw_lab_options(const struct vw_options *options) {
    return (const struct vw_lab_options *)options;
}

#endif

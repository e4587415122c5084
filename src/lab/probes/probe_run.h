// Probes of a finished run: its steps are repeated, bit for bit, and probes are taken from its states.
#ifndef VIEWWORTH_LAB_PROBES_PROBE_RUN_H
#define VIEWWORTH_LAB_PROBES_PROBE_RUN_H

#include "base/interrupt.h"
#include "lab/probes/probe_scores.h"

struct vw_probe_params {
    const char *out;     // folder of a run of value; its ledger is only read
    const char *device;  // NULL: the recorded one
    uint32_t same_state; // states from which a step on every photo is taken; 0: none
    double lengthened;   // share by which the steps on each photo in turn are lengthened, and shortened; 0: none
    struct vw_interrupt interrupt;
};

struct vw_probing {
    struct vw_noise_floor noise;
    uint64_t steps;                    // repeated
    uint32_t states, same_state_steps; // probed
    double seconds;                    // wall clock of the probes
    double share;                      // and that by that of probes and steps
    char *probes_path, *scores_path;   // owned
};

// Writes OUT/probes.csv (header step,probe,kind,name,val_psnr,val_psnr_pooled,val_l1; a row per probe) and
// OUT/probe_scores.csv (header name,method,value,unit,stderr,visits,resampling_stderr). VW_ERROR_USAGE for a run
// without validation or whole epochs, and for more states than epochs after burn-in, and to lengthen steps with
// momentum; VW_ERROR_MISMATCH when a repeated step is not the recorded one. Free it also after a failure.
enum vw_status vw_probe_run(const struct vw_probe_params *params, struct vw_probing *probing);
void vw_probing_free(struct vw_probing *probing);

#endif

// Checks of the options for lasting credit, and the part of a ledger that text and JSON show.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_SUMMARY_H
#define VIEWWORTH_RUN_LASTING_LASTING_SUMMARY_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/run.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// Returns VW_ERROR_USAGE for a config (NULL: the default) that no backward pass can follow.
enum vw_status vw_lasting_check_config(const struct vw_config *config);
// Returns whether a run of `config` has a gate; with momentum it has none.
bool vw_lasting_has_gate(const struct vw_config *config);
// Returns whether the ledger already has the wanted result for a run of `config`, with its gate if that is wanted.
bool vw_lasting_is_there(const struct vw_lasting_options *wanted, const struct vw_config *config,
                         const struct vw_lasting_pass *pass);

struct vw_lasting_summary {
    struct vw_lasting_pass pass;    // owned; step_count 0: none, and the rest is empty
    struct vw_ledger_score *scores; // owned; of lasting_psnr, best first; their texts are lent by the ledger
    uint32_t score_count;
    const struct vw_ledger_image *images; // lent by the ledger
    uint32_t image_count;
    uint64_t steps_per_epoch;
};
enum vw_status vw_lasting_summary_make(struct vw_ledger *ledger, struct vw_lasting_summary *summary);
void vw_lasting_summary_free(struct vw_lasting_summary *summary);

#endif

// How much a ledger holds.
#ifndef VIEWWORTH_LEDGER_COUNTS_H
#define VIEWWORTH_LEDGER_COUNTS_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_ledger_counts {
    uint64_t schema_version;
    uint64_t steps, images, views, probes, scores; // rows of each table
};

enum vw_status vw_ledger_count(struct vw_ledger *ledger, struct vw_ledger_counts *counts);

#endif

// Independent pieces of work on several threads.
#ifndef VIEWWORTH_BASE_PARALLEL_H
#define VIEWWORTH_BASE_PARALLEL_H

#include <stdint.h>

#include "viewworth/status.h"

// Calls `work` once for each piece from 0 to count - 1, on as many threads as there are processors, at most 16. Pieces
// write to places of their own, so that results do not depend on threads. Returns the status of the first piece, by
// number, that failed, with its message; later pieces may then not have been called.
enum vw_status vw_parallel_for(uint32_t count, enum vw_status (*work)(void *context, uint32_t piece), void *context);

#endif

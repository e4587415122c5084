// The one barrier that everything uses.
#ifndef VIEWWORTH_GPU_BARRIER_H
#define VIEWWORTH_GPU_BARRIER_H

#include <stdbool.h>
#include <volk.h>

// All earlier commands, and what they wrote, before all later ones, and where asked before the host. A barrier with
// `host_reads` ends every command buffer, so that none has to know what those before it did.
void vw_barrier_record(VkCommandBuffer commands, bool host_reads);

#endif

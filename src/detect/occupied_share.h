// The share of the box that a trained field fills.
#ifndef VIEWWORTH_DETECT_OCCUPIED_SHARE_H
#define VIEWWORTH_DETECT_OCCUPIED_SHARE_H

#include <stdint.h>

#include "viewworth/status.h"

struct vw_radiance_field;

// Measures the share of the cells of a lattice of `samples`^3 over the box whose middle has a density worth sampling:
// one that makes a sample of a ray across the box at least 1 % opaque. `samples` is that of the field's config. Call it
// when nothing is in flight.
enum vw_status vw_occupied_share(struct vw_radiance_field *field, uint32_t samples, double *share);

#endif

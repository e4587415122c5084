#include "reference.h"

#include <math.h>

struct reference_view_error reference_view_error(const struct vw_ray *rays, const vw_float4 *colours, uint32_t count) {
    long double squared = 0.0L, absolute = 0.0L;
    for (uint32_t i = 0; i < count; i++) {
        if (rays[i].target_weight.w == 0.0f) continue;
        // The error itself is a float: it is what the sums are of.
        const float errors[3] = {colours[i].x - rays[i].target_weight.x, colours[i].y - rays[i].target_weight.y,
                                 colours[i].z - rays[i].target_weight.z};
        for (int c = 0; c < 3; c++) {
            squared += (long double)errors[c] * errors[c];
            absolute += fabsl((long double)errors[c]);
        }
    }
    return (struct reference_view_error){(double)squared, (double)absolute};
}

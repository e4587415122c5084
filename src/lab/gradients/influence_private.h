// The inside of influence functions, for influence.c and its test.
#ifndef VIEWWORTH_LAB_GRADIENTS_INFLUENCE_PRIVATE_H
#define VIEWWORTH_LAB_GRADIENTS_INFLUENCE_PRIVATE_H

#include "lab/gradients/gradient_replay.h"

struct vw_influence {
    struct vw_gradient_replay gradient_replay;
    struct vw_influence_settings settings; // without zeros
    uint64_t count;                        // params
    float *block;                          // owned; scratch: what is exchanged with the device
    double *rates;                         // owned, as all below: P; 0 where a param is held fixed
    double *pull;                          // P grad U
    double *x, *carried;                   // carried: (1 - damping) x - P H x / scale
    double *mean;                          // mean of x / scale over the iterations that count: s
    double scale, size;                    // size: of x
    uint32_t first_counted;                // iteration
};

// Replays the training and finds P and P grad U.
enum vw_status vw_influence_create(const struct vw_gradient_params *params,
                                   const struct vw_influence_settings *settings, struct vw_influence *influence);
void vw_influence_destroy(struct vw_influence *influence);
// Leaves H x in the block, H of the photo and the rays of iteration `index`.
enum vw_status vw_influence_multiply(struct vw_influence *influence, uint32_t index);
// Finds s.
enum vw_status vw_influence_solve(struct vw_influence *influence, struct vw_influence_result *result);
enum vw_status vw_influence_score(struct vw_influence *influence, double *scores);

#endif

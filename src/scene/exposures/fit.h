// The exposures of photos, by the colours of the points that they share.
//
// Per channel, with L_p the colour of point p and c_ip that of its pixel in photo i, gains 1 + g_i, biases b_i and
// colours L_p minimise
//   sum_ip rho(c_ip - (1 + g_i) L_p - b_i) + sum_i (RIDGE (g_i^2 + b_i^2) + BIAS_PULL n_i b_i^2)
// by Gauss-Newton steps; rho is Huber's, so that specular points and people who walk by count less.
#ifndef VIEWWORTH_SCENE_EXPOSURES_FIT_H
#define VIEWWORTH_SCENE_EXPOSURES_FIT_H

#include "scene/exposures/observations.h"

enum {
    EXPOSURE_OBSERVATIONS_MIN = 8, // per photo; with fewer it keeps the identity
    EXPOSURE_FOLDS = 2,            // parts of the points; each is judged by a fit to the others
};

// A fit of one channel.
struct exposure_fit {
    const struct observations *observations; // borrowed
    int channel;
    double *colours;        // by point; NaN: unknown
    double *gains, *biases; // by view; gains minus 1
    double *residuals;      // by observation; NaN: unusable
    double spread;          // robust; residuals of more than 1.3 spreads count less
};

// A gain and a bias of a view, or what belongs to these numbers.
struct exposure_pair {
    double gain, bias;
};

// Scratch memory that fits to the same observations share.
struct exposure_work {
    const struct observations *observations;                          // borrowed
    bool *used;                                                       // by point: fits see it
    uint32_t *counts;                                                 // by view: observations in use
    struct exposure_pair *slope, *scale, *step, *direction, *product; // by view: of a Gauss-Newton step
    double *sorted;                                                   // scratch, by observation or view
};

// Creates memory of zeros, which the caller releases, also after a failure.
enum vw_status vw_exposure_work_create(const struct observations *observations, struct exposure_work *work);
void vw_exposure_work_release(const struct exposure_work *work);
enum vw_status vw_exposure_fit_create(const struct observations *observations, struct exposure_fit *fit);
void vw_exposure_fit_release(const struct exposure_fit *fit);

// Fits a channel to the points in use; without `exposures`, the colours of points alone.
void vw_exposure_fit_channel(struct exposure_work *work, struct exposure_fit *fit, int channel, bool exposures);

// Sums over the observations of a point; their ratio is its colour.
struct exposure_colour_sums {
    double squares, products;
};

struct exposure_colour_sums vw_exposure_sum_point(const struct exposure_fit *fit, uint32_t point);

// Returns how far an observation is from what the others of its point predict, which has these sums.
double vw_exposure_miss(const struct exposure_fit *fit, const struct exposure_colour_sums *all, uint32_t observation);

#endif

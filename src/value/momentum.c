#include "value/momentum.h"

#include <math.h>
#include <stdlib.h>

#include "viewworth/memory.h"

enum { MOST_ITERATIONS = 1000 };
static const double tolerance = 1e-14; // of the gradient's length, relative to where it began

// The linear model. Its unknowns are the worth of each image, and last what the first moment holds when burn-in ends.
struct model {
    double beta1;
    const struct vw_series *series;
    uint32_t unknown_count;
};

// What worths make of the deltas: a low-pass filter over the photos' worths in the order of the steps. 0 where there is no value.
static void predict(const struct model *model, const double *unknowns, double *deltas) {
    double moment = unknowns[model->unknown_count - 1];
    for (uint64_t i = 0; i < model->series->count; i++) {
        const struct vw_visit *visit = &model->series->visits[i];
        deltas[i] = 0;
        if (isnan(visit->delta)) continue;
        moment = model->beta1 * moment + (1 - model->beta1) * unknowns[visit->image];
        deltas[i] = moment;
    }
}

// The same filter backwards: what is left of the deltas from each step on, weighted by how much of the step's gradient is in them.
// Overwrites the residuals; leaves the gradient by the unknowns.
static void trace_back(const struct model *model, double *residuals, double *gradient) {
    for (uint32_t i = 0; i < model->unknown_count; i++) gradient[i] = 0;
    double ahead = 0;
    for (uint64_t i = model->series->count; i-- > 0;) {
        const struct vw_visit *visit = &model->series->visits[i];
        if (isnan(visit->delta)) continue;
        ahead = residuals[i] + model->beta1 * ahead;
        residuals[i] = ahead;
        gradient[visit->image] += (1 - model->beta1) * ahead;
    }
    gradient[model->unknown_count - 1] = model->beta1 * ahead;
}

static double dot(const double *a, const double *b, uint64_t count) {
    double sum = 0;
    for (uint64_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

// What the least-squares fit works on; one block.
struct workspace {
    double *unknowns, *gradient, *direction; // by unknown
    double *residuals, *scratch;             // by visit
};

// Conjugate gradients on the normal equations (Hestenes and Stiefel, 1952, in the form known as CGLS), from 0: of the solutions of an
// undetermined system the smallest. Leaves the residuals of the fit.
static void fit(const struct model *model, struct workspace *work) {
    uint64_t visit_count = model->series->count;
    for (uint64_t i = 0; i < visit_count; i++) {
        double delta = model->series->visits[i].delta;
        work->residuals[i] = work->scratch[i] = isnan(delta) ? 0 : delta;
    }
    trace_back(model, work->scratch, work->gradient);
    double length = dot(work->gradient, work->gradient, model->unknown_count), enough = tolerance * tolerance * length;
    for (uint32_t i = 0; i < model->unknown_count; i++) work->direction[i] = work->gradient[i];
    for (uint32_t iteration = 0; iteration < MOST_ITERATIONS && length > enough; iteration++) {
        predict(model, work->direction, work->scratch);
        double pace = length / dot(work->scratch, work->scratch, visit_count);
        for (uint32_t i = 0; i < model->unknown_count; i++) work->unknowns[i] += pace * work->direction[i];
        for (uint64_t i = 0; i < visit_count; i++) {
            work->residuals[i] -= pace * work->scratch[i];
            work->scratch[i] = work->residuals[i];
        }
        trace_back(model, work->scratch, work->gradient);
        double shorter = dot(work->gradient, work->gradient, model->unknown_count);
        for (uint32_t i = 0; i < model->unknown_count; i++) work->direction[i] = work->gradient[i] + shorter / length * work->direction[i];
        length = shorter;
    }
}

enum vw_status vw_momentum_deconvolve(double beta1, uint32_t image_count, struct vw_series *series) {
    const struct model model = {beta1, series, image_count + 1};
    double *block = vw_allocate(3 * (size_t)model.unknown_count + 2 * series->count, sizeof *block);
    if (!block) return VW_ERROR_MEMORY;
    double *of_visits = block + 3 * (size_t)model.unknown_count;
    struct workspace work = {block, block + model.unknown_count, block + 2 * (size_t)model.unknown_count, of_visits,
                             of_visits + series->count};
    fit(&model, &work);
    trace_back(&model, work.residuals, work.gradient);
    for (uint64_t i = 0; i < series->count; i++) {
        struct vw_visit *visit = &series->visits[i];
        if (!isnan(visit->delta)) visit->delta = work.unknowns[visit->image] + (1 + beta1) * work.residuals[i];
    }
    free(block);
    return VW_OK;
}

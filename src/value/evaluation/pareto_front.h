// The Pareto front of choices with a cost and a quality.
#ifndef VIEWWORTH_VALUE_EVALUATION_PARETO_FRONT_H
#define VIEWWORTH_VALUE_EVALUATION_PARETO_FRONT_H

#include <stdbool.h>
#include <stdint.h>

// Sets on_front[i] if no other choice has at most its cost and at least its quality, one of them strictly better. Equal
// choices are all on the front. A choice with a NaN is not on it and dominates none.
void vw_pareto_front_mark(const double *costs, const double *qualities, uint32_t count, bool *on_front);

#endif

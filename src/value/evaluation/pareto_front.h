// The Pareto front of choices that cost and give something.
#ifndef VIEWWORTH_VALUE_FRONT_H
#define VIEWWORTH_VALUE_FRONT_H

#include <stdbool.h>
#include <stdint.h>

// on_front[i] tells whether no other choice costs at most as much and gives at least as much, one of both strictly; of
// equal ones all are on the front. A choice whose cost or worth is NaN is not on it and dominates none.
void vw_pareto_front_mark(const double *costs, const double *worths, uint32_t count, bool *on_front);

#endif

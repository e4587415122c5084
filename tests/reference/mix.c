#include "reference.h"

double reference_mix(double before, double after, double reach) { return (1.0 - reach) * before + reach * after; }

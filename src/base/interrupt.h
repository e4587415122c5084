// The request to stop. Long work asks for it between two of its parts and returns VW_ERROR_INTERRUPTED.
#ifndef VIEWWORTH_BASE_INTERRUPT_H
#define VIEWWORTH_BASE_INTERRUPT_H

#include <stdbool.h>

// All zero: no one ever asks.
struct vw_interrupt {
    bool (*requested)(void *context);
    void *context; // borrowed
};

static inline bool vw_interrupt_requested(const struct vw_interrupt *interrupt) {
    return interrupt && interrupt->requested && interrupt->requested(interrupt->context);
}

#endif

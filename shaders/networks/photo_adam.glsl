// Lazy Adam on what belongs to one photo: the step's photo alone moves, with its own moments and step count, whatever
// the optimiser of the field counts. Used by update passes of one workgroup.
#ifndef PHOTO_ADAM_GLSL
#define PHOTO_ADAM_GLSL
#include "networks/adam.glsl"

BUFFER(VW_SLOT_OVERFLOW) writeonly buffer Overflow { uint overflow; };
PUSH uniform Push { vw_push_update push; };

// A photo is visited once an epoch, the field at every step: so its code moves by a multiple of the learning rate. The
// multiple falls as codes settle, since the field has to bear it when they waver.
const float PHOTO_RATE = 20.0;
float photo_rate(uint visits) { return PHOTO_RATE * inversesqrt(float(visits)); }

// Returns the step count after this step; it saturates, as the grid's does.
uint next_visit(uint visits) { return min(visits, 0x7FFFFFFEu) + 1u; }

// Returns what to subtract from params that move at `rate` times the learning rate.
vec4 photo_step(float rate, vec4 gradient, uint visits, inout vec4 moment1, inout vec4 moment2) {
    return (1.0 + push.extra) * rate * adam_step(push.adam, gradient, visits, moment1, moment2);
}

// Returns whether moved params may be stored: they stay finite, whatever the learning rate, and the row says where they
// would not (decision 8).
bool stays_finite(bool is_finite) {
    if (!is_finite) overflow = 1u;
    return is_finite;
}

#ifdef PHOTO_CODE4 // in passes that move a photo's code: its length / 4, its slot, and slot and type of its moments
BUFFER(PHOTO_CODES) buffer Codes { vec4 codes[]; };
BUFFER(PHOTO_CODE_MOMENTS) buffer Moments { PHOTO_MOMENTS_TYPE moments[]; };

void store_code(uint view, uint k, vec4 moved, vec4 moment1, vec4 moment2) {
    if (!stays_finite(finite(moved))) return;
    codes[PHOTO_CODE4 * view + k] = moved;
    moments[view].moment1[k] = moment1;
    moments[view].moment2[k] = moment2;
}

void move_code(uint view, uint k, uint visits, vec4 gradient) {
    vec4 code = codes[PHOTO_CODE4 * view + k], moment1 = moments[view].moment1[k], moment2 = moments[view].moment2[k];
    vec4 by = photo_step(photo_rate(visits), gradient + PHOTO_RIDGE * code, visits, moment1, moment2);
    store_code(view, k, code - by, moment1, moment2);
}
#endif

#endif

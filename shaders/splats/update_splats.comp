// Moves the splats that the step saw, one per invocation. Lazy Adam: a splat that no pixel shows keeps its moments and
// its own step count, and so does a harmonic that is not in use yet. The counts are in w of second moments that no
// param needs: those of the scales and of each harmonic.
#include "networks/adam.glsl"
#include "splats/constants.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_SPLATS) buffer Splats { vec4 splats[]; };
BUFFER(VW_SLOT_SPLATS_SEEN) readonly buffer Seen { vw_splat_seen splats_seen[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer SplatState { vw_splat_state splat_state; };
BUFFER(VW_SLOT_D_SPLATS) readonly buffer DSplats { vec4 d_splats[]; };
BUFFER(VW_SLOT_SPLAT_MOMENT1) buffer Moment1 { vec4 splat_moment1[]; };
BUFFER(VW_SLOT_SPLAT_MOMENT2) buffer Moment2 { vec4 splat_moment2[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_OVERFLOW) writeonly buffer Overflow { uint overflow; };
PUSH uniform Push { vw_push_splat_update push; };

const float VISITS_MOST = 16777215.0; // floats count up to here

vec4 rates(uint column) {
    if (column == SPLAT_MEAN) return vec4(vec3(push.mean), push.opacity);
    if (column == SPLAT_SCALE) return vec4(vec3(push.scale), 0.0);
    if (column == SPLAT_TURN) return vec4(push.turn);
    return vec4(vec3(column == SPLAT_HARMONICS ? push.colour : push.harmonics), 0.0);
}

void main() {
    uint rank = invocation_index();
    if (rank >= splat_state.seen || state.nonfinite != 0u || splat_state.overflow != 0u) return;
    if (d_splats[SPLAT_SCALE * push.stride + rank].w == 0.0) return;
    uint splat = splats_seen[rank].sighting;
    float visits = min(splat_moment2[SPLAT_SCALE * push.stride + splat].w + 1.0, VISITS_MOST);
    for (uint column = 0u; column < push.columns; column++) {
        uint at = column * push.stride + splat;
        vec4 gradient = d_splats[column * push.stride + rank] * INVERSE_RAYS;
        vec4 moment1 = MOMENTUM != 0u ? splat_moment1[at] : vec4(0.0), moment2 = splat_moment2[at];
        vec4 before = splats[at];
        bool counts = column == SPLAT_SCALE || column >= SPLAT_HARMONICS;
        float times = column > SPLAT_HARMONICS ? min(moment2.w + 1.0, VISITS_MOST) : visits;
        vec4 by = (1.0 + push.extra) * rates(column) * adam_step(push.adam, gradient, uint(times), moment1, moment2);
        if (counts) {
            by.w = 0.0;
            moment2.w = times;
        }
        vec4 moved = before - by;
        // Params stay finite, whatever the learning rate, and the row says so (decision 8).
        bool sound = finite(moved);
        if (!sound) overflow = 1u;
        splats[at] = sound ? moved : before;
        if (sound || counts) splat_moment2[at] = sound ? moment2 : vec4(splat_moment2[at].xyz, times);
        if (MOMENTUM != 0u && sound) splat_moment1[at] = moment1;
    }
}

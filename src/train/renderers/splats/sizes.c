#include <assert.h>

#include "train/renderers/splats/splats.h"

static const float EPSILON = 1e-15f; // Adam's, as Kerbl et al. have it

struct vw_splat_specialization vw_splat_specialise(const struct vw_specialization *run, bool cpu) {
    struct vw_splat_specialization s = {.run = *run, .low_pass = 0.3f, .sort_digits = 256};
    s.run.gradient_quantum = EPSILON / run->inverse_rays;
    if (cpu) { // a vector of tiles, each with pairs of its own, fetches as many pairs at a time
        s.side = 8;
        s.lanes = 1;
        s.group = 8;
        s.sort_lanes = 16;
        s.sort_keys = 64;
        s.place_lanes = 64;
    } else {
        s.side = 16;
        s.lanes = s.group = 64;
        s.sort_lanes = 64;
        s.sort_keys = 16;
        s.sort_digits = 16; // so few that their counts fit the shared memory
        s.place_lanes = 256;
    }
    return s;
}

static uint32_t bits_of(uint32_t value) {
    uint32_t bits = 0;
    for (; value; value >>= 1) bits++;
    return bits;
}

uint32_t vw_splat_digit_bits(const struct vw_splat_specialization *s) {
    uint32_t bits = 1;
    while (1u << bits < s->sort_digits) bits++;
    return bits;
}

uint32_t vw_splat_sort_digits(const struct vw_splat_room *room, const struct vw_splat_specialization *s) {
    uint32_t digit_bits = vw_splat_digit_bits(s), key_bits = VW_SPLAT_DEPTH_BITS + bits_of(room->tiles);
    return (key_bits + digit_bits - 1) / digit_bits;
}

static enum vw_status check(const char *what, uint64_t value, uint64_t most, const char *remedy) {
    if (value && value <= most) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "splats: %llu %s, from 1 to %llu can be drawn; %s", (unsigned long long)value, what,
                   (unsigned long long)most, remedy);
}

enum vw_status vw_splat_check_room(const struct vw_splat_room *room, const struct vw_splat_specialization *s) {
    enum { TRIPS = 30000 }; // trips of one loop; an invocation has two
    uint64_t sightings = (uint64_t)room->splats * room->views;
    assert(s->lanes == 1 || s->group == s->lanes); // lanes of a tile meet at barriers, as often as it has pairs
    enum vw_status status =
        check("sightings", sightings, (uint64_t)TRIPS * s->place_lanes, "use fewer splats or views at once");
    if (!status) status = check("tiles", room->tiles, VW_SPLAT_TILES_MAX, "draw them in several parts");
    if (!status) status = check("cells", room->cells, (uint64_t)VW_SPLAT_CELLS_MAX * room->views, "use smaller photos");
    if (!status)
        status = check("pairs", room->pairs,
                       (uint64_t)TRIPS * s->place_lanes / s->sort_digits * s->sort_lanes * s->sort_keys,
                       "draw fewer tiles at once");
    if (status || room->degree <= VW_SPLAT_DEGREE_MAX) return status;
    return vw_fail(VW_ERROR_INPUT, "splats: harmonics of degree %u; 3 is the highest", room->degree);
}

uint64_t vw_splat_param_bytes(const struct vw_splat_room *room) {
    return 16 * (uint64_t)VW_SPLAT_COLUMNS(room->degree) * room->splats;
}

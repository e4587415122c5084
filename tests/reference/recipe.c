#include "reference.h"

#include <math.h>
#include <string.h>

static const double NEAREST = 1e-4; // box edges: what is nearer belongs to the surface that a ray starts from

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void point_at(const double origin[3], const double direction[3], double parameter, double point[3]) {
    for (int i = 0; i < 3; i++) point[i] = origin[i] + parameter * direction[i];
}

// ---- Shapes ---------------------------------------------------------------------------------------------------------

struct span {
    double entry, leave;
};

static void cut(struct span *span, double entry, double leave) {
    span->entry = fmax(span->entry, entry);
    span->leave = fmin(span->leave, leave);
}

// Cuts the span to where |position + parameter * step| <= half.
static void cut_slab(struct span *span, double position, double step, double half) {
    if (step == 0.0) {
        if (fabs(position) > half) span->leave = -INFINITY;
        return;
    }
    double a = (-half - position) / step, b = (half - position) / step;
    cut(span, fmin(a, b), fmax(a, b));
}

// Cuts the span to where |position + parameter * step| <= radius, in `axes` dimensions.
static void cut_round(struct span *span, const double *position, const double *step, int axes, double radius) {
    double a = 0.0, b = 0.0, c = -radius * radius;
    for (int i = 0; i < axes; i++) a += step[i] * step[i];
    for (int i = 0; i < axes; i++) b += position[i] * step[i];
    for (int i = 0; i < axes; i++) c += position[i] * position[i];
    double discriminant = b * b - a * c;
    if (discriminant < 0.0 || (a == 0.0 && c > 0.0)) span->leave = -INFINITY;
    else if (a > 0.0) cut(span, (-b - sqrt(discriminant)) / a, (-b + sqrt(discriminant)) / a);
}

static void turn(const struct vw_recipe_shape *shape, double sign, const double v[3], double turned[3]) {
    double cosine = shape->turn.x, sine = sign * shape->turn.y;
    turned[0] = cosine * v[0] - sine * v[1];
    turned[1] = sine * v[0] + cosine * v[1];
    turned[2] = v[2];
}

// Returns the parameter at which a line meets the shape, INFINITY when it does not. Origin and direction are relative
// to the shape: in a box's own axes, otherwise in the world's.
static double hit(const struct vw_recipe_shape *shape, const double origin[3], const double direction[3]) {
    struct span span = {-INFINITY, INFINITY};
    const double half[3] = {shape->extent.x, shape->extent.y, shape->extent.z};
    double radius = shape->centre_radius.w;
    if (shape->kind == SHAPE_PLANE) {
        double place[3], parameter = -dot(origin, half) / dot(direction, half);
        point_at(origin, direction, parameter, place);
        return parameter > NEAREST && sqrt(dot(place, place)) <= radius ? parameter : INFINITY;
    }
    if (shape->kind == SHAPE_SPHERE) cut_round(&span, origin, direction, 3, radius);
    if (shape->kind == SHAPE_CYLINDER) cut_round(&span, origin, direction, 2, radius);
    if (shape->kind == SHAPE_CYLINDER) cut_slab(&span, origin[2], direction[2], half[2]);
    for (int i = 0; i < 3 && shape->kind == SHAPE_BOX; i++) cut_slab(&span, origin[i], direction[i], half[i]);
    if (span.entry > span.leave) return INFINITY;
    return span.entry > NEAREST ? span.entry : span.leave > NEAREST ? span.leave : INFINITY;
}

// Outwards at a place on the surface, relative to the shape as above.
static void normal_at(const struct vw_recipe_shape *shape, const double place[3], double normal[3]) {
    const double half[3] = {shape->extent.x, shape->extent.y, shape->extent.z};
    double radius = shape->centre_radius.w;
    memset(normal, 0, 3 * sizeof *normal);
    if (shape->kind == SHAPE_PLANE) memcpy(normal, half, sizeof half);
    if (shape->kind == SHAPE_SPHERE)
        for (int i = 0; i < 3; i++) normal[i] = place[i] / radius;
    if (shape->kind == SHAPE_CYLINDER) {
        bool cap = fabs(fabs(place[2]) - half[2]) < fabs(hypot(place[0], place[1]) - radius);
        for (int i = 0; i < 2 && !cap; i++) normal[i] = place[i] / radius;
        if (cap) normal[2] = 1.0;
    }
    if (shape->kind == SHAPE_BOX) {
        int face = 0;
        for (int i = 1; i < 3; i++)
            if (fabs(fabs(place[i]) - half[i]) < fabs(fabs(place[face]) - half[face])) face = i;
        normal[face] = 1.0;
    }
}

struct hit {
    double parameter, normal[3]; // the normal faces the ray
    const struct vw_recipe_shape *shape;
};

static void to_shape(const struct vw_recipe_shape *shape, const double origin[3], const double direction[3],
                     double own_origin[3], double own_direction[3]) {
    const double from_centre[3] = {origin[0] - shape->centre_radius.x, origin[1] - shape->centre_radius.y,
                                   origin[2] - shape->centre_radius.z};
    memcpy(own_origin, from_centre, sizeof from_centre);
    memcpy(own_direction, direction, sizeof from_centre);
    if (shape->kind != SHAPE_BOX) return;
    turn(shape, -1.0, from_centre, own_origin);
    turn(shape, -1.0, direction, own_direction);
}

static struct hit nearest_hit(const struct reference_recipe *recipe, const double origin[3],
                              const double direction[3]) {
    struct hit nearest = {.parameter = INFINITY};
    double own_origin[3], own_direction[3], place[3], normal[3];
    for (uint32_t i = 0; i < recipe->push.shape_count; i++) {
        to_shape(&recipe->shapes[i], origin, direction, own_origin, own_direction);
        double parameter = hit(&recipe->shapes[i], own_origin, own_direction);
        if (parameter >= nearest.parameter) continue;
        nearest.parameter = parameter;
        nearest.shape = &recipe->shapes[i];
    }
    if (!nearest.shape) return nearest;
    to_shape(nearest.shape, origin, direction, own_origin, own_direction);
    point_at(own_origin, own_direction, nearest.parameter, place);
    normal_at(nearest.shape, place, normal);
    memcpy(nearest.normal, normal, sizeof normal);
    if (nearest.shape->kind == SHAPE_BOX) turn(nearest.shape, 1.0, normal, nearest.normal);
    double sign = dot(nearest.normal, direction) > 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++) nearest.normal[i] *= sign;
    return nearest;
}

// ---- Textures -------------------------------------------------------------------------------------------------------

static uint32_t mix_bits(uint32_t word) {
    word = (word ^ word >> 16) * UINT32_C(0x85EBCA6B);
    word = (word ^ word >> 13) * UINT32_C(0xC2B2AE35);
    return word ^ word >> 16;
}

static double smoothstep(double low, double high, double x) {
    double t = fmin(fmax((x - low) / (high - low), 0.0), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

static double value_noise(uint32_t seed, const double at[3]) {
    double value = 0.0;
    for (int i = 0; i < 8; i++) {
        double share = 1.0;
        uint32_t corner[3];
        for (int axis = 0; axis < 3; axis++) {
            double weight = smoothstep(0.0, 1.0, at[axis] - floor(at[axis]));
            int upper = i >> axis & 1;
            corner[axis] = (uint32_t)((int32_t)floor(at[axis]) + upper);
            share *= upper ? weight : 1.0 - weight;
        }
        value += share * (mix_bits(corner[0] + mix_bits(corner[1] + mix_bits(corner[2] + seed))) >> 8) / 16777216.0;
    }
    return value;
}

// Computes the texture's colour at `place`, which is relative to the shape's centre, in box axes.
static void texture(const struct reference_recipe *recipe, const struct vw_recipe_shape *shape, const double place[3],
                    double rgb[3]) {
    double at[3], share = 0.0;
    for (int i = 0; i < 3; i++) at[i] = place[i] / shape->colour_a.w;
    if (shape->texture == TEXTURE_CHECKER) {
        share = ((int)floor(at[0]) ^ (int)floor(at[1]) ^ (int)floor(at[2])) & 1;
    } else if (shape->texture == TEXTURE_STRIPES) {
        share =
            (int)floor(at[0] * shape->stripe_axis.x + at[1] * shape->stripe_axis.y + at[2] * shape->stripe_axis.z) & 1;
    } else if (shape->texture == TEXTURE_NOISE) {
        const double finer[3] = {2.7 * at[0], 2.7 * at[1], 2.7 * at[2]};
        share = smoothstep(0.2, 0.8,
                           0.65 * value_noise(recipe->push.seed, at) + 0.35 * value_noise(recipe->push.seed, finer));
    }
    const double a[3] = {shape->colour_a.x, shape->colour_a.y, shape->colour_a.z},
                 b[3] = {shape->colour_b.x, shape->colour_b.y, shape->colour_b.z};
    for (int i = 0; i < 3; i++) rgb[i] = (1.0 - share) * a[i] + share * b[i];
}

// ---- Light ----------------------------------------------------------------------------------------------------------

static void background(const struct vw_push_recipe *push, const double direction[3], double rgba[4]) {
    static const double low[3] = {0.80, 0.86, 0.92}, high[3] = {0.28, 0.47, 0.78};
    const double colour[3] = {push->background_colour.x, push->background_colour.y, push->background_colour.z};
    double height = sqrt(fmax(direction[2], 0.0));
    rgba[3] = push->background != BACKGROUND_TRANSPARENT;
    for (int i = 0; i < 3; i++) {
        double sky = (1.0 - height) * low[i] + height * high[i];
        rgba[i] = push->background == BACKGROUND_SKY ? sky : push->background == BACKGROUND_COLOUR ? colour[i] : 0.0;
    }
}

double reference_recipe_trace(const struct reference_recipe *recipe, const double origin[3], const double direction[3],
                              double rgba[4]) {
    const struct vw_push_recipe *push = &recipe->push;
    const double sun[3] = {push->sun.x, push->sun.y, push->sun.z};
    struct hit seen = nearest_hit(recipe, origin, direction);
    double place[3], above[3], from_centre[3];
    if (!seen.shape) {
        background(push, direction, rgba);
        return 0.0;
    }
    point_at(origin, direction, seen.parameter, place);
    point_at(place, seen.normal, NEAREST, above);
    const double centre[3] = {seen.shape->centre_radius.x, seen.shape->centre_radius.y, seen.shape->centre_radius.z};
    for (int i = 0; i < 3; i++) from_centre[i] = place[i] - centre[i] - 0.01 * seen.shape->colour_a.w * seen.normal[i];
    texture(recipe, seen.shape, from_centre, rgba);
    bool lit = !nearest_hit(recipe, above, sun).shape;
    double light = push->ambient + (lit ? push->sun.w * fmax(dot(seen.normal, sun), 0.0) : 0.0);
    for (int i = 0; i < 3; i++) rgba[i] = fmin(rgba[i] * light, 1.0);
    rgba[3] = 1.0;
    return seen.parameter;
}

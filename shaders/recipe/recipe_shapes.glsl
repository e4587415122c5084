// The first intersection of a ray with a shape of a recipe. All lengths are box edges; the z axis points up.
#ifndef RECIPE_SHAPES_GLSL
#define RECIPE_SHAPES_GLSL

const float NO_HIT = 1e30;
const float NEAREST = 1e-4; // hits closer than this belong to the surface that the ray starts from

struct surface_hit {
    float ray_parameter; // NO_HIT when there is none
    vec3 normal;         // unit vector facing the ray
};

// Turns a vector about the z axis; turn = (cosine, sine).
vec3 turn_about_z(vec3 v, vec2 turn) { return vec3(turn.x * v.x - turn.y * v.y, turn.y * v.x + turn.x * v.y, v.z); }

// Returns the first crossing of a solid's surface that lies ahead: inside a solid that is the way out.
float first_ahead(float entry, float leave) {
    if (entry > leave) return NO_HIT;
    if (entry > NEAREST) return entry;
    return leave > NEAREST ? leave : NO_HIT;
}

surface_hit hit_sphere(float radius, vec3 origin, vec3 direction) {
    float middle = -dot(origin, direction);
    vec3 nearest_point = origin + middle * direction;
    float half_chord2 = radius * radius - dot(nearest_point, nearest_point);
    if (half_chord2 < 0.0) return surface_hit(NO_HIT, vec3(0.0));
    float half_chord = sqrt(half_chord2);
    float t = first_ahead(middle - half_chord, middle + half_chord);
    return surface_hit(t, (origin + t * direction) / radius);
}

surface_hit hit_box(vec3 half_extent, vec2 turn, vec3 origin, vec3 direction) {
    vec2 back_turn = vec2(turn.x, -turn.y);
    vec3 o = turn_about_z(origin, back_turn);
    vec3 d = turn_about_z(direction, back_turn);
    d = mix(d, vec3(1e-12), lessThan(abs(d), vec3(1e-12)));
    vec3 middle = -o / d;
    vec3 reach = half_extent / abs(d);
    vec3 entries = middle - reach;
    vec3 leaves = middle + reach;
    float entry = max(entries.x, max(entries.y, entries.z));
    float leave = min(leaves.x, min(leaves.y, leaves.z));
    float t = first_ahead(entry, leave);
    vec3 face = t == entry ? vec3(equal(entries, vec3(entry))) : vec3(equal(leaves, vec3(leave)));
    return surface_hit(t, turn_about_z(normalize(face * sign(d)), turn));
}

// Intersects a disc; an unlimited plane is a disc of huge radius.
surface_hit hit_plane(vec3 normal, float radius, vec3 origin, vec3 direction) {
    float approach = dot(direction, normal);
    float t = -dot(origin, normal) / (abs(approach) < 1e-12 ? 1e-12 : approach);
    bool hit = t > NEAREST && length(origin + t * direction) <= radius;
    return surface_hit(hit ? t : NO_HIT, normal);
}

// Intersects an upright cylinder with both caps: the part of a tube between two levels.
surface_hit hit_cylinder(float radius, float half_height, vec3 origin, vec3 direction) {
    float a = max(dot(direction.xy, direction.xy), 1e-12);
    float middle = -dot(origin.xy, direction.xy) / a;
    vec2 nearest_point = origin.xy + middle * direction.xy;
    float half_chord2 = (radius * radius - dot(nearest_point, nearest_point)) / a;
    if (half_chord2 < 0.0) return surface_hit(NO_HIT, vec3(0.0));
    float half_chord = sqrt(half_chord2);
    float climb = abs(direction.z) < 1e-12 ? 1e-12 : direction.z;
    vec2 level = (vec2(-half_height, half_height) - origin.z) / climb;
    float entry = max(middle - half_chord, min(level.x, level.y));
    float leave = min(middle + half_chord, max(level.x, level.y));
    float t = first_ahead(entry, leave);
    bool on_cap = t == level.x || t == level.y;
    return surface_hit(t, on_cap ? vec3(0.0, 0.0, 1.0) : vec3((origin.xy + t * direction.xy) / radius, 0.0));
}

surface_hit hit_shape(vw_recipe_shape shape, vec3 origin, vec3 direction) {
    vec3 o = origin - shape.centre_radius.xyz;
    float radius = shape.centre_radius.w;
    surface_hit hit;
    if (shape.kind == SHAPE_SPHERE) hit = hit_sphere(radius, o, direction);
    else if (shape.kind == SHAPE_BOX) hit = hit_box(shape.extent.xyz, shape.turn.xy, o, direction);
    else if (shape.kind == SHAPE_PLANE) hit = hit_plane(shape.extent.xyz, radius, o, direction);
    else hit = hit_cylinder(radius, shape.extent.z, o, direction);
    hit.normal = faceforward(hit.normal, direction, hit.normal);
    return hit;
}

#endif

// One pixel of a recipe's photo per invocation: nearest shape, its texture, sun with hard shadows, ambient light.
// A ray takes at most (64 + 1 samples) * 2 * 256 shapes trips, below the 65,535 that some drivers allow an invocation.
#include "rays/camera.glsl"
#include "random.glsl"
#include "recipe/recipe_shapes.glsl"
#include "recipe/recipe_textures.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_RECIPE_SHAPES) readonly buffer Shapes { vw_recipe_shape shapes[]; };
BUFFER(VW_SLOT_RECIPE_PIXELS) writeonly buffer Pixels { vw_recipe_pixel pixels[]; };
PUSH uniform Push { vw_push_recipe push; };

struct scene_hit {
    surface_hit surface;
    uint shape;
};

scene_hit nearest_hit(vec3 origin, vec3 direction) {
    scene_hit nearest = scene_hit(surface_hit(NO_HIT, vec3(0.0)), 0u);
    for (uint i = 0u; i < push.shape_count; i++) {
        surface_hit hit = hit_shape(shapes[i], origin, direction);
        if (hit.ray_parameter < nearest.surface.ray_parameter) nearest = scene_hit(hit, i);
    }
    return nearest;
}

vec3 sky_colour(vec3 direction) {
    if (push.background == BACKGROUND_SKY)
        return mix(vec3(0.80, 0.86, 0.92), vec3(0.28, 0.47, 0.78), sqrt(max(direction.z, 0.0)));
    return push.background_colour.rgb;
}

// Returns the colour and coverage along one ray.
vec4 trace(vw_ray ray) {
    vec3 origin = ray.origin_near.xyz;
    vec3 direction = ray.direction_stride.xyz;
    scene_hit hit = nearest_hit(origin, direction);
    if (hit.surface.ray_parameter == NO_HIT) {
        bool opaque = push.background != BACKGROUND_TRANSPARENT;
        return vec4(opaque ? sky_colour(direction) : vec3(0.0), opaque ? 1.0 : 0.0);
    }
    vw_recipe_shape shape = shapes[hit.shape];
    vec3 position = origin + hit.surface.ray_parameter * direction;
    vec3 normal = hit.surface.normal;
    // A little inside the surface, so that a face on a texture's cell border falls into one cell.
    vec3 colour =
        texture_colour(shape, position - shape.centre_radius.xyz - 0.01 * shape.colour_a.w * normal, push.seed);
    float sun = max(dot(normal, push.sun.xyz), 0.0);
    if (nearest_hit(position + NEAREST * normal, push.sun.xyz).surface.ray_parameter != NO_HIT) sun = 0.0;
    return vec4(min(colour * (push.ambient + push.sun.w * sun), vec3(1.0)), 1.0);
}

void main() {
    uint index = invocation_index();
    if (index >= push.pixel_count) return;
    uint pixel = push.first_pixel + index;
    vw_gpu_camera camera = cameras[push.view];
    vec2 corner = vec2(pixel % push.width_px, pixel / push.width_px);
    float side = float(push.samples_side);
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < push.samples_side * push.samples_side; i++) {
        vec2 inside = (vec2(i % push.samples_side, i / push.samples_side) + 0.5) / side;
        sum += trace(camera_ray(camera, corner + inside));
    }
    vw_ray centre = camera_ray(camera, corner + 0.5);
    float depth = nearest_hit(centre.origin_near.xyz, centre.direction_stride.xyz).surface.ray_parameter;
    // An uncovered sample is black: dividing by the coverage gives the straight colour.
    vec3 colour = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
    pixels[index] = vw_recipe_pixel(vec4(colour, sum.a / (side * side)), depth == NO_HIT ? 0.0 : depth);
}

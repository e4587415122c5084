// Everything host and shaders share about recipes, a part of interface.h; trace_recipe alone uses it. All positions and
// lengths are box coordinates and box edges; z is up.
#ifndef VIEWWORTH_RECIPE_INTERFACE_H
#define VIEWWORTH_RECIPE_INTERFACE_H

VW_ENUM(SHAPE_SPHERE, 0)
VW_ENUM(SHAPE_BOX, 1)
VW_ENUM(SHAPE_PLANE, 2)
VW_ENUM(SHAPE_CYLINDER, 3)
VW_ENUM(TEXTURE_PLAIN, 0)
VW_ENUM(TEXTURE_CHECKER, 1)
VW_ENUM(TEXTURE_STRIPES, 2)
VW_ENUM(TEXTURE_NOISE, 3)
VW_ENUM(BACKGROUND_COLOUR, 0)
VW_ENUM(BACKGROUND_SKY, 1)
VW_ENUM(BACKGROUND_TRANSPARENT, 2)

struct vw_recipe_shape {
    vw_float4 centre_radius; // w: radius of a sphere, a cylinder, or the disc that is a plane
    vw_float4 extent;        // half extents of a box, normal of a plane, z: half height of a cylinder
    vw_float4 turn;          // cosine and sine of a box's turn about z
    vw_float4 colour_a;      // w: size of a texture cell
    vw_float4 colour_b;
    vw_float4 stripe_axis;   // unit vector across the stripes
    vw_uint kind, texture;
};

struct vw_recipe_pixel {
    vw_float4 rgba;          // straight alpha
    float depth;             // box edges along the ray through the pixel's centre; 0: nothing is hit
};

struct vw_push_recipe {
    vw_uint view, first_pixel, pixel_count; // a range of one view's pixels; the output starts at 0
    vw_uint width_px, samples_side;         // samples_side^2 samples per pixel
    vw_uint shape_count, background;
    vw_uint seed;                // seed of the noise texture
    float ambient;
    vw_float4 sun;               // unit vector towards the sun; w: intensity
    vw_float4 background_colour; // rgb of BACKGROUND_COLOUR
};

#endif

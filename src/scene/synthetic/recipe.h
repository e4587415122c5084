// Recipes: procedural scenes. Their photos are ray-traced, and it is known which of them are corrupted (decision 13).
//
// A recipe is a JSON file. z points up; angles are in degrees, lengths in world units, colours in [0,1] and
// sRGB-encoded. Unknown keys are refused. The keys, with defaults in parentheses:
//
//   viewworth_recipe: 1
//   seed: key of random choices and noise (0)
//   image: width_px, height_px; samples_per_pixel: 1, 4, 9, ... 64 (4)
//   box: centre, half_extent; the field covers it, and all content should be inside
//   background: [r,g,b], "sky" (a gradient) or "transparent" (photos have alpha) (black)
//   sun: direction (towards the sun), intensity; ambient: light from all directions; spread_deg: standard deviation,
//     over photos, of the sun's rotation about z (0) (without the key: no sun, ambient 1)
//   exposure: how all photos differ, test and validation photos included. Standard deviations: gain (of the logarithm
//     of a photo's gain), tint (of the logarithm of each channel's additional gain), bias (of each channel's bias)
//     (0)
//   shapes: kind, centre and
//     sphere: radius
//     box: half_extent [x,y,z], turn_deg: rotation about z (0)
//     cylinder: radius, height; it is upright and closed
//     plane: normal ([0,0,1]), radius of its disc (unlimited)
//     texture of any shape: kind plain, checker, stripes or noise; colour; except for plain also second_colour and
//       cell (size of a cell); for stripes also axis: the direction across them ([0,0,1])
//   cameras: path "orbit", centre, radius, count, field_of_view_deg (horizontal); elevation_deg [first, last] ([30,
//     30]), start_deg (0), turns (1), look_at (centre), distortion {k1, k2, p1, p2}, provider, split
//   points: "none" leaves out surface points and who sees them (all)
//   defects: kind, strength, and one of views: [indices], every: n (each n-th clean train view), share: of the train
//     views, by seed. The strength is for
//     noise: standard deviation
//     blur: standard deviation in px
//     occluder: share of the photo that it covers
//     exposure: gain, with bias added after it
//     wrong_pose: rotation of the recorded pose in degrees
//     striped_box: side of a square in front of everything, as a share of the photo's width (at most its height), with
//       ten stripes of random colours; NeRF-W's own occluders have 0.25
//   transients: share of all photos that have a disc of a random colour in front, which the photo's mask hides; size:
//     share of the photo that the disc covers (0.1)
//
// View i is named "view_iii". Without `split` it is val if i % 8 == 0, test if i % 8 == 4, otherwise train. Only train
// views can be corrupted, each by one defect. Points come from the true geometry; a view with a wrong pose has no
// tracks.
#ifndef VIEWWORTH_SCENE_SYNTHETIC_RECIPE_H
#define VIEWWORTH_SCENE_SYNTHETIC_RECIPE_H

#include "viewworth/scene.h"

enum { VW_RECIPE_LIMIT_BYTES = 1 << 24 }; // largest recipe file

// Fills the views (with splits), box, background, points and tracks of an empty scene from params->path. After a
// failure the scene is incomplete; vw_scene_close frees it. With headers_only there are no pixels, hashes or points,
// and params->gpu may be NULL.
enum vw_status vw_recipe_load(const struct vw_scene_params *params, struct vw_scene *scene);

#endif

// Recipes: procedural scenes whose photos are ray-traced and whose corrupted photos are known (design, decision 13).
//
// A recipe is a JSON file. z points up; angles are degrees, lengths world units, colours [0,1] and sRGB-encoded.
// Defaults stand in parentheses; unknown keys are refused.
//   viewworth_recipe  1
//   seed              what random choices and noise are keyed by (0)
//   image             width_px, height_px; samples_per_pixel: 1, 4, 9, ... 64 (4)
//   box               centre, half_extent: where the field lives; all content belongs inside
//   background        [r,g,b], "sky" (a gradient) or "transparent" (photos carry alpha) (black) sun direction (towards
//   it), intensity; ambient: light that comes from everywhere;
//                     spread_deg: standard deviation over photos of its turn about z (0)                     (no sun,
//                     ambient 1)
//   exposure          what all photos differ in, those that test and validate as well: standard deviations `gain` of
//   the logarithm of a
//                       photo's gain, `tint` of that of each channel's own gain beside it, `bias` of each channel's
//                       bias (0)
//   shapes            kind and centre, and for a
//                       sphere:   radius                                box:   half_extent [x,y,z], turn_deg about z
//                       (0) cylinder: radius, height (upright, closed)      plane: normal ([0,0,1]), radius of its disc
//                       (unlimited)
//                     texture: kind plain, checker, stripes or noise; colour; and but for plain: second_colour, cell:
//                     size of a
//                       cell, for stripes also axis across them ([0,0,1])
//   cameras           path "orbit", centre, radius, count, field_of_view_deg (horizontal); elevation_deg [first, last]
//   ([30, 30]),
//                       start_deg (0), turns (1), look_at (centre), distortion {k1, k2, p1, p2}, provider, split
//   defects           kind and strength: noise (standard deviation), blur (standard deviation in px), occluder (share
//   of the photo
//                       covered), exposure (gain; with bias, added after it), wrong_pose (degrees the recorded pose is
//                       turned);
//                     views: [indices], or every: n (each n-th clean train view), or share: of the train views, chosen
//                     by seed
//   transients        share of all photos with a disc of a random colour in front, which the photo's mask hides; size:
//   share of the photo
//                       that it covers (0.1)
// View i is "view_iii"; without `split` it is val when i % 8 == 0, test when i % 8 == 4, train else. Only train views
// can be corrupted, each by one defect. Points come from the true geometry; a view with a wrong pose has no tracks.
#ifndef VIEWWORTH_RECIPE_H
#define VIEWWORTH_RECIPE_H

#include "viewworth/scene.h"

enum { VW_RECIPE_LIMIT_BYTES = 1 << 24 }; // of a recipe file

// Fills the views (split included), box, background, points and tracks of an empty scene from params->path. On failure
// the scene is half-filled; vw_scene_close frees it. With headers_only there are no pixels, hashes or points, and
// params->gpu may be NULL.
enum vw_status vw_recipe_load(const struct vw_scene_params *params, struct vw_scene *scene);

#endif

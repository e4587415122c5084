// Evidence of effects. Facts in the files are exact, one number per scene. Photos of the splits train and val count;
// for lenses, all photos.
#ifndef VIEWWORTH_DETECT_FACTS_H
#define VIEWWORTH_DETECT_FACTS_H

#include "viewworth/scene.h"

// Returns the largest shift of a photo's corner by its lens, in pixels, over all photos. No photo resolves a hundredth
// of a pixel.
double vw_fact_distortion(const struct vw_scene *scene);
// Returns the share of photos that have transparent pixels.
double vw_fact_background(const struct vw_scene *scene);
// Returns the share of photos that have a mask file. Any share calls for the effect.
double vw_fact_masks(const struct vw_scene *scene);

#endif

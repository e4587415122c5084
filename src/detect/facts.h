// Evidence of effects. Facts in the files are exact, one number per scene. Photos of the splits train and val count;
// for lenses, all photos. The share of the box that is filled is measured on a trained field.
#ifndef VIEWWORTH_DETECT_FACTS_H
#define VIEWWORTH_DETECT_FACTS_H

#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Returns the largest shift of a photo's corner by its lens, in pixels, over all photos. No photo resolves a hundredth
// of a pixel.
double vw_fact_distortion(const struct vw_scene *scene);
// Returns the share of photos that have transparent pixels.
double vw_fact_background(const struct vw_scene *scene);
// Returns the share of photos that have a mask file. Any share calls for the effect.
double vw_fact_masks(const struct vw_scene *scene);

// ---- Measured on a pilot ----

struct vw_radiance_field;

// Measures the share of the cells of a lattice of `samples`^3 over the box whose middle has a density worth sampling:
// one that makes a sample of a ray across the box at least 1 % opaque. `samples` is that of the field's config. Call it
// when nothing is in flight.
enum vw_status vw_occupied_share(struct vw_radiance_field *field, uint32_t samples, double *share);

#endif

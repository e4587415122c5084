// Cost of the transport of the train photos to the validation photos, and its rise with the mass of each train photo
// (LAVA: Just et al., ICLR 2023, with thumbnails and poses in place of a network's features).
#ifndef VIEWWORTH_LAB_METHODS_PHOTO_TRANSPORT_H
#define VIEWWORTH_LAB_METHODS_PHOTO_TRANSPORT_H

#include "lab/methods/photo_pixels.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Fills a calibrated gradient per photo (optimal_transport.h), NaN without validation photos and if the transport did
// not converge. The cost of a pair is the sum of three squared distances, each divided by its mean over all pairs: of
// thumbnails, of positions, and of axes. The temperature is a twentieth of the mean cost. `pixels`: of each photo;
// those of the validation photos are measured here.
enum vw_status vw_photo_transport(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                  const struct vw_photo_pixels *pixels, double *gradients);

#endif

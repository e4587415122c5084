// Features of a pixel, for the effect uncertainty: VW_FEATURES numbers of about unit size.
//
// They are those of maps beside the photos, made elsewhere, for example by DINOv2: features/NAME.npy of the photo
// images/NAME.jpg (image/feature_file.h). A map covers its whole photo, whatever its resolution, and is interpolated.
// Every number is shifted and scaled to a mean of 0 and a deviation of 1 over the maps of all train photos, whichever
// of these a training takes. Maps of more channels are first projected by random signs, the same in every run.
//
// Where no train photo has a map, they are of the photo itself: its colour; the gradient of its luminance; mean colour,
// and deviation of the luminance, among the pixel's neighbours and in a tenth of the photo's width. The rest is 0.
#ifndef VIEWWORTH_SCENE_FEATURES_H
#define VIEWWORTH_SCENE_FEATURES_H

#include "viewworth/scene.h"

enum { VW_FEATURES = 31 };

struct vw_features;

// Reads the maps of all train photos, unless they were read before; the scene keeps them until it is closed. From any
// thread. VW_ERROR_INPUT names the file at fault, or the photo without one, if others have maps. VW_ERROR_IO if a map
// is not the one that was hashed.
enum vw_status vw_features_open(const struct vw_scene *scene);
void vw_features_close(struct vw_features **features); // when the scene is closed; accepts NULL
// Computes the features at a position of a train photo, which is decoded, once they are open. Beyond the photo they are
// those at its edge.
void vw_features_at(const struct vw_scene *scene, uint32_t view, float x_px, float y_px, float numbers[VW_FEATURES]);

#endif

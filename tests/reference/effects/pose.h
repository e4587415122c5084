// The effect pose in double: what a correction makes of a camera, by an angle about an axis, and the gradient by the
// position of a sample.
#ifndef VIEWWORTH_TESTS_REFERENCE_POSE_H
#define VIEWWORTH_TESTS_REFERENCE_POSE_H

#include "reference/reference.h"

enum { REFERENCE_POSE = 6 }; // a shift in box edges, a turn

extern const double reference_pose_ridge;
double reference_pose_rate(uint64_t visits); // times the learning rate
enum { REFERENCE_POSE_WARM_UP = 32 };        // steps that move no camera

// Reads the numbers of a view from a params block.
void reference_pose_of(const struct vw_model *model, const float *params, uint32_t view, double pose[REFERENCE_POSE]);
// Returns the view as its corrected camera sees it.
struct vw_view reference_pose_apply(const struct vw_view *view, const struct vw_box *box,
                                    const double pose[REFERENCE_POSE]);
// Computes the gradient by the six numbers from the force on the camera and the torque about it.
void reference_pose_gradient(const struct vw_view *view, const struct vw_box *box, const double pose[REFERENCE_POSE],
                             const double force[3], const double torque[3], double gradient[REFERENCE_POSE]);

// Encodes like reference_grid_encode(), but within a cell as smoothly in the position as doubles are. `cells` receives
// the cell of each level.
void reference_encode_smoothly(const struct vw_specialization *s, const double *grid, const double position[3],
                               double *encoding, uint32_t cells[VW_LEVELS_MAX][3]);
// Computes the gradient by the position from that by the encoding. Returns the sum of the magnitudes of what it adds.
double reference_encode_back(const struct vw_specialization *s, const double *grid, const double position[3],
                             const double *d_encoding, double d_position[3]);

#endif

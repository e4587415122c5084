// How far the effect pose has corrected the train cameras: by turns, and by shifts in box edges. 0 without the effect.
#ifndef VIEWWORTH_TRAIN_CAMERA_CORRECTIONS_H
#define VIEWWORTH_TRAIN_CAMERA_CORRECTIONS_H

struct vw_camera_corrections {
    double mean_deg, largest_deg, mean_edges, largest_edges;
};

#endif

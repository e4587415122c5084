// A photo of a group of near-duplicates: scene/ finds them, value/ adds up their scores.
#ifndef VIEWWORTH_DUPLICATE_H
#define VIEWWORTH_DUPLICATE_H

#include <stdint.h>

struct vw_duplicate {
    uint32_t group;    // 0, 1, ...
    uint32_t view;     // index in vw_scene.views
    double similarity; // to the first of its group, -1 to 1: see scene/duplicates.h; 1 for files of equal bytes and for
                       // the first
};

#endif

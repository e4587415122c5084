// A photo in a group of near-duplicates. scene/ finds the groups, value/ adds up their scores.
#ifndef VIEWWORTH_BASE_DUPLICATE_H
#define VIEWWORTH_BASE_DUPLICATE_H

#include <stdint.h>

struct vw_duplicate {
    uint32_t group;    // 0, 1, ...
    uint32_t view;     // index in vw_scene.views
    double similarity; // to the first photo of the group, 0 to 1 (see scene/duplicates.h); 1 for equal files and for
                       // the first photo
};

#endif

// Evidence on photos, and the defects that it shows.
#ifndef VIEWWORTH_CHECK_EVIDENCE_H
#define VIEWWORTH_CHECK_EVIDENCE_H

#include <stdint.h>

#include "base/defect.h"

// Evidence on a photo. NaN: unknown.
struct vw_photo_evidence {
    double contrast;         // standard deviation of the luminance, [0,1]
    uint32_t expected_count; // points that it should show
    double in_place;         // share of them that it shows within 1.25 small pixels
    double hidden; // share of the photo in the largest region that shows none of them, though others are shown
    // Measures beside photos that show the same points: a median over these, and quarters of them.
    double stops, stops_spread;       // exposure: log2 of linear luminance; half of the range of the middle half
    double sharpness, sharpness_high; // amplitude of the finest details, in the direction that has least; upper quarter
    double evenness;                  // that divided by the amplitude in the direction that has most
    double motion_deg;                // that direction: 0 along x, 90 along y
    double noise;                     // amplitude of what has no direction: lower quarter
    // Shares that are in place by another explanation, where few are
    double turned_over_in_place, found_in_place, zoomed_in_place, shows_in_place;
    double turned_over_deg;      // 90, 180 or 270: once its pixels are turned back by so much; 0: not so
    double turned_deg, moved_px; // at another pose than the scene's, so far away; NaN: not so
    double pose_found[3][4];     // camera_to_world of that; meaningless if turned_deg is NaN
    double zoom;                 // with so many times the focal length of its camera; NaN: not so
    uint32_t orientation;        // by EXIF, 1 to 8; 0: not given
    uint32_t shows;              // at the pose of another photo (scene index); UINT32_MAX: not so
    uint32_t tracks;             // points of the scene that it tracks
    double track_px;             // median distance of these tracks from where its pose sees the points
    double behind;               // share of these points that it faces away from
    uint32_t copy_of;            // scene index of the photo to keep of its near-duplicates; UINT32_MAX: itself
    double similarity;           // to the first of them
};

// All of a scene. Owned: free both with vw_check_free().
struct vw_check {
    struct vw_photo_evidence *evidence; // by scene index; of an excluded photo all but its orientation is unknown
    struct vw_defect *defects;          // by scene index, the gravest of a photo first
    uint32_t view_count, defect_count;
    uint32_t point_count, made_count; // points of the scene and others
};

#endif

// Regions of a photo that the field does not explain, though it explains the same places in nearby photos: something
// covers the scene there. Of panes alone, without scene, field or files. Internal to src/run/outputs.
//
// A pixel of a pane is covered if its error is far above the median of all panes, and above the errors of at least two
// nearby panes at the place that it should show (by the field's depth); so are pixels of half that error around it.
#ifndef VIEWWORTH_RUN_OUTPUTS_COVER_REGIONS_H
#define VIEWWORTH_RUN_OUTPUTS_COVER_REGIONS_H

#include "run/outputs/residuals.h"
#include "scene/view_distance.h"

// A photo beside its render. Arrays are owned, a number per pixel, rows top to bottom.
struct vw_cover_pane {
    const struct vw_view *view; // borrowed: its pose; NULL: the photo takes no part
    struct vw_camera camera;    // at the size of the pane
    bool tells;                 // other panes are judged by it
    float *errors;              // smoothed error of the colours, in [0,1]; NaN: the pixel does not count
    float *depths;              // along the axis, world units; 0: nothing is seen there
};

struct vw_cover_panes {
    struct vw_cover_pane *list;
    uint32_t count;
    double middle_world[3]; // the middle of the scene
    struct vw_view_scales scales;
    double seed_error; // error from which a pixel is covered
};

// Makes the errors of a pane: those that remain after the gain and bias per channel that fit best without outliers.
// VW_ERROR_MEMORY.
enum vw_status vw_cover_make_errors(const struct vw_panes *panes, struct vw_cover_pane *pane);
// Sets seed_error once all errors are there. VW_ERROR_MEMORY.
enum vw_status vw_cover_settle(struct vw_cover_panes *panes);
// Marks the covered pixels of a pane by true; `*share`: their share of it. VW_ERROR_MEMORY.
enum vw_status vw_cover_find(const struct vw_cover_panes *panes, uint32_t place, bool *covered, double *share);

#endif

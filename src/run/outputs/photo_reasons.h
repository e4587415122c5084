// Why a photo may fit badly, in a word of report/advice.h, by what can be measured without ground truth. A reason
// explains advice and never changes it.
#ifndef VIEWWORTH_RUN_OUTPUTS_PHOTO_REASONS_H
#define VIEWWORTH_RUN_OUTPUTS_PHOTO_REASONS_H

#include "image/image.h"
#include "run/outputs/residuals.h"
#include "viewworth/status.h"

// Finds one static word per view of the run; NULL: none found, or not a train photo.
//  - exposure: points that it shares with other photos show it far brighter or darker than the median photo
//  - blur, noise: its sharpness is far below, or its noise far above, that of the median train photo
//  - pose: its render fits much better when it is moved sideways
//  - occluder: one connected region has most of the error of its render
// The last two need renders. The photos of lowest quality have them first, for at most half as many rays as
// residuals.json.
enum vw_status vw_photo_reasons_find(const struct vw_residuals_params *params, const char **reasons);

// Finds "blur" and "noise" by the photos' measures, one reason per photo. VW_ERROR_MEMORY.
enum vw_status vw_photo_reasons_of_luminance(const struct vw_luminance *measured, uint32_t count, const char **reasons);
// Finds "pose" or "occluder", else leaves the reason as it is. VW_ERROR_MEMORY.
enum vw_status vw_photo_reason_of_panes(const struct vw_panes *panes, const char **reason);

#endif

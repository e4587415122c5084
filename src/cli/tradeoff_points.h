// Which settings `tradeoff` tries: the base, as the options have it, and around it one knob at a time.
#ifndef VIEWWORTH_CLI_TRADEOFF_POINTS_H
#define VIEWWORTH_CLI_TRADEOFF_POINTS_H

#include <stdint.h>

#include "cli/options.h"
#include "cli/stage.h"
#include "viewworth/status.h"

enum { VW_POINT_NAME_BYTES = 48, VW_POINT_SETTING_BYTES = 200, VW_POINTS_MAX = 96 };

struct vw_tradeoff_point {
    char name[VW_POINT_NAME_BYTES];       // "base", "rays-125": also its folder's name
    const char *knob;                     // "base", "rays", ...; static
    char setting[VW_POINT_SETTING_BYTES]; // "125"; of the base, all of them: "rays 500, samples 32, ..."
    struct vw_config config;              // of the first seed; effects are spelled out as the base decided them
    uint32_t downscale;
};

struct vw_tradeoff_points {
    struct vw_tradeoff_point points[VW_POINTS_MAX];
    uint32_t count;                  // the first is the base
    uint32_t exhaustive, all_pixels; // the points of these names; UINT32_MAX where `all_pixels` is not tried
};

// What can be turned, for messages and --help.
#define VW_TRADEOFF_KNOBS "rays, samples, val-rays, levels, log2-table, width, epochs, table-precision, downscale, effects, accuracy"
// VW_ERROR_USAGE unless `knobs` is NULL (all of them) or names of knobs with commas between.
enum vw_status vw_tradeoff_check_knobs(const char *knobs);
// Lists the points for the options and a stage on which effects are decided. Settings that the config does not admit, or that come to the
// same as another, are left out. The exhaustive point is always there: all validation pixels, and twice the rays
// where the device admits them.
enum vw_status vw_tradeoff_points_list(const struct vw_options *options, const struct vw_stage *stage, struct vw_tradeoff_points *points);

#endif

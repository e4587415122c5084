// --preset: the options of a published method by one name. src/train/README.md says which facts each follows, and where
// it departs.
#ifndef VIEWWORTH_CLI_OPTION_PRESETS_H
#define VIEWWORTH_CLI_OPTION_PRESETS_H

#include <stdint.h>

enum vw_option_preset {
    VW_PRESET_NONE,
    VW_PRESET_HASH,
    VW_PRESET_NERF,
    VW_PRESET_NERF_W,
    VW_PRESET_HA_NERF,
    VW_PRESET_PAPER,
    VW_PRESET_COUNT
};

const char *vw_option_preset_name(uint32_t preset); // "none", "hash", "nerf", ...

// An option that a preset gives, as on the command line.
struct vw_option_of_preset {
    const char *name, *value; // name: NULL after the last one
};
const struct vw_option_of_preset *vw_option_preset_options(enum vw_option_preset preset);

#endif

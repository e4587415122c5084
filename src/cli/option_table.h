// The options of viewworth.
#ifndef VIEWWORTH_CLI_OPTION_TABLE_H
#define VIEWWORTH_CLI_OPTION_TABLE_H

#include <stdint.h>

#include "cli/option.h"
#include "cli/options.h"

extern const struct vw_option vw_option_table[];
extern const uint32_t vw_option_count;
extern const struct vw_options vw_options_default;

#endif

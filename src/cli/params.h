// From the command line to params: texts are borrowed from the options, the config is theirs.
#ifndef VIEWWORTH_CLI_PARAMS_H
#define VIEWWORTH_CLI_PARAMS_H

#include "cli/options.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"

// Returns the scene that the operand names, with the scene options.
struct vw_scene_params vw_params_of_scene(const struct vw_options *options);
// Parses --memory and obeys it from now on; VW_ERROR_USAGE says what it takes.
enum vw_status vw_params_set_memory(const struct vw_options *options);
// Parses --budget; VW_ERROR_USAGE says what it takes. Without progress.
enum vw_status vw_params_of_run(const struct vw_options *options, struct vw_run_params *params);

#endif

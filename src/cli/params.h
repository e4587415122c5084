// Params from the command line: texts are borrowed from the options, the config is theirs.
#ifndef VIEWWORTH_CLI_PARAMS_H
#define VIEWWORTH_CLI_PARAMS_H

#include <stdint.h>

#include "cli/options.h"
#include "cli/output/progress.h"
#include "experiment/experiment.h"
#include "run/session.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"

// Parses --memory and obeys it from now on; VW_ERROR_USAGE says what it takes.
enum vw_status vw_params_set_memory(const struct vw_options *options);
// Returns the bits (vw_config_explicit) of the config's numbers that the options name.
uint64_t vw_params_explicit_fields(const struct vw_options *options);
// Parses --budget; VW_ERROR_USAGE says what it takes. Without progress.
enum vw_status vw_params_of_run(const struct vw_options *options, struct vw_run_params *params);

enum { VW_DEVICE_NAME_BYTES = 256 }; // as long as a device's name can be

// The devices that --devices names.
struct vw_device_list {
    char names[VW_SESSION_DEVICES_MAX][VW_DEVICE_NAME_BYTES]; // indices or parts of names
    const char *texts[VW_SESSION_DEVICES_MAX];                // the same, as an array of texts
    uint32_t count;                                           // 0: --devices was not given
};
// Reads the list of --devices, or lists all devices for "all". VW_ERROR_USAGE when it is not a list, or when --device
// is given too.
enum vw_status vw_device_list_read(const struct vw_options *options, struct vw_device_list *list);
// Returns the devices of the list, or that of --device without a list. The choice borrows from both.
struct vw_device_choice vw_device_list_choose(const struct vw_options *options, const struct vw_device_list *list);

// Chooses field and size where the options leave them open, and applies --accuracy. VW_ERROR_USAGE lists the levels.
enum vw_status vw_params_settle(const struct vw_options *options, const char *device, struct vw_scene_params *scene,
                                struct vw_config *config);

// Opens a scene with its pixels, and first a device for a recipe, which `*gpu` owns; NULL otherwise. Without a
// downscale the headers choose it (NULL: 1).
enum vw_status vw_params_open_scene(const struct vw_scene_params *params,
                                    uint32_t (*choose_downscale)(const struct vw_scene *headers), const char *device,
                                    struct vw_gpu **gpu, struct vw_scene **scene);

// The request of an experiment, and what it borrows; all zero before.
struct vw_experiment_request {
    struct vw_device_list devices;
    struct vw_config config;
    struct vw_progress progress; // shows the runs; vw_progress_end() ends it
    struct vw_experiment_params params;
};
// Makes the params of an experiment from the options. After this call SIGINT and SIGTERM interrupt it.
enum vw_status vw_params_of_experiment(const struct vw_options *options, struct vw_experiment_request *request);

#endif

// The devices that --devices names.
#ifndef VIEWWORTH_CLI_DEVICE_LIST_H
#define VIEWWORTH_CLI_DEVICE_LIST_H

#include <stdint.h>

#include "cli/options.h"
#include "run/session.h"
#include "viewworth/status.h"

enum { VW_DEVICE_NAME_BYTES = 256 }; // as long as a device's name can be

struct vw_device_list {
    char names[VW_SESSION_DEVICES_MAX][VW_DEVICE_NAME_BYTES]; // indices or parts of names
    const char *texts[VW_SESSION_DEVICES_MAX];                // the same, as whoever takes an array wants them
    uint32_t count;                                           // 0: --devices was not given
};

// Reads the list of --devices, or lists all devices for "all". VW_ERROR_USAGE when it is not a list, or when --device
// is given too.
enum vw_status vw_device_list_read(const struct vw_options *options, struct vw_device_list *list);
// Returns the devices of the list, or that of --device without a list. The choice borrows from both.
struct vw_device_choice vw_device_list_choose(const struct vw_options *options, const struct vw_device_list *list);

#endif

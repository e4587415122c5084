// The choice of Vulkan extensions: those that viewworth uses are enabled if they are offered.
#ifndef VIEWWORTH_GPU_EXTENSIONS_H
#define VIEWWORTH_GPU_EXTENSIONS_H

#include <stdbool.h>
#include <stdint.h>
#include <volk.h>

enum { VW_EXTENSIONS_MAX = 4 };

// The extensions for a VkInstanceCreateInfo or VkDeviceCreateInfo. `names` are static texts.
struct vw_extension_choice {
    const char *names[VW_EXTENSIONS_MAX];
    uint32_t count;
    VkInstanceCreateFlags instance_flags;
    bool debug_utils; // object names and labels can be set
    bool statistics;  // the driver tells what it made of a pipeline
};

bool vw_extension_is_offered(const VkExtensionProperties *offered, uint32_t offered_count, const char *name);

// Chooses those of an instance. `offered`: by the loader; `validation`: with those that the validation layer needs.
// Drivers on top of another interface, such as MoltenVK, are listed only for a program that enables portability
// enumeration.
struct vw_extension_choice vw_extensions_of_instance(const VkExtensionProperties *offered, uint32_t offered_count,
                                                     bool validation);

// Chooses those of a device. If portability subset is offered, the specification demands that it is enabled.
struct vw_extension_choice vw_extensions_of_device(const VkExtensionProperties *offered, uint32_t offered_count,
                                                   bool statistics);

#endif

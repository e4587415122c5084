#include "gpu/extensions.h"

#include <assert.h>
#include <string.h>

static const char portability_subset[] = "VK_KHR_portability_subset"; // declared in a header for beta extensions alone

bool vw_extension_is_offered(const VkExtensionProperties *offered, uint32_t offered_count, const char *name) {
    for (uint32_t i = 0; i < offered_count; i++)
        if (!strcmp(offered[i].extensionName, name)) return true;
    return false;
}

static void add(struct vw_extension_choice *choice, const char *name) {
    assert(choice->count < VW_EXTENSIONS_MAX);
    choice->names[choice->count++] = name;
}

struct vw_extension_choice vw_extensions_of_instance(const VkExtensionProperties *offered, uint32_t offered_count,
                                                     bool validation) {
    struct vw_extension_choice choice = {0};
    choice.debug_utils =
        validation || vw_extension_is_offered(offered, offered_count, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (choice.debug_utils) add(&choice, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (validation) add(&choice, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    if (vw_extension_is_offered(offered, offered_count, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        add(&choice, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
        choice.instance_flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
    }
    return choice;
}

struct vw_extension_choice vw_extensions_of_device(const VkExtensionProperties *offered, uint32_t offered_count,
                                                   bool statistics) {
    struct vw_extension_choice choice = {0};
    if (vw_extension_is_offered(offered, offered_count, portability_subset)) add(&choice, portability_subset);
    choice.statistics = statistics && vw_extension_is_offered(offered, offered_count,
                                                              VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    if (choice.statistics) add(&choice, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    return choice;
}

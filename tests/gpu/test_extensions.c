// Choice of the extensions to enable, from lists as loaders and drivers of other systems offer them.
#include "support/cmocka_test.h"

#include "gpu/instance.h"
#include "gpu/limits.h"

static const VkExtensionProperties of_linux[] = {{VK_EXT_DEBUG_UTILS_EXTENSION_NAME, 2}, {"VK_KHR_surface", 25}},
                                   of_apple[] = {{"VK_KHR_surface", 25},
                                                 {VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME, 1}},
                                   of_moltenvk[] = {{"VK_KHR_maintenance1", 2}, {"VK_KHR_portability_subset", 1}};

static bool has(const struct vw_extension_choice *choice, const char *name) {
    for (uint32_t i = 0; i < choice->count; i++)
        if (!strcmp(choice->names[i], name)) return true;
    return false;
}

TEST(what_is_not_offered_is_not_enabled) {
    assert_int_equal(vw_extensions_of_instance(NULL, 0, false).count, 0);
    assert_int_equal(vw_extensions_of_device(NULL, 0).count, 0);
    const struct vw_extension_choice choice = vw_extensions_of_instance(of_linux, 2, false);
    assert_int_equal(choice.count, 1);
    assert_true(choice.debug_utils && has(&choice, VK_EXT_DEBUG_UTILS_EXTENSION_NAME));
    assert_int_equal(choice.instance_flags, 0);
    assert_int_equal(vw_extensions_of_device(of_linux, 2).count, 0);
}

TEST(portability_is_enabled_with_its_flag) {
    for (int validation = 0; validation < 2; validation++) {
        const struct vw_extension_choice choice = vw_extensions_of_instance(of_apple, 2, validation);
        assert_true(has(&choice, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME));
        assert_int_equal(choice.instance_flags, VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR);
        assert_int_equal(choice.debug_utils, validation); // which the layer offers
        assert_int_equal(has(&choice, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME), validation);
    }
    const struct vw_extension_choice device = vw_extensions_of_device(of_moltenvk, 2);
    assert_int_equal(device.count, 1);
    assert_string_equal(device.names[0], "VK_KHR_portability_subset");
}

TEST(moltenvk_that_sizes_arrays_wrongly_is_refused) {
    assert_non_null(strstr(vw_driver_missed(VK_DRIVER_ID_MOLTENVK, 10211), "1.3.0"));
    assert_null(vw_driver_missed(VK_DRIVER_ID_MOLTENVK, 10300));
    assert_null(vw_driver_missed(VK_DRIVER_ID_MOLTENVK, 10400));
    assert_null(vw_driver_missed(VK_DRIVER_ID_MESA_LLVMPIPE, 1)); // versions of others count otherwise
}

// The cache of compiled shaders: by device, driver and vector width, never trusted when damaged.
#include "support/cmocka_test.h"

#include <dirent.h>

#include "base/file.h"
#include "support/temporary_folder.h"
#include "viewworth/gpu.h"

static void open_and_close(void) {
    struct vw_gpu *gpu = NULL;
    if (vw_gpu_open(&(struct vw_gpu_params){.validation = true}, &gpu) || vw_gpu_close(&gpu))
        fail_msg("%s", vw_error_message());
}

// Counts the pipeline caches in the folder and stores the name of the last one.
static int list_caches(const char *folder, char name[256]) {
    int count = 0;
    DIR *stream = opendir(folder);
    for (struct dirent *entry; stream && (entry = readdir(stream));)
        if (!strncmp(entry->d_name, "pipelines-", 10)) count++, snprintf(name, 256, "%s", entry->d_name);
    if (stream) closedir(stream);
    return count;
}

FOLDER_TEST(a_damaged_cache_is_made_anew) {
    char name[256] = "";
    setenv("XDG_CACHE_HOME", *state, 1);
    const char *caches = temporary_path(*state, "viewworth");
    open_and_close();
    assert_int_equal(list_caches(caches, name), 1);
    const struct kept_file whole = temporary_keep(temporary_path(caches, name));
    AUTO_FREE uint8_t *flipped = temporary_read(whole.path, NULL);
    flipped[40] ^= 1;
    const struct kept_file damaged[] = {{whole.path, whole.bytes, whole.size_bytes - 1}, // cut short
                                        {whole.path, flipped, whole.size_bytes},
                                        {whole.path, "", 0}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(damaged); i++) {
        temporary_put_back(&damaged[i]);
        open_and_close();
        size_t size_bytes = 0;
        AUTO_FREE void *again = temporary_read(whole.path, &size_bytes);
        assert_int_equal(size_bytes, whole.size_bytes);
        assert_memory_equal(again, whole.bytes, size_bytes);
    }
}

FOLDER_TEST(every_vector_width_has_its_own) {
    const char *folder = *state;
    char name[256];
    setenv("XDG_CACHE_HOME", folder, 1);
    unsetenv("MESA_SHADER_CACHE_DIR");
    open_and_close();
    assert_null(getenv("MESA_SHADER_CACHE_DIR")); // Mesa's own choice will do
    setenv("LP_NATIVE_VECTOR_WIDTH", "256", 1);
    open_and_close();
    assert_int_equal(list_caches(temporary_path(folder, "viewworth"), name), 2);
    assert_string_equal(getenv("MESA_SHADER_CACHE_DIR"), temporary_path(folder, "viewworth/mesa-256"));
    assert_true(vw_folder_exists(getenv("MESA_SHADER_CACHE_DIR")));
    unsetenv("LP_NATIVE_VECTOR_WIDTH");
    unsetenv("MESA_SHADER_CACHE_DIR");
}

TEST(without_a_folder_nothing_is_kept) {
    setenv("XDG_CACHE_HOME", "/dev/null", 1);
    open_and_close();
    unsetenv("XDG_CACHE_HOME");
    unsetenv("HOME");
    open_and_close();
}

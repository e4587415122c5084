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

TEST(a_damaged_cache_is_made_anew) {
    char *folder = temporary_folder_create(), name[256] = "";
    setenv("XDG_CACHE_HOME", folder, 1);
    const char *caches = temporary_path(folder, "viewworth");
    open_and_close();
    assert_int_equal(list_caches(caches, name), 1);
    char *path = vw_path_join(caches, name);
    void *whole = NULL, *again = NULL;
    size_t whole_bytes = 0, again_bytes = 0;
    assert_int_equal(vw_file_read(path, 1 << 28, &whole, &whole_bytes), VW_OK);
    for (size_t damage = 0; damage < 3; damage++) { // cut short, a bit flipped, empty
        ((uint8_t *)whole)[40] ^= damage == 1;
        assert_int_equal(vw_file_write(path, whole,
                                       damage == 0   ? whole_bytes - 1
                                       : damage == 1 ? whole_bytes
                                                     : 0),
                         VW_OK);
        ((uint8_t *)whole)[40] ^= damage == 1;
        open_and_close();
        assert_int_equal(vw_file_read(path, 1 << 28, &again, &again_bytes), VW_OK);
        assert_int_equal(again_bytes, whole_bytes);
        assert_memory_equal(again, whole, whole_bytes);
        free(again);
    }
    free(whole);
    free(path);
    temporary_folder_remove(folder);
}

TEST(every_vector_width_has_its_own) {
    char *folder = temporary_folder_create(), name[256];
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
    temporary_folder_remove(folder);
}

TEST(without_a_folder_nothing_is_kept) {
    setenv("XDG_CACHE_HOME", "/dev/null", 1);
    open_and_close();
    unsetenv("XDG_CACHE_HOME");
    unsetenv("HOME");
    open_and_close();
}

// The shim is a module of its own, opened with the first photo: OpenImageIO brings some 250 libraries, which take
// longer to load than most commands and tests, which read no photo, take in all.
#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "image/oiio_shim.h"
#include "base/file.h"

static struct {
    __typeof__(vw_oiio_probe) *probe;
    __typeof__(vw_oiio_read) *read;
    __typeof__(vw_oiio_resize) *resize;
    __typeof__(vw_oiio_encode) *encode;
    struct vw_oiio_result missing; // what calls return where the module cannot be opened
} module;

// Beside the program, whatever it is called.
static char *name_module(void) {
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length < 0) return NULL;
    program[length] = 0;
    char *folder = vw_path_folder(program);
    char *path = folder ? vw_path_join(folder, "viewworth_oiio.so") : NULL;
    free(folder);
    return path;
}

// It is never closed.
static void open_module(void) {
    char *path = name_module();
    void *opened = path ? dlopen(path, RTLD_LAZY | RTLD_LOCAL) : NULL;
    free(path);
    module.missing.status = VW_ERROR_IO;
    if (opened) {
        module.probe = dlsym(opened, "vw_oiio_probe");
        module.read = dlsym(opened, "vw_oiio_read");
        module.resize = dlsym(opened, "vw_oiio_resize");
        module.encode = dlsym(opened, "vw_oiio_encode");
    }
    if (module.probe && module.read && module.resize && module.encode) return;
    const char *why = dlerror();
    snprintf(module.missing.message, sizeof module.missing.message,
             "viewworth_oiio.so, which belongs beside the program: %s", why ? why : "cannot be found");
    module.probe = NULL;
}

static bool is_open(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    return !pthread_once(&once, open_module) && module.probe;
}

struct vw_oiio_result vw_oiio_probe(const char *path) {
    return is_open() ? module.probe(path) : module.missing;
}

struct vw_oiio_result vw_oiio_read(const char *path) {
    return is_open() ? module.read(path) : module.missing;
}

struct vw_oiio_result vw_oiio_resize(const float *rgba, uint32_t width_px, uint32_t height_px, uint32_t new_width_px,
                                     uint32_t new_height_px) {
    return is_open() ? module.resize(rgba, width_px, height_px, new_width_px, new_height_px) : module.missing;
}

struct vw_oiio_result vw_oiio_encode(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                                     bool eight_bit, const char *compression, const float *pixels) {
    return is_open() ? module.encode(path, width_px, height_px, channels, eight_bit, compression, pixels)
                     : module.missing;
}

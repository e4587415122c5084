// The shim is a module of its own, opened with the first photo: OpenImageIO brings some 250 libraries, which take
// longer to load than most commands and tests, which read no photo, take in all.
#include <dlfcn.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "image/oiio_shim.h"
#include "base/file.h"
#include "base/memory.h"

#define MODULE_NAME "viewworth_oiio.so"

static struct {
    __typeof__(vw_oiio_probe) *probe;
    __typeof__(vw_oiio_read) *read;
    __typeof__(vw_oiio_resize) *resize;
    __typeof__(vw_oiio_encode) *encode;
    struct vw_oiio_result missing; // what calls return where the module cannot be opened
} module;

// Where the module lies, seen from the folder of this code: in a build beside it; installed in a folder beside
// libviewworth.so, to which the program has a longer way.
static const char *const module_folders[] = {".", "viewworth", VW_MODULE_FOLDER_FROM_PROGRAM};

// The folder of the library that holds this code, or of the program when it is linked into that; owned by the caller.
static char *find_own_folder(void) {
    Dl_info info;
    struct link_map *map = NULL;
    if (dladdr1(&module, &info, (void **)&map, RTLD_DL_LINKMAP) && map && map->l_name[0])
        return vw_path_folder(map->l_name);
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length < 0) return NULL;
    program[length] = 0;
    return vw_path_folder(program);
}

// The first module that is there, owned by the caller; NULL where none is.
static char *find_module(void) {
    char *own_folder = find_own_folder(), *found = NULL;
    for (size_t i = 0; own_folder && i < VW_ARRAY_COUNT(module_folders) && !found; i++) {
        char *folder = vw_path_join(own_folder, module_folders[i]);
        char *path = folder ? vw_path_join(folder, MODULE_NAME) : NULL;
        free(folder);
        if (path && vw_file_exists(path)) found = path;
        else free(path);
    }
    free(own_folder);
    return found;
}

// It is never closed.
static void open_module(void) {
    char *path = find_module();
    void *opened = path ? dlopen(path, RTLD_LAZY | RTLD_LOCAL) : NULL;
    const char *why =
        path && !opened ? dlerror() : "it is neither beside the program nor in " VW_MODULE_FOLDER_FROM_PROGRAM;
    module.missing.status = VW_ERROR_IO;
    if (opened) {
        module.probe = dlsym(opened, "vw_oiio_probe");
        module.read = dlsym(opened, "vw_oiio_read");
        module.resize = dlsym(opened, "vw_oiio_resize");
        module.encode = dlsym(opened, "vw_oiio_encode");
        why = "it belongs to another version";
    }
    free(path);
    if (module.probe && module.read && module.resize && module.encode) return;
    snprintf(module.missing.message, sizeof module.missing.message,
             "cannot load " MODULE_NAME ", which reads and writes photos: %s; install viewworth again", why);
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

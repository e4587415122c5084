#include "scene/safe_path.h"

#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"

enum vw_status vw_scene_file_open(const char *folder, const char *path, int *descriptor) {
    if (!folder) return vw_file_open(path, descriptor);
    size_t length = strlen(folder);
    if (strncmp(path, folder, length) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: is not in the scene folder %s; copy it there", path, folder);
    const char *name = path + length;
    return vw_file_open_inside(folder, name + strspn(name, "/"), descriptor);
}

enum vw_status vw_scene_file_read(const char *folder, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (status) return status;
    status = vw_descriptor_read(descriptor, path, limit_bytes, data, size_bytes);
    close(descriptor);
    return status;
}

enum vw_status vw_scene_file_check(const char *folder, const char *path) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (!status) close(descriptor);
    return status;
}

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/cache.h"
#include "base/file.h"
#include "base/memory.h"
#include "scene/photo_source.h"
#include "viewworth/log.h"
#include "viewworth/scene.h"

static const uint64_t LEFT_BYTES = UINT64_C(64) << 20; // left on the disk: ledger and results may be on the same one
static _Atomic uint64_t allowed_bytes;                 // 0: the default

void vw_scene_set_memory(uint64_t size_bytes) { atomic_store(&allowed_bytes, size_bytes); }

static uint64_t memory_bytes(void) {
    uint64_t machine_bytes = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    uint64_t bytes = atomic_load(&allowed_bytes);
    if (!bytes) return machine_bytes / 2;
    return bytes < machine_bytes ? bytes : machine_bytes;
}

// Chooses the cache folder or, if it cannot be written to, that of temporary files; owned by the caller.
static char *choose_folder(void) {
    const char *temporary = getenv("TMPDIR");
    char *folder = vw_cache_folder("");
    if (folder && !access(folder, W_OK | X_OK)) return folder;
    free(folder);
    return vw_copy_text(temporary && *temporary == '/' ? temporary : "/tmp");
}

// Asks first: to reserve what is not there would fill the disk until it fails, and with it everybody else's writes.
static int reserve(int descriptor, uint64_t size_bytes) {
    struct statvfs disk;
    int error;
    if (!fstatvfs(descriptor, &disk) && disk.f_bavail < (size_bytes + LEFT_BYTES) / disk.f_frsize) return ENOSPC;
    do error = posix_fallocate(descriptor, 0, (off_t)size_bytes);
    while (error == EINTR);
    return error;
}

static enum vw_status map_file(const char *folder, struct vw_pixel_store *store) {
    int descriptor = vw_file_open_unnamed(folder),
        error = descriptor < 0 ? errno : reserve(descriptor, store->size_bytes);
    void *mapped = MAP_FAILED;
    if (!error) {
        mapped = mmap(NULL, store->size_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        if (mapped == MAP_FAILED) error = errno;
    }
    if (descriptor >= 0) close(descriptor); // the mapping keeps the file
    if (error)
        return vw_fail(VW_ERROR_IO,
                       "%s: cannot reserve %.3g GiB for pixels: %s; free some there, name a folder on another "
                       "disk by XDG_CACHE_HOME, or give --memory or --downscale",
                       folder, ldexp((double)store->size_bytes, -30), strerror(error));
    store->bytes = mapped;
    vw_log_info("pixels: %.3g GiB, more than --memory allows: in a file of %s", ldexp((double)store->size_bytes, -30),
                folder);
    return VW_OK;
}

enum vw_status vw_pixel_store_open(uint64_t size_bytes, struct vw_pixel_store *store) {
    *store = (struct vw_pixel_store){.size_bytes = size_bytes};
    if (size_bytes <= memory_bytes()) return VW_OK;
    char *folder = choose_folder();
    enum vw_status status = folder ? map_file(folder, store) : VW_ERROR_MEMORY;
    free(folder);
    return status;
}

void vw_pixel_store_close(struct vw_pixel_store *store) {
    if (store->bytes) munmap(store->bytes, store->size_bytes);
    *store = (struct vw_pixel_store){0};
}

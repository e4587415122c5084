#include "scene/photo_source.h"

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
#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "image/decoder.h"
#include "image/image.h"
#include "scene/builder.h"
#include "viewworth/log.h"
#include "viewworth/scene.h"

// ---- The store of pixels -------------------------------------------------------------------------------------------

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

// ---- Life -----------------------------------------------------------------------------------------------------------

static const uint64_t TOTAL_LIMIT_BYTES = UINT64_C(1) << 40; // for all pixels of a scene
static const uint64_t AHEAD_LIMIT_BYTES = UINT64_C(1) << 30; // for photos that are decoded before it is their turn
static const uint64_t ALIGNMENT_BYTES = 64;

// Places the pixels of all views, one after another.
static enum vw_status place_pixels(const struct vw_scene *scene, const struct vw_photo_source *source,
                                   uint64_t *total_bytes) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_scene_builder_photo *photo = &source->photos[v];
        source->places[v] = *total_bytes;
        if (scene->views[v].split == VW_SPLIT_EXCLUDED) continue;
        uint64_t bytes = vw_image_loaded_bytes(&photo->image_header, source->downscale);
        *total_bytes += (bytes + ALIGNMENT_BYTES - 1) / ALIGNMENT_BYTES * ALIGNMENT_BYTES;
        if (*total_bytes > TOTAL_LIMIT_BYTES)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: with this one, the pixels of all photos are more than the limit of %.0f GiB; use "
                           "--downscale, or fewer photos",
                           photo->image_path, ldexp((double)TOTAL_LIMIT_BYTES, -30));
    }
    return VW_OK;
}

enum vw_status vw_photo_source_create(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    struct vw_photo_source *source = vw_allocate(1, sizeof *source);
    uint64_t total_bytes = 0;
    if (!source) return VW_ERROR_MEMORY;
    scene->source = source;
    *source = (struct vw_photo_source){.folder = builder->folder,
                                       .photos = builder->photos,
                                       .view_count = scene->view_count,
                                       .downscale = builder->params->downscale,
                                       .headers_only = builder->params->headers_only,
                                       .places = vw_allocate(scene->view_count, sizeof *source->places),
                                       .lock = PTHREAD_MUTEX_INITIALIZER,
                                       .asked = vw_allocate(scene->view_count, sizeof *source->asked)};
    builder->folder = NULL;
    builder->photos = NULL;
    builder->photo_capacity = 0;
    if (!source->places || !source->asked) return VW_ERROR_MEMORY;
    enum vw_status status = place_pixels(scene, source, &total_bytes);
    return status || builder->params->headers_only ? status : vw_pixel_store_open(total_bytes, &source->store);
}

void vw_builder_photos_free(struct vw_scene_builder_photo *photos, size_t count) {
    for (size_t i = 0; i < count; i++) {
        free(photos[i].image_path);
        free(photos[i].mask_path);
        free(photos[i].mask_folder);
        free(photos[i].features_path);
    }
    free(photos);
}

void vw_photo_source_destroy(struct vw_photo_source **source) {
    struct vw_photo_source *dying = *source;
    if (!dying) return;
    vw_builder_photos_free(dying->photos, dying->view_count);
    vw_pixel_store_close(&dying->store);
    free(dying->folder);
    free(dying->places);
    free(dying->asked);
    free(dying);
    *source = NULL;
}

uint64_t vw_view_image_bytes(const struct vw_scene *scene, uint32_t view) {
    const struct vw_image *image = &scene->views[view].image;
    if (image->pixels) return 4 * (uint64_t)image->width_px * image->height_px * vw_pixel_channel_bytes(image->format);
    const struct vw_photo_source *source = scene->source;
    return vw_image_loaded_bytes(&source->photos[view].image_header, source->downscale);
}

void vw_view_file_size(const struct vw_scene *scene, uint32_t view, uint32_t size_px[2]) {
    const struct vw_camera *camera = &scene->views[view].camera;
    const struct vw_image_header *header = scene->source ? &scene->source->photos[view].image_header : NULL;
    size_px[0] = header ? header->width_px : camera->width_px;
    size_px[1] = header ? header->height_px : camera->height_px;
}

uint32_t vw_view_orientation(const struct vw_scene *scene, uint32_t view) {
    return scene->source ? scene->source->photos[view].image_header.orientation : 0;
}

// ---- Reading files --------------------------------------------------------------------------------------------------

// Returns whether a photo can be decoded when it is first needed: no decision at opening depends on its pixels.
static bool can_wait(const struct vw_scene_builder_photo *photo) {
    const struct vw_image_header *header = &photo->image_header;
    return header->format != VW_PIXEL_FLOAT32 && (header->channels == 1 || header->channels == 3);
}

static bool is_decoded(const struct vw_photo_reading *reading, uint32_t place) {
    uint32_t view = reading->views[place];
    if (reading->scene->views[view].split == VW_SPLIT_EXCLUDED) return false;
    return !reading->opening || !can_wait(&reading->scene->source->photos[view]);
}

static uint64_t ahead_bytes(const struct vw_photo_reading *reading, uint32_t place) {
    const struct vw_image_header *header = &reading->scene->source->photos[reading->views[place]].image_header;
    return is_decoded(reading, place)
               ? (uint64_t)header->width_px * header->height_px * header->channels * sizeof(float)
               : 0;
}

enum vw_status vw_photo_reading_begin(const struct vw_scene *scene, const uint32_t *views, uint32_t count, bool opening,
                                      struct vw_photo_reading *reading) {
    *reading = (struct vw_photo_reading){.scene = scene,
                                         .views = views,
                                         .count = count,
                                         .opening = opening,
                                         .loads = vw_allocate(count, sizeof *reading->loads),
                                         .told_s = vw_now_s()};
    return reading->loads ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status begin_load(const char *folder, const char *path, const struct vw_image_header *header,
                                 uint32_t downscale, struct vw_image_load **load) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    return status ? status : vw_image_load_begin(path, descriptor, header, downscale, load);
}

static enum vw_status begin_view(struct vw_photo_reading *reading, uint32_t place) {
    const struct vw_photo_source *source = reading->scene->source;
    const struct vw_scene_builder_photo *photo = &source->photos[reading->views[place]];
    struct vw_photo_loads *loads = &reading->loads[place];
    bool excluded = reading->scene->views[reading->views[place]].split == VW_SPLIT_EXCLUDED;
    enum vw_status status = VW_OK;
    if (is_decoded(reading, place))
        status = begin_load(source->folder, photo->image_path, &photo->image_header, source->downscale, &loads->image);
    if (!status && reading->opening && !excluded && photo->mask_path)
        status = begin_load(photo->mask_folder ? photo->mask_folder : source->folder, photo->mask_path,
                            &photo->mask_header, 1, &loads->mask);
    if (status) {
        vw_image_load_cancel(&loads->image);
        return status;
    }
    reading->begun = place + 1;
    reading->ahead_bytes += ahead_bytes(reading, place);
    return VW_OK;
}

static void tell_progress(struct vw_photo_reading *reading, uint32_t place) {
    if (!vw_progress_is_due(&reading->told_s)) return;
    if (reading->opening) vw_log_info("photos: %u of %u read", place, reading->count);
    else
        vw_log_info("photos: %u of %u decoded", reading->scene->source->decoded_count,
                    reading->scene->view_count - reading->scene->split_count[VW_SPLIT_EXCLUDED]);
}

// Starts decodings ahead. One that fails ahead of its turn fails again at its turn.
enum vw_status vw_photo_reading_advance(struct vw_photo_reading *reading, uint32_t place) {
    uint32_t ahead = vw_decoder_parallel_count() + 1;
    enum vw_status status = reading->begun > place ? VW_OK : begin_view(reading, place);
    while (!status && reading->begun < reading->count && reading->begun < place + ahead &&
           reading->ahead_bytes < AHEAD_LIMIT_BYTES)
        if (begin_view(reading, reading->begun)) break;
    tell_progress(reading, place);
    return status;
}

enum vw_status vw_photo_reading_finish(struct vw_photo_reading *reading, uint32_t place, uint8_t sha256[VW_HASH_BYTES],
                                       struct vw_image *image) {
    uint32_t view = reading->views[place];
    struct vw_photo_source *source = reading->scene->source;
    if (!is_decoded(reading, place)) return vw_scene_file_hash(source->folder, source->photos[view].image_path, sha256);
    void *pixels = source->store.bytes ? source->store.bytes + source->places[view] : NULL;
    enum vw_status status = vw_image_load_finish(&reading->loads[place].image, pixels, sha256, image);
    reading->ahead_bytes -= ahead_bytes(reading, place);
    source->decoded_count += !status;
    return status;
}

void vw_photo_reading_end(struct vw_photo_reading *reading) {
    for (uint32_t i = 0; reading->loads && i < reading->count; i++) {
        vw_image_load_cancel(&reading->loads[i].image);
        vw_image_load_cancel(&reading->loads[i].mask);
    }
    free(reading->loads);
    *reading = (struct vw_photo_reading){0};
}

// ---- Decoding what is needed ----------------------------------------------------------------------------------------

// Checks that the file is the one in the scene's hash, and that the assumptions made at opening are true.
static enum vw_status check_photo(const char *path, const uint8_t *hashed, const uint8_t *sha256, enum vw_status status,
                                  const struct vw_image *image) {
    static const uint8_t unread[VW_HASH_BYTES];
    if (status && !memcmp(sha256, unread, VW_HASH_BYTES)) return status; // it could not be read
    if (memcmp(hashed, sha256, VW_HASH_BYTES) != 0)
        return vw_fail(VW_ERROR_IO, "%s: changed since the scene was opened; restore it, or run the command again",
                       path);
    if (!status && (image->has_alpha || image->clamped_count || image->masked_count))
        return vw_fail(VW_ERROR_INPUT, "%s: has transparent pixels without being grey or RGB with alpha; convert it",
                       path);
    return status;
}

static enum vw_status decode_view(struct vw_photo_reading *reading, uint32_t place) {
    struct vw_view *view = &reading->scene->views[reading->views[place]];
    struct vw_image image = {0};
    uint8_t sha256[VW_HASH_BYTES] = {0};
    const char *path = reading->scene->source->photos[reading->views[place]].image_path;
    enum vw_status status = vw_photo_reading_advance(reading, place);
    if (status) return status;
    status = check_photo(path, view->sha256, sha256, vw_photo_reading_finish(reading, place, sha256, &image), &image);
    if (status) vw_image_clear(&image);
    else view->image = image;
    return status;
}

// Lists them in ascending order, each once; the caller frees the list.
static enum vw_status list_missing(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                   uint32_t **missing, uint32_t *missing_count) {
    bool *asked = scene->source->asked;
    uint32_t asked_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_view *view = &scene->views[views[i]];
        if (view->image.pixels || view->split == VW_SPLIT_EXCLUDED || asked[views[i]]) continue;
        asked[views[i]] = true;
        asked_count++;
    }
    if (!asked_count) return VW_OK;
    *missing = vw_allocate(asked_count, sizeof **missing);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (asked[v] && *missing) (*missing)[(*missing_count)++] = v;
        asked[v] = false;
    }
    return *missing ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status decode(const struct vw_scene *scene, const uint32_t *views, uint32_t count) {
    struct vw_photo_reading reading = {0};
    uint32_t *missing = NULL, missing_count = 0;
    enum vw_status status = list_missing(scene, views, count, &missing, &missing_count);
    if (!status && missing_count) status = vw_photo_reading_begin(scene, missing, missing_count, false, &reading);
    for (uint32_t i = 0; i < missing_count && !status; i++) status = decode_view(&reading, i);
    vw_photo_reading_end(&reading);
    free(missing);
    return status;
}

enum vw_status vw_scene_decode(const struct vw_scene *scene, const uint32_t *views, uint32_t count) {
    struct vw_photo_source *source = scene->source;
    if (!source || source->headers_only) return VW_OK;
    (void)pthread_mutex_lock(&source->lock);
    enum vw_status status = decode(scene, views, count);
    (void)pthread_mutex_unlock(&source->lock);
    return status;
}

enum vw_status vw_scene_decode_all(const struct vw_scene *scene) {
    uint32_t *views = vw_allocate(scene->view_count, sizeof *views);
    if (!views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) views[v] = v;
    enum vw_status status = vw_scene_decode(scene, views, scene->view_count);
    free(views);
    return status;
}

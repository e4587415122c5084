// The photos of an open scene: their files, and the place of their pixels. Internal to src/scene.
#ifndef VIEWWORTH_SCENE_PHOTO_SOURCE_H
#define VIEWWORTH_SCENE_PHOTO_SOURCE_H

#include <pthread.h>
#include <stdint.h>

#include "scene/builder.h"
#include "viewworth/status.h"

// The store of a scene's pixels. If they fit into the memory allowed for them, they are on the heap, photo by photo.
// Otherwise all are in one file in the cache folder, mapped and shared, so that the kernel writes out and drops pages
// that are not in use. The file has no name: nothing of it remains, however the program ends. Its room on the disk is
// reserved before anything is written, so that a full disk is an error then, not a signal later, if the file system
// keeps its reservations.
struct vw_pixel_store {
    unsigned char *bytes; // mapped; NULL: pixels are on the heap
    uint64_t size_bytes;
};

// Makes room for `size_bytes`. VW_ERROR_IO if they neither fit into memory nor on the disk.
enum vw_status vw_pixel_store_open(uint64_t size_bytes, struct vw_pixel_store *store);
void vw_pixel_store_close(struct vw_pixel_store *store); // accepts a zeroed one

struct vw_features; // features.h

struct vw_photo_source {
    char *folder;                          // owned; no file may be outside of it
    struct vw_scene_builder_photo *photos; // owned; of each view
    uint32_t view_count, downscale;
    bool headers_only; // nothing is hashed or decoded
    struct vw_pixel_store store;
    uint64_t *places;             // owned; of each view's pixels in the store, in bytes
    pthread_mutex_t lock;         // guards the fields below, and pixels that are not decoded yet
    bool *asked;                  // owned; of each view: scratch
    uint32_t decoded_count;       // views whose pixels are there
    struct vw_features *features; // owned; NULL until vw_features_open(); then it never changes
};

// Takes the builder's photos and folder over into its scene, and makes room for their pixels.
enum vw_status vw_photo_source_create(struct vw_scene_builder *builder);
void vw_photo_source_destroy(struct vw_photo_source **source); // accepts NULL
void vw_builder_photos_free(struct vw_scene_builder_photo *photos, size_t count);

// Several files are decoded at once, by other processes; they are finished in their order, so that neither the scene
// nor the first error depends on timing.
struct vw_photo_reading {
    const struct vw_scene *scene;
    const uint32_t *views; // in ascending order
    uint32_t count;
    bool opening; // the scene: masks are read, too, but photos that can wait are not decoded
    struct vw_photo_loads {
        struct vw_image_load *image, *mask;
    } * loads;      // owned; per view of the list
    uint32_t begun; // views whose loads have begun
    uint64_t ahead_bytes;
    double told_s; // when progress was last told
};

// Begins to read photos. `views` outlives the reading; the caller ends it, also after a failure.
enum vw_status vw_photo_reading_begin(const struct vw_scene *scene, const uint32_t *views, uint32_t count, bool opening,
                                      struct vw_photo_reading *reading);
// Begins what the view at a place of the list needs, and some after it.
enum vw_status vw_photo_reading_advance(struct vw_photo_reading *reading, uint32_t place);
// Finishes the photo at a place that was begun: the file's hash and, unless it can wait, its image, whose pixels are at
// their place. A view that has pixels after that is counted.
enum vw_status vw_photo_reading_finish(struct vw_photo_reading *reading, uint32_t place, uint8_t sha256[VW_HASH_BYTES],
                                       struct vw_image *image);
void vw_photo_reading_end(struct vw_photo_reading *reading);

#endif

// The store of a scene's pixels. If they fit into the memory allowed for them, they are on the heap, photo by photo.
// Otherwise all are in one file in the cache folder, mapped and shared, so that the kernel writes out and drops pages
// that are not in use. The file has no name: nothing of it remains, however the program ends. Its room on the disk is
// reserved before anything is written, so that a full disk is an error then, not a signal later, if the file system
// keeps its reservations.
#ifndef VIEWWORTH_SCENE_PIXEL_STORE_H
#define VIEWWORTH_SCENE_PIXEL_STORE_H

#include <stdint.h>

#include "viewworth/status.h"

struct vw_pixel_store {
    unsigned char *bytes; // mapped; NULL: pixels are on the heap
    uint64_t size_bytes;
};

// Makes room for `size_bytes`. VW_ERROR_IO if they neither fit into memory nor on the disk.
enum vw_status vw_pixel_store_open(uint64_t size_bytes, struct vw_pixel_store *store);
void vw_pixel_store_close(struct vw_pixel_store *store); // accepts a zeroed one

#endif

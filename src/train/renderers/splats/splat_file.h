// Splats as the .ply file that other programs read and write (Kerbl et al.): little-endian floats x y z, nx ny nz,
// f_dc_*, f_rest_* (channel by channel), opacity (logit), scale_* (logarithms) and rot_* (quaternion w, x, y, z), in
// world coordinates.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLAT_FILE_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLAT_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

struct vw_splat_file {
    uint32_t count, degree;
    bool antialiased; // it says so; such splats fade where the low pass widens them
    float *params;    // owned; columns as in shaders/interface.h, in world units
    char sha256[VW_HASH_HEX_BYTES];
};

// Reads a stranger's file of at most `splats_most` splats. VW_ERROR_INPUT names the file, its line or splat and the
// property, and what to do. Free it also after a failure.
enum vw_status vw_splat_file_read(const char *path, uint32_t splats_most, struct vw_splat_file *file);
void vw_splat_file_free(struct vw_splat_file *file);

// Makes the bytes of a file of params in box coordinates, whose scales hold the filters. Its harmonics are of degree
// `least` if that is more than `degree`, with zeros. `*data` is owned by the caller.
enum vw_status vw_splat_file_make(const float *params, uint32_t count, uint32_t degree, uint32_t least,
                                  const struct vw_box *box, void **data, size_t *size_bytes);
// Turns params of a file, of a degree that is at most `degree`, into params in box coordinates, which are 0.
// VW_ERROR_INPUT when a splat lies beyond floats there; `path` is for messages.
enum vw_status vw_splat_file_place(const struct vw_splat_file *file, const char *path, uint32_t degree,
                                   const struct vw_box *box, float *params);

// Makes a config begin at the splats of a file: notes its full path and its hash, and sets config->splats.
// VW_ERROR_USAGE when the config cannot hold them; errors as of vw_splat_file_read().
enum vw_status vw_splats_begin_from(const char *path, struct vw_config *config);
// Reads the file that a config begins from. VW_ERROR_INPUT also when it is another one by now.
enum vw_status vw_splats_read_initial(const char *path, const char *sha256, struct vw_splat_file *file);

#endif

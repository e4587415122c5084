// Photos in host memory. Files are read and written in other processes, without rights: see image/decoder.h. The
// formats are those of image/photo_formats.h.
#ifndef VIEWWORTH_IMAGE_IMAGE_H
#define VIEWWORTH_IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image/pixel.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// The descriptor of a file that is not open yet: `path` is opened. Otherwise the call takes over an open plain file,
// and closes it in any case; `path` is for messages.
enum { VW_IMAGE_OF_PATH = -1 };

// Reads the header only. VW_ERROR_INPUT for a file of another format and for more than 2^28 pixels or 64 channels.
enum vw_status vw_image_probe(const char *path, int descriptor, struct vw_image_header *header);

// Reads an image of 8 or 16 bit integers or of floats, with unassociated alpha; ignores EXIF orientation. `downscale` >
// 1 filters it (premultiplied) down to floor(size / downscale) pixels, at least 1, as UINT16 (FLOAT32 for float input).
// Float values are clamped to [0,1] and counted. VW_ERROR_INPUT as vw_image_probe() and for more than 5 % masked
// pixels; VW_ERROR_IO if the pixels cannot be decoded, or the file changes meanwhile.
enum vw_status vw_image_load(const char *path, uint32_t downscale, struct vw_image *image);
// Returns the header that the pixels will have after that, and their bytes.
struct vw_image_header vw_image_loaded_header(const struct vw_image_header *header, uint32_t downscale);
uint64_t vw_image_loaded_bytes(const struct vw_image_header *header, uint32_t downscale);

// The same in two parts, so that several are decoded at once. A file whose header is no longer `header` is refused. The
// path must live until the end. `sha256` is that of the file, also when it cannot be decoded; NULL: not wanted.
// `pixels` has room for vw_image_loaded_bytes(), and is lent to the image; NULL: the image owns its pixels. Finishing
// frees the load in any case; to cancel accepts NULL.
struct vw_image_load;
enum vw_status vw_image_load_begin(const char *path, int descriptor, const struct vw_image_header *header,
                                   uint32_t downscale, struct vw_image_load **load);
enum vw_status vw_image_load_finish(struct vw_image_load **load, void *pixels, uint8_t *sha256, struct vw_image *image);
void vw_image_load_cancel(struct vw_image_load **load);

// Writes 3- or 4-channel float pixels in [0,1]; the extension of `path` decides the format (PNG: 8 bit, EXR: half or
// float). Writes a temporary file and renames it, so that no incomplete file remains.
enum vw_status vw_image_save(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                             const float *pixels);
// Makes the bytes of an image file, owned by the caller (free).
struct vw_image_encoding {
    uint32_t format; // index in vw_photo_formats
    uint32_t width_px, height_px, channels;
    bool eight_bit;          // 8 bit with straight alpha, otherwise float with premultiplied alpha
    const char *compression; // OpenImageIO's, for example "webp:70"; NULL: the format's default
};
enum vw_status vw_image_encode(const struct vw_image_encoding *encoding, const float *pixels, void **data,
                               size_t *size_bytes);
// Makes a WebP file of RGB pixels with 8 bit. `compression`: OpenImageIO's compression, for example "webp:70".
enum vw_status vw_image_encode_webp(uint32_t width_px, uint32_t height_px, const char *compression, const float *pixels,
                                    void **data, size_t *size_bytes);
// Makes a thumbnail as the bytes of a WebP file: at most `height_px` high and four times as wide; transparent pixels
// are over `background`. `*data` is owned by the caller (free). VW_ERROR_MEMORY, VW_ERROR_IO.
enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3],
                                       void **data, size_t *size_bytes);
void vw_image_clear(struct vw_image *image); // frees the pixels and zeroes the struct

// Reads one pixel as straight-alpha RGBA in [0,1]. x_px < width_px and y_px < height_px.
void vw_image_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, float rgba[4]);
// Returns the luminance of a colour as stored (weights of Rec. 709).
double vw_luminance_of(const float rgb[3]);
// Returns that of a pixel; transparent pixels are over `background` (RGB). Same limits.
double vw_image_luminance(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float background[3]);

// ---- Luminance ----

// Measures of a photo's luminance as stored.
struct vw_luminance {
    double brightness; // mean, [0,1]
    double contrast;   // standard deviation
    double sharpness;  // variance of the Laplacian (Pech-Pacheco et al., ICPR 2000): low in blurred photos, high in
                       // noisy ones; 0 below 3 pixels of width or height
    double noise;      // standard deviation of the noise (Immerkaer, CVIU 1996); 0 as above
};
// Measures a photo; transparent pixels are over `background` (RGB). VW_ERROR_MEMORY.
enum vw_status vw_image_measure_luminance(const struct vw_image *image, const float background[3],
                                          struct vw_luminance *luminance);

// ---- SSIM (ssim.c) ----

// The structural similarity index (SSIM) of two images: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment:
// from error visibility to structural similarity", IEEE Transactions on Image Processing 13 (4), 2004. As published:
// windows of 11 x 11 pixels with Gaussian weights of standard deviation 1.5 px, K1 = 0.01, K2 = 0.03, and L = 1, the
// range of the values. In each window
//     ssim = (2 mean_a mean_b + C1) (2 covariance + C2) / ((mean_a^2 + mean_b^2 + C1) (variance_a + variance_b + C2)),
// with C1 = (K1 L)^2, C2 = (K2 L)^2 and weighted means as moments (not sample moments). Only windows that are
// completely inside the image count, so that no padding is needed. The result is the mean over the channels, as is
// usual in papers on radiance fields.
enum { VW_SSIM_WINDOW_PX = 11 };

// Computes the mean over all windows of two RGB images (rows top to bottom; values should be in [0,1]), in double.
// `usable`: a byte per pixel, 0 for pixels to ignore; NULL: use all. A window counts if all its pixels are usable. NaN
// if no window counts, for example in images smaller than a window. VW_ERROR_MEMORY.
enum vw_status vw_ssim(const float *a, const float *b, const uint8_t *usable, uint32_t width_px, uint32_t height_px,
                       double *ssim);

// ---- Pictures as texts ---------------------------------------------------------------------------------------------

// Texts are base64, as JSON files for pages have them.
enum { VW_WEBP_TEXT_LIMIT_BYTES = 1 << 18 };

// Makes the text of a WebP file, owned by the caller. NULL: memory is short.
char *vw_webp_to_text(const void *data, size_t size_bytes);

#endif

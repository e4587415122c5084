// The structural similarity index (SSIM) of two images: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment:
// from error visibility to structural similarity", IEEE Transactions on Image Processing 13 (4), 2004. As published:
// windows of 11 x 11 pixels with Gaussian weights of standard deviation 1.5 px, K1 = 0.01, K2 = 0.03, and L = 1, the
// range of the values. In each window
//     ssim = (2 mean_a mean_b + C1) (2 covariance + C2) / ((mean_a^2 + mean_b^2 + C1) (variance_a + variance_b + C2)),
// with C1 = (K1 L)^2, C2 = (K2 L)^2 and weighted means as moments (not sample moments). Only windows that are
// completely inside the image count, so that no padding is needed. The result is the mean over the channels, as is
// usual in papers on radiance fields.
#ifndef VIEWWORTH_IMAGE_SSIM_H
#define VIEWWORTH_IMAGE_SSIM_H

#include <stdint.h>

#include "viewworth/status.h"

enum { VW_SSIM_WINDOW_PX = 11 };

// Computes the mean over all windows of two RGB images (rows top to bottom; values should be in [0,1]), in double.
// `usable`: a byte per pixel, 0 for pixels to ignore; NULL: use all. A window counts if all its pixels are usable. NaN
// if no window counts, for example in images smaller than a window. VW_ERROR_MEMORY.
enum vw_status vw_ssim(const float *a, const float *b, const uint8_t *usable, uint32_t width_px, uint32_t height_px,
                       double *ssim);

#endif

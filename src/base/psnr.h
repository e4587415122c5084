// PSNR (decision 5): pixel values in [0,1], L = 1, and a floor of the MSE that keeps a perfect match finite.
#ifndef VIEWWORTH_BASE_PSNR_H
#define VIEWWORTH_BASE_PSNR_H

#define VW_MSE_FLOOR 1e-10 // 100 dB

// Returns -10 log10(max(mse, VW_MSE_FLOOR)) in dB; NaN stays NaN.
double vw_psnr_db(double mse);

#endif

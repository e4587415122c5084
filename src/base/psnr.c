#include "base/psnr.h"

#include <math.h>

double vw_psnr_db(double mse) { return -10.0 * log10(mse < VW_MSE_FLOOR ? VW_MSE_FLOOR : mse); }

// Guard bands around every buffer of the programs in tests/kernels, tests/gradients, tests/hard_cases and tests/train;
// see guard_bands.c.
#ifndef VIEWWORTH_TESTS_SUPPORT_GUARD_BANDS_H
#define VIEWWORTH_TESTS_SUPPORT_GUARD_BANDS_H

// Returns how many bands of buffers, alive or destroyed, were written to since the last call; each has a message on
// stderr. vw_gpu_close() fails for bands that nobody asked about. Do not call it while the device works.
unsigned guard_bands_broken(void);

#endif

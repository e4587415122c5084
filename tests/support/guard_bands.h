// Guard bands around every buffer of the programs in tests/kernels, tests/gradients, tests/hard_cases and tests/train;
// see guard_bands.c.
#ifndef VIEWWORTH_TESTS_SUPPORT_GUARD_BANDS_H
#define VIEWWORTH_TESTS_SUPPORT_GUARD_BANDS_H

// How many bands were written to, of buffers alive and destroyed, since the last call; each has a message on stderr.
// What nobody asked for makes vw_gpu_close() fail. Not while the device works.
unsigned guard_bands_broken(void);

#endif

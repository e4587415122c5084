// One device with validation, shared by the tests of a program.
#ifndef VIEWWORTH_TESTS_SUPPORT_GPU_FIXTURE_H
#define VIEWWORTH_TESTS_SUPPORT_GPU_FIXTURE_H

#include "gpu/compute.h"
#include "viewworth/gpu.h"

// Opens the preferred device at the first call; fails the test when there is none.
struct vw_gpu *test_gpu(void);

// Opens a device that the test owns; what validation says of it fails the test when it is released.
struct vw_gpu *test_gpu_open(struct vw_gpu_params params);

// Returns a buffer, a pass or a submission that the test owns.
struct vw_buffer *test_buffer(struct vw_gpu *gpu, const char *name, uint64_t size_bytes);
struct vw_buffer *test_buffer_of(struct vw_gpu *gpu, struct vw_buffer_params params);
struct vw_pass *test_pass(struct vw_gpu *gpu, struct vw_pass_params params);
struct vw_submission *test_submission(struct vw_gpu *gpu);
// Submits what was recorded, and waits for it.
void test_submit(struct vw_submission *submission);
// Returns what a whole buffer holds, which the test owns; test_write() writes all of one.
void *test_read(struct vw_buffer *buffer);
void test_write(struct vw_buffer *buffer, const void *data);

// Tears down a cmocka group: releases all that is owned, and fails when validation complained about anything since the
// device was opened.
int test_gpu_close(void **state);

#endif

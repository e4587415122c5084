// What trainers submit their steps in. Trainers that share submissions take steps together: each records its own steps
// into the same batch, where the scheduler of src/gpu places them side by side, because they touch no common buffer. So
// K trainings wait at as many barriers as one. None of them has another bit than alone.
#ifndef VIEWWORTH_TRAIN_SUBMISSIONS_H
#define VIEWWORTH_TRAIN_SUBMISSIONS_H

#include "viewworth/gpu.h"
#include "viewworth/status.h"

struct vw_submissions;

enum { VW_TRAINERS_TOGETHER_MAX = 16 };

// `gpu` outlives them, and they outlive their trainers.
enum vw_status vw_submissions_create(struct vw_gpu *gpu, struct vw_submissions **submissions);
void vw_submissions_destroy(struct vw_submissions **submissions);

// How many trainings to take together on a device: one on a CPU, whose cores a single training fills; elsewhere as many
// of `bytes_each` as fit into half of its memory, up to VW_TRAINERS_TOGETHER_MAX.
uint32_t vw_trainers_together(const struct vw_gpu_info *device, uint64_t bytes_each);

#endif

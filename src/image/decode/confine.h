// Takes from this process what decoding does not need.
#ifndef VIEWWORTH_IMAGE_DECODE_CONFINE_H
#define VIEWWORTH_IMAGE_DECODE_CONFINE_H

#include <stdbool.h>
#include <stdint.h>

struct vw_confinement {
    uint64_t memory_bytes;    // address space beyond what the process has now
    uint64_t cpu_s;           // after which the kernel kills it
    uint32_t descriptor_most; // no descriptor above this one can be opened
    bool without_seccomp;     // for tests of kernels that have none
};

// Confines the process for the rest of its life: it opens no file and no socket (the descriptors that it has, and those
// that it is sent, work), starts no process or thread, gains no privileges, leaves no core file, and has these limits.
// If the kernel has no seccomp, only the limits apply: one free descriptor is left, for the file that it is sent.
// Returns false if a limit cannot be set, or no filter although the kernel has them: the process must end.
bool vw_confine(const struct vw_confinement *confinement);

#endif

// The GPU layer: one Vulkan device and one compute queue, with buffers, passes and submissions.
//
// A *pass* is one compute shader with its specialization and its buffers bound; its name is the shader's file stem and
// is used as debug label, object name and timer name. A *submission* is a command buffer that records many passes and
// is submitted once. Barriers are derived: a pass declares, by the `readonly`/`writeonly` qualifiers of its GLSL
// buffers (read back from the SPIR-V), what it reads and writes; buffers remember their last access. No caller writes a
// barrier.
//
// Recording functions return void: the first failure sticks to the submission and vw_submission_submit() reports it.
#ifndef VIEWWORTH_GPU_COMPUTE_H
#define VIEWWORTH_GPU_COMPUTE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/status.h"

struct vw_buffer;
struct vw_pass;
struct vw_submission;

// ---- Buffers -------------------------------------------------------------------------------------------------------

uint64_t vw_gpu_buffer_bytes(const struct vw_gpu *gpu); // bytes of all live buffers

enum vw_buffer_memory {
    VW_BUFFER_DEVICE,   // device memory; the host goes through vw_buffer_write/read
    VW_BUFFER_UPLOAD,   // host memory the GPU reads; mapped
    VW_BUFFER_SHARED,   // device memory the host writes, where there is some, else as UPLOAD; mapped
    VW_BUFFER_READBACK, // host-cached memory the GPU writes; mapped
};

struct vw_buffer_params {
    const char *name;    // for debug tools and error messages; copied
    uint64_t size_bytes; // > 0; may exceed one binding's range: bind windows of it
    enum vw_buffer_memory memory;
};

// Creates a buffer; its bytes are zero.
enum vw_status vw_buffer_create(struct vw_gpu *gpu, const struct vw_buffer_params *params, struct vw_buffer **buffer);
// Destroys a buffer. The caller makes sure that no submission still uses it.
void vw_buffer_destroy(struct vw_buffer **buffer);
uint64_t vw_buffer_size_bytes(const struct vw_buffer *buffer);
// Returns the mapped, coherent memory of an UPLOAD, SHARED or READBACK buffer; NULL for DEVICE. It is valid until
// destroy. The caller must not touch it while a submission uses it, and never reads that of UPLOAD or SHARED: discrete
// cards do not cache it.
void *vw_buffer_map(struct vw_buffer *buffer);
// Copies between host and any buffer and waits for the GPU; ordered after everything submitted before.
enum vw_status vw_buffer_write(struct vw_buffer *buffer, uint64_t offset_bytes, const void *data, uint64_t size_bytes);
enum vw_status vw_buffer_read(struct vw_buffer *buffer, uint64_t offset_bytes, void *data, uint64_t size_bytes);

// ---- Passes --------------------------------------------------------------------------------------------------------

// A compiled shader, embedded at build time. `name` is the file stem, e.g. "forward_field".
struct vw_shader {
    const char *name;
    const uint32_t *code; // SPIR-V
    size_t code_bytes;
};

enum vw_texel_format {
    VW_TEXEL_NONE,
    VW_TEXEL_FLOAT1,
    VW_TEXEL_FLOAT2,
    VW_TEXEL_FLOAT4,
    VW_TEXEL_UINT1,
    VW_TEXEL_UINT2,
    VW_TEXEL_UINT4,
};

struct vw_binding {
    uint32_t slot;            // VW_SLOT_* of shaders/interface.h
    struct vw_buffer *buffer; // NULL, if `unused`
    uint64_t offset_bytes;    // multiple of the device's alignment for that kind of binding
    uint64_t size_bytes;      // 0: to the end of the buffer; the range must fit storage_binding_bytes
    bool unused; // the shader declares the slot, but this specialization leaves it alone: the pass waits for
                 // no one, and binds a few bytes of its own
    enum vw_texel_format
        texel; // set exactly where the shader declares a texel buffer. The view covers as much of the range
               // as texel_elements allows: the shader falls back to the storage binding beyond it.
};

struct vw_pass_params {
    const struct vw_shader *shader;
    const uint32_t
        *specialization; // word i is the value of constant_id i; floats by their bits. NULL when there are none
    uint32_t specialization_count;
    const struct vw_binding
        *bindings; // every slot the shader declares, each once; slots it does not declare are ignored
    uint32_t binding_count;
    const char
        *role; // NULL, or a static text that tells this use of the shader from others in the timers: "validation"
};

// Builds the pipeline and binds the buffers, which must outlive the pass. Refuses, naming the pass and the slot, a
// declared slot without buffer, a range beyond the limits, and shared memory or workgroup sizes beyond the limits.
enum vw_status vw_pass_create(struct vw_gpu *gpu, const struct vw_pass_params *params, struct vw_pass **pass);
void vw_pass_destroy(struct vw_pass **pass);
const char *vw_pass_name(const struct vw_pass *pass);

uint32_t vw_gpu_pipeline_count(const struct vw_gpu *gpu); // compiled so far; passes share them
double vw_gpu_pipeline_s(const struct vw_gpu *gpu);       // seconds that compiling them took

// ---- Submissions ----------------------------------------------------------------------------------------------------

enum vw_status vw_submission_create(struct vw_gpu *gpu, struct vw_submission **submission);
void vw_submission_destroy(struct vw_submission **submission); // waits for it first

void vw_submission_begin(
    struct vw_submission *submission); // must not be in flight; one submission of a device records at a time
// Runs at least `invocations` invocations: ceil(invocations / workgroup size) workgroups, folded into y beyond
// workgroup_count_x (shaders find their index with invocation_index() of shaders/invocation.glsl). `push_bytes` must
// equal the size of the shader's push block. It runs as early as the accesses recorded before allow, also
// before or beside commands recorded earlier.
void vw_submission_dispatch(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                            size_t push_bytes, uint64_t invocations);
// Runs `rows` rows of workgroups, each of at least `invocations` invocations; a row is gl_WorkGroupID.y.
void vw_submission_dispatch_rows(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                                 size_t push_bytes, uint64_t invocations, uint32_t rows);
// Runs as many workgroups, in x, y and z, as three uints at `offset_bytes` (a multiple of 4) of `groups` say once
// everything before has run, also none. Whoever writes them keeps to workgroup_count_x and _y, and folds as
// invocation_index() expects.
void vw_submission_dispatch_indirect(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                                     size_t push_bytes, struct vw_buffer *groups, uint64_t offset_bytes);
void vw_submission_copy(struct vw_submission *submission, struct vw_buffer *from, uint64_t from_offset_bytes,
                        struct vw_buffer *to, uint64_t to_offset_bytes, uint64_t size_bytes);
// Ends recording and submits; several submissions may be in flight, they run in order. Reports what recording met.
// Commands that equal those it submitted last, but for what is pushed, are not written for the device again.
enum vw_status vw_submission_submit(struct vw_submission *submission);
// Waits until the submission is done (at once when it was never submitted); READBACK buffers it wrote can then be read.
enum vw_status vw_submission_wait(struct vw_submission *submission);

// The submissions so far, and those of them at which the device had already done all that came before: there it waited
// for the host.
struct vw_submission_counts {
    uint64_t submitted, host_bound;
};
struct vw_submission_counts vw_gpu_submission_counts(const struct vw_gpu *gpu);

// ---- Timers --------------------------------------------------------------------------------------------------------

struct vw_gpu_timer {
    const char *name, *role; // name and role of the pass
    uint64_t dispatches;
    double total_ms; // device time of finished submissions; timers may drop a dispatch, never block
};
// Timers so far, in order of first use; the array belongs to `gpu` and is valid until the next wait. Empty without
// timers.
const struct vw_gpu_timer *vw_gpu_timers(const struct vw_gpu *gpu, uint32_t *count);

#endif

// Guard bands around every buffer of a test program, without the product knowing: the linker sends these calls here
// (--wrap, see CMakeLists.txt), and here a buffer becomes larger by a band of a pattern on either side.
//
// A binding that reaches its buffer's end is let run on into the band behind. Else an overrun would show on no device
// that masks what lies outside a binding, as lavapipe does. So a pass that writes too far corrupts the band, and one
// that reads too far meets NaN. The one exception is a shader that asks a binding for its length: it gets the true one.
#include "support/guard_bands.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "viewworth/gpu.h"

WRAPS(vw_buffer_create);
WRAPS(vw_buffer_destroy);
WRAPS(vw_buffer_size_bytes);
WRAPS(vw_buffer_map);
WRAPS(vw_buffer_write);
WRAPS(vw_buffer_read);
WRAPS(vw_pass_create);
WRAPS(vw_submission_copy);
WRAPS(vw_submission_dispatch_indirect);
WRAPS(vw_gpu_close);

enum {
    BAND_BYTES = 16384,
    BUFFERS_MAX = 1024,
    SLOTS_MAX = 96
}; // the band: a multiple of every offset alignment that Vulkan allows

static struct guarded {
    struct vw_buffer *buffer;
    char name[48];
    uint64_t
        before_bytes;    // the band before it; none before buffers that passes and submissions make and bind themselves
    uint64_t size_bytes; // between the bands
    uint32_t number;     // place among all buffers so far
} guarded[BUFFERS_MAX];
static uint32_t buffer_count;
static unsigned broken_count;

static struct guarded *find(const struct vw_buffer *buffer) {
    for (size_t i = 0; i < BUFFERS_MAX && buffer; i++)
        if (guarded[i].buffer == buffer) return &guarded[i];
    return NULL;
}

// Fills a band with words that are NaN as floats, huge as integers, and nowhere the same: a sum over one band's NaN
// keeps its bits, and would pass for another band.
static void fill_pattern(const struct guarded *it, int side, uint32_t words[BAND_BYTES / 4]) {
    for (uint32_t i = 0; i < BAND_BYTES / 4; i++)
        words[i] = 0xFFC00000u | ((it->number * 2 + (uint32_t)side) * 40503u + i * 977u) % 0x3FFFFFu;
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

enum side { BEFORE, BEHIND };

static uint64_t band_offset(const struct guarded *it, int side) {
    return side == BEFORE ? 0 : it->before_bytes + it->size_bytes;
}

static bool binds_itself(const char *name) { return name && (!strcmp(name, "unused") || !strcmp(name, "push blocks")); }

static enum vw_status guard(struct vw_buffer *buffer, const struct vw_buffer_params *params) {
    size_t i = 0;
    while (i < BUFFERS_MAX && guarded[i].buffer) i++;
    if (i == BUFFERS_MAX)
        return vw_fail(VW_ERROR_MEMORY, "more than %d buffers at once; raise BUFFERS_MAX in %s", BUFFERS_MAX, __FILE__);
    guarded[i] = (struct guarded){.buffer = buffer, .size_bytes = params->size_bytes, .number = buffer_count++};
    guarded[i].before_bytes = binds_itself(params->name) ? 0 : BAND_BYTES;
    snprintf(guarded[i].name, sizeof guarded[i].name, "%s", params->name ? params->name : "unnamed");
    enum vw_status status = VW_OK;
    for (int side = guarded[i].before_bytes ? BEFORE : BEHIND; side <= BEHIND && !status; side++) {
        uint32_t words[BAND_BYTES / 4];
        fill_pattern(&guarded[i], side, words);
        status = __real_vw_buffer_write(buffer, band_offset(&guarded[i], side), words, BAND_BYTES);
    }
    return status;
}

enum vw_status __wrap_vw_buffer_create(struct vw_gpu *gpu, const struct vw_buffer_params *params,
                                       struct vw_buffer **buffer) {
    struct vw_buffer_params larger = *params;
    if (larger.size_bytes) larger.size_bytes += 2 * BAND_BYTES;
    enum vw_status status = __real_vw_buffer_create(gpu, &larger, buffer);
    if (status) return status;
    status = guard(*buffer, params);
    if (status) __wrap_vw_buffer_destroy(buffer);
    return status;
}

static void check_band(const struct guarded *it, int side) {
    if (side == BEFORE && !it->before_bytes) return;
    uint32_t expected[BAND_BYTES / 4], found[BAND_BYTES / 4];
    fill_pattern(it, side, expected);
    if (__real_vw_buffer_read(it->buffer, band_offset(it, side), found, BAND_BYTES))
        return; // a lost device says so itself
    for (size_t i = 0; i < VW_ARRAY_COUNT(found); i++) {
        if (found[i] == expected[i]) continue;
        fprintf(stderr, "guard band %s buffer %s (%llu bytes) was written to, at its byte %zu\n",
                side == BEFORE ? "before" : "behind", it->name, (unsigned long long)it->size_bytes, 4 * i);
        broken_count++;
        __real_vw_buffer_write(it->buffer, band_offset(it, side), expected,
                               BAND_BYTES); // mended, so that it is told once
        return;
    }
}

void __wrap_vw_buffer_destroy(struct vw_buffer **buffer) {
    struct guarded *it = find(*buffer);
    if (it) {
        check_band(it, BEFORE);
        check_band(it, BEHIND);
        *it = (struct guarded){0};
    }
    __real_vw_buffer_destroy(buffer);
}

static uint64_t shift(const struct vw_buffer *buffer, uint64_t offset_bytes) {
    const struct guarded *it = find(buffer); // the product's own staging buffer has no bands
    return it ? offset_bytes + it->before_bytes : offset_bytes;
}

uint64_t __wrap_vw_buffer_size_bytes(const struct vw_buffer *buffer) {
    const struct guarded *it = find(buffer);
    return it ? it->size_bytes : __real_vw_buffer_size_bytes(buffer);
}

void *__wrap_vw_buffer_map(struct vw_buffer *buffer) {
    char *memory = __real_vw_buffer_map(buffer);
    return memory ? memory + shift(buffer, 0) : NULL;
}

enum vw_status __wrap_vw_buffer_write(struct vw_buffer *buffer, uint64_t offset_bytes, const void *data,
                                      uint64_t size_bytes) {
    return __real_vw_buffer_write(buffer, shift(buffer, offset_bytes), data, size_bytes);
}

enum vw_status __wrap_vw_buffer_read(struct vw_buffer *buffer, uint64_t offset_bytes, void *data, uint64_t size_bytes) {
    return __real_vw_buffer_read(buffer, shift(buffer, offset_bytes), data, size_bytes);
}

void __wrap_vw_submission_copy(struct vw_submission *submission, struct vw_buffer *from, uint64_t from_offset_bytes,
                               struct vw_buffer *to, uint64_t to_offset_bytes, uint64_t size_bytes) {
    __real_vw_submission_copy(submission, from, shift(from, from_offset_bytes), to, shift(to, to_offset_bytes),
                              size_bytes);
}

void __wrap_vw_submission_dispatch_indirect(struct vw_submission *submission, const struct vw_pass *pass,
                                            const void *push, size_t push_bytes, struct vw_buffer *groups,
                                            uint64_t offset_bytes) {
    __real_vw_submission_dispatch_indirect(submission, pass, push, push_bytes, groups, shift(groups, offset_bytes));
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

static bool asks_for_lengths(const struct vw_shader *shader) {
    enum { HEADER_WORDS = 5, OP_ARRAY_LENGTH = 68 };
    for (size_t i = HEADER_WORDS; i < shader->code_bytes / 4; i += shader->code[i] >> 16 ? shader->code[i] >> 16 : 1)
        if ((shader->code[i] & 0xFFFF) == OP_ARRAY_LENGTH) return true;
    return false;
}

static struct vw_binding widen(const struct vw_binding *binding, bool exactly, uint64_t range_bytes) {
    const struct guarded *it = find(binding->buffer);
    struct vw_binding wide = *binding;
    if (!it) return wide;
    wide.offset_bytes += BAND_BYTES;
    if (!wide.size_bytes) wide.size_bytes = it->size_bytes - binding->offset_bytes;
    bool ends = binding->offset_bytes + wide.size_bytes == it->size_bytes;
    if (ends && !exactly && wide.size_bytes + BAND_BYTES <= range_bytes) wide.size_bytes += BAND_BYTES;
    return wide;
}

enum vw_status __wrap_vw_pass_create(struct vw_gpu *gpu, const struct vw_pass_params *params, struct vw_pass **pass) {
    struct vw_binding bindings[SLOTS_MAX];
    struct vw_pass_params wide = *params;
    bool exactly = asks_for_lengths(params->shader);
    if (params->binding_count > SLOTS_MAX)
        return vw_fail(VW_ERROR_DEVICE, "more than %d bindings; raise SLOTS_MAX in %s", SLOTS_MAX, __FILE__);
    for (uint32_t i = 0; i < params->binding_count; i++)
        bindings[i] = widen(&params->bindings[i], exactly, vw_gpu_get_limits(gpu)->storage_binding_bytes);
    wide.bindings = bindings;
    return __real_vw_pass_create(gpu, &wide, pass);
}

// ---- The verdict ----------------------------------------------------------------------------------------------------

unsigned guard_bands_broken(void) {
    for (size_t i = 0; i < BUFFERS_MAX; i++)
        for (int side = 0; side < 2 && guarded[i].buffer; side++) check_band(&guarded[i], side);
    unsigned broken = broken_count;
    broken_count = 0;
    return broken;
}

enum vw_status __wrap_vw_gpu_close(struct vw_gpu **gpu) {
    enum vw_status status = __real_vw_gpu_close(gpu);
    if (status || !broken_count) return status;
    return vw_fail(VW_ERROR_DEVICE, "%u guard bands were written to; see the messages on stderr", broken_count);
}

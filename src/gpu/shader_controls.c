#include "gpu/shader_controls.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"

enum { // SPIR-V 1.5, sections 2.3, 3.6, 3.31, 3.52
    HEADER_WORDS = 5,
    VERSION_1_4 = 0x10400, // since this version no extension has to be named
    OP_ENTRY_POINT = 15,
    OP_EXECUTION_MODE = 16,
    OP_CAPABILITY = 17,
    CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE = 4466,
    MODE_SIGNED_ZERO_INF_NAN_PRESERVE = 4461,
    FLOAT_BITS = 32,
};

static uint32_t instruction(uint32_t words, uint32_t operation) { return words << 16 | operation; }

// Returns the place of the word after the entry point, and the entry point's id.
static size_t find_entry_end(const uint32_t *code, size_t words, uint32_t *entry) {
    for (size_t at = HEADER_WORDS; at < words && code[at] >> 16; at += code[at] >> 16)
        if ((code[at] & 0xFFFF) == OP_ENTRY_POINT) {
            *entry = code[at + 2];
            return at + (code[at] >> 16);
        }
    assert(!"a shader without entry point"); // our own build's doing
    return words;
}

uint32_t *vw_spirv_keep_nan(const struct vw_shader *shader, size_t *code_bytes) {
    uint32_t entry = 0;
    size_t words = shader->code_bytes / 4, entry_end = find_entry_end(shader->code, words, &entry);
    assert(shader->code[1] >= VERSION_1_4);
    const uint32_t capability[] = {instruction(2, OP_CAPABILITY), CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE};
    const uint32_t mode[] = {instruction(4, OP_EXECUTION_MODE), entry, MODE_SIGNED_ZERO_INF_NAN_PRESERVE, FLOAT_BITS};
    *code_bytes = shader->code_bytes + sizeof capability + sizeof mode;
    uint32_t *code = vw_allocate(1, *code_bytes), *next = code;
    if (!code) return NULL;
    const struct {
        const uint32_t *from;
        size_t words;
    } parts[] = {{shader->code, HEADER_WORDS},
                 {capability, VW_ARRAY_COUNT(capability)},
                 {shader->code + HEADER_WORDS, entry_end - HEADER_WORDS},
                 {mode, VW_ARRAY_COUNT(mode)},
                 {shader->code + entry_end, words - entry_end}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(parts); next += parts[i++].words)
        memcpy(next, parts[i].from, 4 * parts[i].words);
    return code;
}

enum { // SPIR-V 1.5, sections 2.3, 3.23, 3.52.17
    OP_LOOP_MERGE = 246,
    CONTROL_WORD = 3, // index in OP_LOOP_MERGE
    CONTROL_UNROLL = 1,
    CONTROL_DONT_UNROLL = 2,
};

static const char *choice(void) {
    const char *set = getenv("VIEWWORTH_LOOPS");
    return set && *set ? set : "unrolled";
}

bool vw_loops_unroll(void) { return strcmp(choice(), "kept") != 0; }

enum vw_status vw_loops_check_choice(void) {
    if (!strcmp(choice(), "unrolled") || !strcmp(choice(), "kept")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "VIEWWORTH_LOOPS is \"%s\"; set it to unrolled or kept, or unset it", choice());
}

void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes) {
    size_t words = code_bytes / 4;
    for (size_t at = HEADER_WORDS; at < words && code[at] >> 16; at += code[at] >> 16)
        if ((code[at] & 0xFFFF) == OP_LOOP_MERGE && code[at + CONTROL_WORD] & CONTROL_UNROLL)
            code[at + CONTROL_WORD] ^= CONTROL_UNROLL | CONTROL_DONT_UNROLL;
}

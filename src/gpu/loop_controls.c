#include "gpu/loop_controls.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { // SPIR-V 1.5, sections 2.3, 3.23, 3.52.17
    HEADER_WORDS = 5,
    OP_LOOP_MERGE = 246,
    CONTROL_WORD = 3, // of OP_LOOP_MERGE
    CONTROL_UNROLL = 1,
    CONTROL_DONT_UNROLL = 2,
};

static const VkDriverId weak_compilers[] = {
    VK_DRIVER_ID_GOOGLE_SWIFTSHADER, // follows every path through branches that were unrolled
};

static const char *wish(void) {
    const char *set = getenv("VIEWWORTH_LOOPS");
    return set ? set : "";
}

bool vw_loops_unroll(VkDriverId driver) {
    if (*wish()) return !strcmp(wish(), "unrolled");
    for (size_t i = 0; i < VW_ARRAY_COUNT(weak_compilers); i++)
        if (weak_compilers[i] == driver) return false;
    return true;
}

enum vw_status vw_loops_check_choice(void) {
    if (!*wish() || !strcmp(wish(), "unrolled") || !strcmp(wish(), "kept")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "VIEWWORTH_LOOPS is \"%s\"; set it to unrolled or kept, or unset it", wish());
}

void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes) {
    size_t words = code_bytes / 4;
    for (size_t at = HEADER_WORDS; at < words && code[at] >> 16; at += code[at] >> 16)
        if ((code[at] & 0xFFFF) == OP_LOOP_MERGE && code[at + CONTROL_WORD] & CONTROL_UNROLL)
            code[at + CONTROL_WORD] ^= CONTROL_UNROLL | CONTROL_DONT_UNROLL;
}

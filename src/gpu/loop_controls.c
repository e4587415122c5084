#include "gpu/loop_controls.h"

#include <stdlib.h>
#include <string.h>

enum { // SPIR-V 1.5, sections 2.3, 3.23, 3.52.17
    HEADER_WORDS = 5,
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

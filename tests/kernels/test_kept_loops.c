// The form of the shaders that keeps its loops (VIEWWORTH_LOOPS=kept), for drivers that take too long to compile what
// is unrolled: no loop asks to be unrolled, and the passes with most loops meet the reference as well.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/shaders.h"
#include "gpu/spirv.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

enum { HEADER_WORDS = 5, OP_LOOP_MERGE = 246, CONTROL_WORD = 3, UNROLL = 1, DONT_UNROLL = 2, CASE_STRIDE = 9 };

static uint32_t count_loops(const uint32_t *code, size_t words, uint32_t control) {
    uint32_t count = 0;
    for (size_t at = HEADER_WORDS; at < words; at += code[at] >> 16)
        count += (code[at] & 0xFFFF) == OP_LOOP_MERGE && code[at + CONTROL_WORD] == control;
    return count;
}

TEST_CASES(every_loop_that_asks_to_be_unrolled_asks_to_be_kept, i, vw_shader_count) {
    const struct vw_shader *shader = vw_shaders[i];
    size_t words = shader->code_bytes / 4;
    uint32_t *code = test_allocate(words, 4);
    assert_non_null(code);
    memcpy(code, shader->code, shader->code_bytes);
    uint32_t unrolled = count_loops(code, words, UNROLL), kept = count_loops(code, words, DONT_UNROLL);
    vw_spirv_keep_loops(code, shader->code_bytes);
    if (count_loops(code, words, UNROLL) || count_loops(code, words, DONT_UNROLL) != unrolled + kept)
        fail_msg("%s: %u loops still ask to be unrolled", shader->name, count_loops(code, words, UNROLL));
}

TEST(passes_that_keep_their_loops_meet_the_reference) {
    pass_check *const checks[] = {check_forward_field, check_backward_field, check_gradient_weights,
                                  check_scatter_grid};
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.unrolls_loops = false;
    for (uint32_t i = 0; i < step_case_count; i += CASE_STRIDE) {
        struct step_bench *bench = step_bench_open_clamped(&step_cases[i], &clamp);
        assert_false(vw_gpu_get_limits(bench->gpu)->unrolls_loops);
        for (size_t k = 0; k < VW_ARRAY_COUNT(checks); k++) {
            checks[k](bench, INPUT_ORDINARY);
        }
        test_release(bench);
    }
}

TEST(another_word_than_kept_or_unrolled_is_refused) {
    struct vw_gpu *gpu = NULL;
    assert_int_equal(setenv("VIEWWORTH_LOOPS", "folded", 1), 0);
    ASSERT_FAILS(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu), VW_ERROR_USAGE, "VIEWWORTH_LOOPS is \"folded\"");
    assert_int_equal(unsetenv("VIEWWORTH_LOOPS"), 0);
}

// So that a run's identity, which holds the driver's text, tells the forms apart.
TEST(the_driver_text_tells_that_loops_are_kept) {
    struct vw_gpu *gpu = NULL;
    assert_null(strstr(vw_gpu_get_info(test_gpu())->driver, "loops kept"));
    assert_int_equal(setenv("VIEWWORTH_LOOPS", "kept", 1), 0);
    assert_int_equal(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu), VW_OK);
    assert_int_equal(unsetenv("VIEWWORTH_LOOPS"), 0);
    assert_non_null(strstr(vw_gpu_get_info(gpu)->driver, ", loops kept"));
    assert_false(vw_gpu_get_limits(gpu)->unrolls_loops);
    assert_int_equal(vw_gpu_close(&gpu), VW_OK);
}

TEST_GROUP(NULL, test_gpu_close)

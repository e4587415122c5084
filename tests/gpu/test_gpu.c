// Devices, limits, buffers and passes.
#include "base/memory.h"
#include "count_atomically.h"
#include "gather_texels.h"
#include "gpu/compute.h"
#include "gpu/instance.h"
#include "gpu/pipeline.h"
#include "gpu/state.h"
#include "halve_double.h"
#include "scale_values.h"
#include "sum_windows.h"
#include "support/cmocka_test.h"
#include "support/gpu_fixture.h"

static const struct vw_shader scale_values = {"scale_values", scale_values_code, sizeof scale_values_code};
static const struct vw_shader gather_texels = {"gather_texels", gather_texels_code, sizeof gather_texels_code};
static const struct vw_shader sum_windows = {"sum_windows", sum_windows_code, sizeof sum_windows_code};
static const struct vw_shader count_atomically = {"count_atomically", count_atomically_code,
                                                  sizeof count_atomically_code};
static const struct vw_shader halve_double = {"halve_double", halve_double_code, sizeof halve_double_code};

struct scale_push {
    uint32_t count;
    uint32_t factor;
};

static void run_pass(struct vw_gpu *gpu, const struct vw_pass *pass, const void *push, size_t push_bytes,
                     uint64_t invocations) {
    struct vw_submission *submission = test_submission(gpu);
    vw_submission_begin(submission);
    vw_submission_dispatch(submission, pass, push, push_bytes, invocations);
    ASSERT_OK(vw_submission_submit(submission));
    ASSERT_OK(vw_submission_wait(submission));
}

static struct vw_gpu *open_clamped(const struct vw_gpu_limits *clamp) {
    return test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = clamp});
}

// ---- Devices --------------------------------------------------------------------------------------------------------

TEST(devices_are_listed_in_order_of_preference) {
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_gpu_list(&infos, &count));
    assert_true(count > 0);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(infos[i].index, i);
        assert_true(strlen(infos[i].name) > 0 && strlen(infos[i].driver) > 0 && infos[i].memory_bytes > 0);
        if (i) assert_true(infos[i - 1].kind <= infos[i].kind);
        if (infos[i].kind == VW_GPU_CPU) assert_non_null(strstr(infos[i].name, " on "));
    }
    free(infos);
}

TEST(a_device_is_chosen_by_index_name_or_kind) {
    const struct vw_gpu_info *preferred = vw_gpu_get_info(test_gpu());
    char upper[256];
    for (size_t i = 0; i < sizeof upper; i++) {
        char letter = preferred->name[i];
        upper[i] = letter >= 'a' && letter <= 'z' ? (char)(letter - 'a' + 'A') : letter;
    }
    char index[16];
    snprintf(index, sizeof index, "%u", preferred->index);
    bool cpu = preferred->kind == VW_GPU_CPU;
    const char *const choices[] = {index, upper, cpu ? "cpu" : "gpu", cpu ? "CPU" : "GPU"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(choices); i++) {
        struct vw_gpu *gpu = NULL;
        ASSERT_OK(vw_gpu_open(&(struct vw_gpu_params){.device = choices[i]}, &gpu));
        assert_string_equal(vw_gpu_get_info(gpu)->name, preferred->name);
        ASSERT_OK(vw_gpu_close(&gpu));
        assert_null(gpu);
    }
}

TEST(an_unknown_device_lists_what_there_is) {
    bool only_cpus = vw_gpu_get_info(test_gpu())->kind == VW_GPU_CPU; // GPUs are preferred
    const char *const choices[] = {"no such device", "99", "000", "", only_cpus ? "gpu" : "gpus"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(choices); i++) {
        struct vw_gpu *gpu = NULL;
        enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.device = choices[i]}, &gpu);
        ASSERT_FAILS(status, VW_ERROR_NO_DEVICE, vw_gpu_get_info(test_gpu())->name);
        assert_null(gpu);
    }
}

TEST(no_driver_is_no_device) {
    const char *before = getenv("VK_DRIVER_FILES"); // goes before every other way to name drivers
    char *kept = before ? vw_copy_text(before) : NULL;
    assert_int_equal(setenv("VK_DRIVER_FILES", "/nonexistent.json", 1), 0);
    struct vw_gpu_info *infos = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_gpu_list(&infos, &count);
    if (kept) setenv("VK_DRIVER_FILES", kept, 1);
    else unsetenv("VK_DRIVER_FILES");
    free(kept);
    ASSERT_FAILS(status, VW_ERROR_NO_DEVICE, "install");
}

TEST(a_clamp_only_lowers) {
    struct vw_gpu_limits clamp = vw_gpu_floor_limits;
    clamp.buffer_bytes = UINT64_MAX;
    clamp.storage_offset_alignment_bytes = 1;
    struct vw_gpu *gpu = open_clamped(&clamp);
    const struct vw_gpu_limits *limits = vw_gpu_get_limits(gpu), *queried = vw_gpu_get_limits(test_gpu());
    assert_int_equal(limits->buffer_bytes, queried->buffer_bytes);
    assert_int_equal(limits->storage_offset_alignment_bytes, queried->storage_offset_alignment_bytes);
    assert_int_equal(limits->texel_elements, vw_gpu_floor_limits.texel_elements);
    assert_int_equal(limits->texel_offset_alignment_bytes, vw_gpu_floor_limits.texel_offset_alignment_bytes);
    assert_int_equal(limits->storage_buffers, vw_gpu_floor_limits.storage_buffers);
    assert_false(limits->int64 || limits->int64_atomics || limits->timestamps);
}

TEST(queues_without_graphics_are_preferred) {
    const VkQueueFamilyProperties graphics = {.queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT,
                                              .timestampValidBits = 64},
                                  transfer = {.queueFlags = VK_QUEUE_TRANSFER_BIT, .timestampValidBits = 64},
                                  compute = {.queueFlags = VK_QUEUE_COMPUTE_BIT, .timestampValidBits = 64},
                                  untimed = {.queueFlags = VK_QUEUE_COMPUTE_BIT};
    const VkQueueFamilyProperties families[] = {transfer, graphics, untimed, compute};
    assert_int_equal(vw_queue_family_choose(families, 4), 3);
    assert_int_equal(vw_queue_family_choose(families, 3), 1);
    assert_int_equal(vw_queue_family_choose(families, 1), -1);
}

TEST(messages_tell_memory_from_loss) {
    ASSERT_FAILS(vw_gpu_fail(-1, "vkAllocateMemory", "buffer rays"), VW_ERROR_MEMORY,
                 "buffer rays: out of host memory");
    ASSERT_FAILS(vw_gpu_fail(-2, "vkAllocateMemory", "buffer rays"), VW_ERROR_MEMORY, "out of device memory");
    ASSERT_FAILS(vw_gpu_fail(-10, "vkAllocateMemory", "buffer rays"), VW_ERROR_MEMORY, "lower --together");
    ASSERT_FAILS(vw_gpu_fail(-4, "vkQueueSubmit", "submission"), VW_ERROR_DEVICE_LOST, "run again");
    ASSERT_FAILS(vw_gpu_fail(-9, "vkCreateInstance", "Vulkan"), VW_ERROR_NO_DEVICE, "no Vulkan driver");
    ASSERT_FAILS(vw_gpu_fail(-3, "vkCreateDevice", "a card"), VW_ERROR_DEVICE,
                 "a card: vkCreateDevice failed with VkResult -3");
}

TEST(a_validation_complaint_fails_submit_and_close) {
    struct vw_gpu *gpu = NULL;
    struct vw_buffer *value = NULL;
    struct vw_pass *pass = NULL;
    struct vw_submission *submission = NULL;
    ASSERT_OK(vw_gpu_open(&(struct vw_gpu_params){.validation = true}, &gpu));
    ASSERT_OK(vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "value", .size_bytes = 4}, &value));
    print_message("one validation message is expected here:\n");
    ASSERT_OK(vw_pass_create(gpu,
                             &(struct vw_pass_params){.shader = &halve_double,
                                                      .binding_count = 1,
                                                      .bindings = &(struct vw_binding){.slot = 0, .buffer = value}},
                             &pass));
    ASSERT_OK(vw_submission_create(gpu, &submission));
    vw_submission_begin(submission);
    ASSERT_FAILS(vw_submission_submit(submission), VW_ERROR_DEVICE, "validation complained");
    vw_submission_destroy(&submission);
    vw_pass_destroy(&pass);
    vw_buffer_destroy(&value);
    ASSERT_FAILS(vw_gpu_close(&gpu), VW_ERROR_DEVICE, "validation complained");
    assert_null(gpu);
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

TEST(new_buffers_are_zero_and_only_host_memory_maps) {
    for (enum vw_buffer_memory home = VW_BUFFER_DEVICE; home <= VW_BUFFER_READBACK; home++) {
        struct vw_buffer *buffer = NULL;
        const struct vw_buffer_params params = {.name = "zero", .size_bytes = 1001, .memory = home};
        ASSERT_OK(vw_buffer_create(test_gpu(), &params, &buffer));
        unsigned char bytes[1001];
        memset(bytes, 0xff, sizeof bytes);
        ASSERT_OK(vw_buffer_read(buffer, 0, bytes, sizeof bytes));
        for (size_t i = 0; i < sizeof bytes; i++) assert_int_equal(bytes[i], 0);
        assert_int_equal(vw_buffer_size_bytes(buffer), sizeof bytes);
        assert_true((vw_buffer_map(buffer) == NULL) == (home == VW_BUFFER_DEVICE));
        vw_buffer_destroy(&buffer);
        assert_null(buffer);
    }
}

TEST(write_and_read_cross_the_staging_buffer) {
    const uint64_t count = 5 << 20, size = count * 4;
    struct vw_buffer *buffer = test_buffer(test_gpu(), "large", size + 3);
    uint32_t *there = test_allocate(count, 4), *back = test_allocate(count, 4);
    for (uint32_t i = 0; i < count; i++) there[i] = i * 2654435761u;
    ASSERT_OK(vw_buffer_write(buffer, 3, there, size));
    ASSERT_OK(vw_buffer_read(buffer, 3, back, size));
    assert_memory_equal(there, back, size);
    ASSERT_FAILS(vw_buffer_write(buffer, 4, there, size), VW_ERROR_DEVICE, "buffer large");
    ASSERT_FAILS(vw_buffer_read(buffer, UINT64_MAX, back, 4), VW_ERROR_DEVICE, "buffer large");
}

TEST(a_huge_buffer_is_out_of_memory) {
    struct vw_buffer *buffer = NULL;
    const uint64_t largest = vw_gpu_get_limits(test_gpu())->buffer_bytes;
    const uint64_t sizes[] = {largest + 1, UINT64_MAX};
    for (size_t i = 0; i < VW_ARRAY_COUNT(sizes); i++) {
        const struct vw_buffer_params params = {.name = "huge", .size_bytes = sizes[i]};
        ASSERT_FAILS(vw_buffer_create(test_gpu(), &params, &buffer), VW_ERROR_MEMORY, "buffer huge");
        assert_null(buffer);
    }
    ASSERT_FAILS(vw_buffer_create(test_gpu(), &(struct vw_buffer_params){.name = "none"}, &buffer), VW_ERROR_DEVICE,
                 "buffer none");
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

enum { VALUES = 1000 };

// Checks target = 3 * source + offset on `gpu`; an offset of 0 is left to the shader's default.
static void check_scaling(struct vw_gpu *gpu, uint32_t offset) {
    uint32_t values[VALUES], results[VALUES];
    for (uint32_t i = 0; i < VALUES; i++) values[i] = i * i;
    struct vw_buffer *source = test_buffer(gpu, "source", sizeof values),
                     *target = test_buffer(gpu, "target", sizeof values);
    ASSERT_OK(vw_buffer_write(source, 0, values, sizeof values));
    const uint32_t specialization[] = {1, 2, offset}; // the shader has no constants 0 and 1
    const struct vw_binding bindings[] = {
        {.slot = 3, .buffer = target}, {.slot = 9, .buffer = target}, {.slot = 0, .buffer = source}};
    const struct vw_pass_params params = {.shader = &scale_values,
                                          .specialization = specialization,
                                          .specialization_count = offset ? 3 : 0,
                                          .bindings = bindings,
                                          .binding_count = VW_ARRAY_COUNT(bindings)};
    struct vw_pass *pass = test_pass(gpu, params);
    assert_string_equal(vw_pass_name(pass), "scale_values");
    run_pass(gpu, pass, &(struct scale_push){VALUES - 1, 3}, sizeof(struct scale_push), VALUES);
    ASSERT_OK(vw_buffer_read(target, 0, results, sizeof results));
    for (uint32_t i = 0; i < VALUES - 1; i++) assert_int_equal(results[i], 3 * i * i + offset);
    assert_int_equal(results[VALUES - 1], 0);
}

TEST(a_pass_computes) { check_scaling(test_gpu(), 0); }

TEST(specialization_words_reach_the_shader) { check_scaling(test_gpu(), 1234567); }

TEST(floor_limits_still_run_a_pass) {
    struct vw_gpu *gpu = open_clamped(&vw_gpu_floor_limits);
    check_scaling(gpu, 0);
}

// Fills `values` with what gather_texels reads from a buffer of `count` words holding i + 100, bound with `size_bytes`.
static void gather(struct vw_gpu *gpu, uint32_t *values, uint32_t count, uint64_t size_bytes) {
    struct vw_buffer *source = test_buffer(gpu, "source", count * 4ull),
                     *target = test_buffer(gpu, "target", count * 4ull);
    for (uint32_t i = 0; i < count; i++) values[i] = i + 100;
    ASSERT_OK(vw_buffer_write(source, 0, values, count * 4ull));
    const struct vw_binding bindings[] = {
        {.slot = 1, .buffer = source, .size_bytes = size_bytes, .texel = VW_TEXEL_UINT1},
        {.slot = 2, .buffer = target}};
    struct vw_pass *pass =
        test_pass(gpu, (struct vw_pass_params){.shader = &gather_texels, .bindings = bindings, .binding_count = 2});
    run_pass(gpu, pass, NULL, 0, count);
    ASSERT_OK(vw_buffer_read(target, 0, values, count * 4ull));
}

TEST(a_texel_view_covers_its_range) {
    uint32_t values[300];
    gather(test_gpu(), values, 300, 200 * 4);
    for (uint32_t i = 0; i < 300; i++) assert_int_equal(values[i], i < 200 ? i + 100 : 7);
}

TEST(a_texel_view_is_cut_at_the_limit) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.texel_elements = 130;
    struct vw_gpu *gpu = open_clamped(&clamp);
    uint32_t values[300];
    gather(gpu, values, 300, 0);
    for (uint32_t i = 0; i < 300; i++) assert_int_equal(values[i], i < 130 ? i + 100 : 7);
}

TEST(a_buffer_beyond_one_binding_works_in_windows) {
    enum { WINDOW = 4096, WORDS = WINDOW / 4 };
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.storage_binding_bytes = WINDOW;
    struct vw_gpu *gpu = open_clamped(&clamp);
    uint32_t values[2 * WORDS];
    for (uint32_t i = 0; i < 2 * WORDS; i++) values[i] = i;
    struct vw_buffer *buffer = test_buffer(gpu, "wide", sizeof values);
    ASSERT_OK(vw_buffer_write(buffer, 0, values, sizeof values));
    struct vw_binding bindings[] = {{.slot = 0, .buffer = buffer, .size_bytes = WINDOW},
                                    {.slot = 1, .buffer = buffer, .offset_bytes = WINDOW}};
    const uint32_t specialization[] = {8, 128};
    const struct vw_pass_params params = {.shader = &sum_windows,
                                          .specialization = specialization,
                                          .specialization_count = 2,
                                          .bindings = bindings,
                                          .binding_count = 2};
    struct vw_pass *pass = test_pass(gpu, params);
    run_pass(gpu, pass, NULL, 0, WORDS);
    ASSERT_OK(vw_buffer_read(buffer, 0, values, sizeof values));
    for (uint32_t i = 0; i < WORDS; i++) {
        assert_int_equal(values[i], i);
        assert_int_equal(values[WORDS + i], 2 * i + WORDS);
    }
    bindings[0].size_bytes = 0;
    struct vw_pass *refused = NULL;
    ASSERT_FAILS(vw_pass_create(gpu, &params, &refused), VW_ERROR_DEVICE, "pass sum_windows, slot 0");
    assert_null(refused);
}

TEST(refusals_name_pass_and_slot) {
    struct vw_gpu *gpu = test_gpu();
    struct vw_buffer *buffer = test_buffer(gpu, "values", 4096);
#define BOUND(...)                                                                                                     \
    { .buffer = buffer, __VA_ARGS__ }
    const struct {
        const struct vw_shader *shader;
        struct vw_binding bindings[2];
        const char *part;
    } cases[] = {
        {&scale_values, {BOUND(.slot = 0), BOUND(.slot = 1)}, "pass scale_values, slot 3"},
        {&scale_values, {BOUND(.slot = 0), {.slot = 3}}, "pass scale_values, slot 3"},
        {&scale_values, {BOUND(.slot = 3), BOUND(.slot = 3)}, "slot 3: bound twice"},
        {&scale_values, {BOUND(.slot = 0, .size_bytes = 4097), BOUND(.slot = 3)}, "slot 0: buffer values"},
        {&scale_values, {BOUND(.slot = 0, .offset_bytes = 4096), BOUND(.slot = 3)}, "slot 0: an empty range"},
        {&scale_values, {BOUND(.slot = 0, .offset_bytes = 1), BOUND(.slot = 3)}, "slot 0: offset 1"},
        {&scale_values,
         {BOUND(.slot = 0, .texel = VW_TEXEL_UINT1), BOUND(.slot = 3)},
         "slot 0: the shader declares a storage buffer"},
        {&gather_texels, {BOUND(.slot = 1), BOUND(.slot = 2)}, "declares a texel buffer"},
        {&gather_texels, {BOUND(.slot = 1, .texel = VW_TEXEL_FLOAT1), BOUND(.slot = 2)}, "unsigned texels"},
        {&gather_texels,
         {BOUND(.slot = 1, .size_bytes = 4, .texel = VW_TEXEL_UINT4), BOUND(.slot = 2)},
         "slot 1: buffer values is smaller than one texel"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_pass *pass = NULL;
        const struct vw_pass_params params = {
            .shader = cases[i].shader, .bindings = cases[i].bindings, .binding_count = 2};
        ASSERT_FAILS(vw_pass_create(gpu, &params, &pass), VW_ERROR_DEVICE, cases[i].part);
        assert_null(pass);
    }
}

TEST(specialised_sizes_are_held_to_the_limits) {
    const struct vw_gpu_limits *limits = vw_gpu_get_limits(test_gpu());
    struct vw_buffer *buffer = test_buffer(test_gpu(), "values", 4096);
    const struct vw_binding bindings[] = {{.slot = 0, .buffer = buffer}, {.slot = 1, .buffer = buffer}};
    const struct {
        uint32_t specialization[2];
        const char *part;
    } cases[] = {
        {{limits->shared_memory_bytes / 16 + 1, 32}, "bytes of shared memory"},
        {{8, limits->workgroup_invocations + 1}, "invocations a workgroup"},
        {{8, 0}, "workgroup size is 0"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_pass *pass = NULL;
        ASSERT_FAILS(vw_pass_create(test_gpu(),
                                    &(struct vw_pass_params){.shader = &sum_windows,
                                                             .specialization = cases[i].specialization,
                                                             .specialization_count = 2,
                                                             .bindings = bindings,
                                                             .binding_count = 2},
                                    &pass),
                     VW_ERROR_DEVICE, cases[i].part);
    }
}

TEST(passes_share_pipelines_that_their_code_cannot_tell_apart) {
    struct vw_gpu *gpu = test_gpu();
    struct vw_buffer *buffer = test_buffer(gpu, "values", 4096);
    const struct vw_binding bindings[] = {{.slot = 0, .buffer = buffer}, {.slot = 1, .buffer = buffer}};
    const struct {
        uint32_t specialization[3]; // a length of shared memory, a workgroup size, nothing
        uint32_t made;
    } cases[] = {{{8, 32, 1}, 1}, {{8, 32, 1}, 0}, {{8, 32, 2}, 0}, {{9, 32, 1}, 1}, {{8, 64, 1}, 1}, {{8, 64, 3}, 0}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        uint32_t before = vw_gpu_pipeline_count(gpu);
        test_pass(gpu, (struct vw_pass_params){.shader = &sum_windows,
                                               .specialization = cases[i].specialization,
                                               .specialization_count = 3,
                                               .bindings = bindings,
                                               .binding_count = 2});
        assert_int_equal(vw_gpu_pipeline_count(gpu) - before, cases[i].made);
    }
}

TEST(optional_features_are_refused_where_clamped) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    if (!clamp.int64_atomics) skip();
    for (int clamped = 0; clamped < 2; clamped++) {
        if (clamped) clamp.int64_atomics = false;
        struct vw_gpu *gpu = open_clamped(&clamp);
        struct vw_buffer *counter = test_buffer(gpu, "counter", 8);
        struct vw_pass *refused = NULL;
        uint64_t count = 0;
        const struct vw_binding binding = {.slot = 0, .buffer = counter};
        const struct vw_pass_params params = {.shader = &count_atomically, .binding_count = 1, .bindings = &binding};
        if (clamped) {
            ASSERT_FAILS(vw_pass_create(gpu, &params, &refused), VW_ERROR_DEVICE,
                         "pass count_atomically: needs 64-bit atomics");
            continue;
        }
        run_pass(gpu, test_pass(gpu, params), NULL, 0, 320);
        ASSERT_OK(vw_buffer_read(counter, 0, &count, sizeof count));
        assert_true(count == (uint64_t)320 << 32);
    }
}

TEST_GROUP(NULL, test_gpu_close)

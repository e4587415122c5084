#include "gpu/spirv.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"

// The part of SPIR-V that viewworth reads, numbered as in its specification.
enum operation {
    OP_EXT_INST = 12,
    OP_ENTRY_POINT = 15,
    OP_EXECUTION_MODE = 16,
    OP_CAPABILITY = 17,
    OP_TYPE_VOID = 19,
    OP_TYPE_BOOL = 20,
    OP_TYPE_INT = 21,
    OP_TYPE_FLOAT = 22,
    OP_TYPE_VECTOR = 23,
    OP_TYPE_MATRIX = 24,
    OP_TYPE_IMAGE = 25,
    OP_TYPE_SAMPLED_IMAGE = 27,
    OP_TYPE_ARRAY = 28,
    OP_TYPE_STRUCT = 30,
    OP_TYPE_POINTER = 32,
    OP_TYPE_FORWARD_POINTER = 39,
    OP_CONSTANT_TRUE = 41,
    OP_CONSTANT = 43,
    OP_SPEC_CONSTANT_TRUE = 48,
    OP_SPEC_CONSTANT_FALSE = 49,
    OP_SPEC_CONSTANT = 50,
    OP_SPEC_CONSTANT_OP = 52,
    OP_VARIABLE = 59,
    OP_DECORATE = 71,
    OP_MEMBER_DECORATE = 72,
    OP_ADD = 128,
    OP_SUBTRACT = 130,
    OP_MULTIPLY = 132,
    OP_DIVIDE = 134,
    OP_DIVIDE_SIGNED = 135,
    OP_MODULO = 137,
    OP_SELECT = 169,
    OP_EQUAL = 170,
    OP_GREATER = 172,
    OP_LESS = 176,
    OP_SHIFT_RIGHT = 194,
    OP_SHIFT_LEFT = 196,
    OP_OR = 197,
    OP_AND = 199,
    OP_LOOP_MERGE = 246,
};
enum decoration {
    DECORATION_SPEC_ID = 1,
    DECORATION_ARRAY_STRIDE = 6,
    DECORATION_MATRIX_STRIDE = 7,
    DECORATION_BUILT_IN = 11,
    DECORATION_NON_WRITABLE = 24,
    DECORATION_BINDING = 33,
    DECORATION_SET = 34,
    DECORATION_OFFSET = 35,
};
enum storage_class {
    CLASS_UNIFORM_CONSTANT = 0,
    CLASS_UNIFORM = 2,
    CLASS_WORKGROUP = 4,
    CLASS_PUSH_CONSTANT = 9,
    CLASS_STORAGE_BUFFER = 12,
};
enum {
    HEADER_WORDS = 5,
    MODE_LOCAL_SIZE = 17,
    BUILT_IN_WORKGROUP_SIZE = 25,
    DIMENSION_BUFFER = 5,
    CAPABILITY_INT64 = 11,
    CAPABILITY_INT64_ATOMICS = 12,
    VERSION_1_4 = 0x10400, // since this version no extension has to be named
    CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE = 4466,
    MODE_SIGNED_ZERO_INF_NAN_PRESERVE = 4461,
    FLOAT_BITS = 32,
    CONTROL_WORD = 3, // index in OP_LOOP_MERGE
    CONTROL_UNROLL = 1,
    CONTROL_DONT_UNROLL = 2,
};

// A shader is our own build's doing: what it may not declare is asserted.
struct module {
    const uint32_t *words;
    size_t count;
    const uint32_t **definition; // per id: the instruction that makes a type, constant or variable
    uint32_t id_count;
    const uint32_t *specialization;
    uint32_t specialization_count;
};

static uint32_t operation_of(const uint32_t *instruction) { return instruction[0] & 0xffff; }
static uint32_t length_of(const uint32_t *instruction) { return instruction[0] >> 16; }

// Returns the instruction after `instruction`, the first one after NULL, NULL after the last.
static const uint32_t *next(const struct module *module, const uint32_t *instruction) {
    const uint32_t *following = instruction ? instruction + length_of(instruction) : module->words + HEADER_WORDS;
    return following < module->words + module->count ? following : NULL;
}

// ---- Opening --------------------------------------------------------------------------------------------------------

// Returns which word of an instruction is the id it defines; 0 for one that we never look up.
static uint32_t result_word(uint32_t operation) {
    if (operation >= OP_TYPE_VOID && operation < OP_TYPE_FORWARD_POINTER) return 1;
    if (operation >= OP_CONSTANT_TRUE && operation <= OP_SPEC_CONSTANT_OP) return 2;
    return operation == OP_VARIABLE ? 2 : 0;
}

static enum vw_status open_module(const struct vw_shader *shader, struct module *module) {
    module->words = shader->code;
    module->count = shader->code_bytes / sizeof shader->code[0];
    module->id_count = shader->code[3];
    module->definition = vw_allocate(module->id_count, sizeof *module->definition);
    if (!module->definition) return VW_ERROR_MEMORY;
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at)) {
        uint32_t word = result_word(operation_of(at));
        if (word) module->definition[at[word]] = at;
    }
    return VW_OK;
}

// ---- Decorations and constants --------------------------------------------------------------------------------------

static bool find_decoration(const struct module *module, uint32_t id, uint32_t decoration, uint32_t *value) {
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at)) {
        if (operation_of(at) != OP_DECORATE || at[1] != id || at[2] != decoration) continue;
        if (value) *value = at[3];
        return true;
    }
    return false;
}

static bool find_member_decoration(const struct module *module, uint32_t id, uint32_t member, uint32_t decoration,
                                   uint32_t *value) {
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at)) {
        if (operation_of(at) != OP_MEMBER_DECORATE || at[1] != id || at[2] != member || at[3] != decoration) continue;
        if (value) *value = at[4];
        return true;
    }
    return false;
}

static uint64_t constant_value(const struct module *module, uint32_t id);

static uint64_t evaluate(const struct module *module, const uint32_t *at) {
    uint64_t a = length_of(at) > 4 ? constant_value(module, at[4]) : 0;
    uint64_t b = length_of(at) > 5 ? constant_value(module, at[5]) : 0;
    switch (at[3]) {
    case OP_ADD: return (uint32_t)(a + b);
    case OP_SUBTRACT: return (uint32_t)(a - b);
    case OP_MULTIPLY: return (uint32_t)(a * b);
    case OP_DIVIDE:
    case OP_DIVIDE_SIGNED: return b ? a / b : 0; // lengths are positive
    case OP_MODULO: return b ? a % b : 0;
    case OP_SELECT: return a ? b : constant_value(module, at[6]);
    case OP_EQUAL: return a == b;
    case OP_GREATER: return a > b;
    case OP_LESS: return a < b;
    case OP_SHIFT_RIGHT: return a >> (b & 31);
    case OP_SHIFT_LEFT: return (uint32_t)(a << (b & 31));
    case OP_OR: return a | b;
    case OP_AND: return a & b;
    default: return 0;
    }
}

// Returns the specialised value of a 32-bit integer or boolean constant; 0 for any other id.
static uint64_t constant_value(const struct module *module, uint32_t id) {
    const uint32_t *at = module->definition[id];
    uint32_t spec_id;
    if (!at) return 0;
    if (find_decoration(module, id, DECORATION_SPEC_ID, &spec_id) && spec_id < module->specialization_count)
        return module->specialization[spec_id];
    switch (operation_of(at)) {
    case OP_CONSTANT_TRUE:
    case OP_SPEC_CONSTANT_TRUE: return 1;
    case OP_CONSTANT:
    case OP_SPEC_CONSTANT: return at[3];
    case OP_SPEC_CONSTANT_OP: return evaluate(module, at);
    default: return 0;
    }
}

// ---- Sizes of types -------------------------------------------------------------------------------------------------

struct layout {
    uint64_t bytes;
    uint64_t alignment; // by std430, which Vulkan uses to count shared memory
    uint64_t scalar;    // bytes of the widest scalar in it, the alignment in C
};

static uint64_t round_up(uint64_t value, uint64_t multiple) { return (value + multiple - 1) / multiple * multiple; }

static struct layout layout_of(const struct module *module, uint32_t type);

static struct layout repeat(struct layout item, uint64_t count, uint64_t stride) {
    item.bytes = count * (stride ? stride : round_up(item.bytes, item.alignment));
    return item;
}

// Places the members at their decorated offsets, or one after the other.
static struct layout layout_of_struct(const struct module *module, const uint32_t *at) {
    struct layout whole = {0, 4, 4};
    for (uint32_t member = 0; member + 2 < length_of(at); member++) {
        struct layout part = layout_of(module, at[2 + member]);
        const uint32_t *type = module->definition[at[2 + member]];
        uint32_t offset = 0, stride = 0;
        if (find_member_decoration(module, at[1], member, DECORATION_MATRIX_STRIDE, &stride) &&
            operation_of(type) == OP_TYPE_MATRIX)
            part = repeat(part, type[3], stride);
        bool placed = find_member_decoration(module, at[1], member, DECORATION_OFFSET, &offset);
        whole.bytes = (placed ? offset : round_up(whole.bytes, part.alignment)) + part.bytes;
        if (part.alignment > whole.alignment) whole.alignment = part.alignment;
        if (part.scalar > whole.scalar) whole.scalar = part.scalar;
    }
    return whole;
}

static struct layout layout_of(const struct module *module, uint32_t type) {
    const uint32_t *at = module->definition[type];
    struct layout layout = {0, 4, 4};
    uint32_t stride = 0;
    switch (operation_of(at)) {
    case OP_TYPE_BOOL: return (struct layout){4, 4, 4};
    case OP_TYPE_INT:
    case OP_TYPE_FLOAT: return (struct layout){at[2] / 8, at[2] / 8, at[2] / 8};
    case OP_TYPE_POINTER: return (struct layout){8, 8, 8};
    case OP_TYPE_VECTOR:
        layout = layout_of(module, at[2]);
        layout.alignment = layout.bytes * (at[3] == 3 ? 4 : at[3]);
        layout.bytes *= at[3];
        return layout;
    case OP_TYPE_MATRIX: return repeat(layout_of(module, at[2]), at[3], 0);
    case OP_TYPE_ARRAY:
        find_decoration(module, type, DECORATION_ARRAY_STRIDE, &stride);
        return repeat(layout_of(module, at[2]), constant_value(module, at[3]), stride);
    case OP_TYPE_STRUCT: return layout_of_struct(module, at);
    default: return layout;
    }
}

// ---- What the shader declares ---------------------------------------------------------------------------------------

// Reads the size; the constant decorated as gl_WorkGroupSize, which specialization reaches, wins over the execution
// mode.
static void read_workgroup_size(const struct module *module, struct vw_spirv *spirv) {
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at)) {
        if (operation_of(at) == OP_EXECUTION_MODE && at[2] == MODE_LOCAL_SIZE)
            memcpy(spirv->workgroup_size, at + 3, sizeof spirv->workgroup_size);
        if (operation_of(at) != OP_DECORATE || at[2] != DECORATION_BUILT_IN || at[3] != BUILT_IN_WORKGROUP_SIZE)
            continue;
        const uint32_t *size = module->definition[at[1]];
        for (int axis = 0; axis < 3; axis++)
            spirv->workgroup_size[axis] = (uint32_t)constant_value(module, size[3 + axis]);
        return;
    }
}

// Looks for a decoration on the variable, or on every member of its block, where glslang puts a block's qualifiers.
static bool is_read_only(const struct module *module, uint32_t variable, const uint32_t *block) {
    if (find_decoration(module, variable, DECORATION_NON_WRITABLE, NULL)) return true;
    for (uint32_t member = 0; member + 2 < length_of(block); member++)
        if (!find_member_decoration(module, block[1], member, DECORATION_NON_WRITABLE, NULL)) return false;
    return true;
}

static void describe_slot(const struct module *module, const uint32_t *variable, const uint32_t *type,
                          struct vw_spirv_slot *slot) {
    if (variable[3] == CLASS_STORAGE_BUFFER) {
        slot->writes = !is_read_only(module, variable[2], type);
        return;
    }
    const uint32_t *image = operation_of(type) == OP_TYPE_SAMPLED_IMAGE ? module->definition[type[2]] : type;
    assert(operation_of(image) == OP_TYPE_IMAGE && image[3] == DIMENSION_BUFFER && image[7] == 1); // 1: with a sampler
    slot->texel = true;
    slot->texel_float = operation_of(module->definition[image[2]]) == OP_TYPE_FLOAT;
}

// Returns a decoration of a variable, 0 without it.
static uint32_t decoration_of(const struct module *module, const uint32_t *variable, uint32_t decoration) {
    uint32_t value = 0;
    find_decoration(module, variable[2], decoration, &value);
    return value;
}

static void add_slot(const struct module *module, const uint32_t *variable, const uint32_t *type,
                     struct vw_spirv *spirv) {
    struct vw_spirv_slot slot = {.slot = decoration_of(module, variable, DECORATION_BINDING)};
    assert(!decoration_of(module, variable, DECORATION_SET));
    describe_slot(module, variable, type, &slot);
    for (uint32_t i = 0; i < spirv->slot_count; i++) {
        struct vw_spirv_slot *same = &spirv->slots[i];
        if (same->slot != slot.slot) continue;
        assert(same->texel == slot.texel);
        same->writes |= slot.writes;
        return;
    }
    assert(spirv->slot_count < VW_SPIRV_MAX_SLOTS);
    spirv->slots[spirv->slot_count++] = slot;
}

static void read_variable(const struct module *module, const uint32_t *variable, struct vw_spirv *spirv) {
    const uint32_t *type = module->definition[module->definition[variable[1]][3]];
    struct layout layout;
    switch (variable[3]) {
    case CLASS_UNIFORM_CONSTANT:
    case CLASS_STORAGE_BUFFER: add_slot(module, variable, type, spirv); return;
    case CLASS_UNIFORM:
        assert(decoration_of(module, variable, DECORATION_SET) == VW_PUSH_SET);
        layout = layout_of(module, type[1]);
        spirv->push_bytes = (uint32_t)round_up(layout.bytes, layout.scalar);
        return;
    case CLASS_WORKGROUP:
        layout = layout_of(module, type[1]);
        spirv->shared_bytes = round_up(spirv->shared_bytes, layout.alignment) + layout.bytes;
        return;
    default: assert(variable[3] != CLASS_PUSH_CONSTANT);
    }
}

// ---- Constants that the code refers to ------------------------------------------------------------------------------

// Marks an id and what its definition refers to. A literal that equals an id counts as a reference to it: that costs a
// pipeline, where a reference that is overlooked would make a wrong one.
static void mark(const struct module *module, uint32_t id, bool *marked) {
    if (id >= module->id_count || marked[id]) return;
    marked[id] = true;
    const uint32_t *at = module->definition[id];
    uint32_t operation = at ? operation_of(at) : 0;
    if (operation <= OP_TYPE_FLOAT || operation == OP_CONSTANT || operation == OP_SPEC_CONSTANT)
        return; // literals alone
    for (uint32_t i = 1; i < length_of(at); i++) mark(module, at[i], marked);
}

// Returns from which word on an instruction refers to ids that thereby matter; its length where none does. Types and
// constants matter where something else refers to them. What is decorated as gl_WorkGroupSize needs no reference.
static uint32_t first_reference(const uint32_t *at) {
    uint32_t operation = operation_of(at);
    if (operation == OP_DECORATE) return at[2] == DECORATION_BUILT_IN ? 1 : length_of(at);
    bool is_header = operation <= OP_CAPABILITY && operation != OP_EXT_INST;
    bool is_definition = result_word(operation) && operation != OP_VARIABLE;
    return is_header || is_definition || operation == OP_MEMBER_DECORATE ? length_of(at) : 1;
}

static enum vw_status find_used_constants(const struct module *module, struct vw_spirv *spirv) {
    bool *marked = vw_allocate(module->id_count, sizeof *marked);
    if (!marked) return VW_ERROR_MEMORY;
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at))
        for (uint32_t i = first_reference(at); i < length_of(at); i++) mark(module, at[i], marked);
    for (const uint32_t *at = next(module, NULL); at; at = next(module, at)) {
        if (operation_of(at) != OP_DECORATE || at[2] != DECORATION_SPEC_ID || !marked[at[1]]) continue;
        assert(at[3] < VW_SPIRV_MAX_CONSTANTS);
        spirv->uses_constant[at[3]] = true;
    }
    free(marked);
    return VW_OK;
}

enum vw_status vw_spirv_read(const struct vw_shader *shader, const uint32_t *specialization,
                             uint32_t specialization_count, struct vw_spirv *spirv) {
    struct module module = {.specialization = specialization, .specialization_count = specialization_count};
    struct vw_spirv found = {.workgroup_size = {1, 1, 1}};
    enum vw_status status = open_module(shader, &module);
    if (!status) read_workgroup_size(&module, &found);
    for (const uint32_t *at = status ? NULL : next(&module, NULL); at; at = next(&module, at)) {
        bool capability = operation_of(at) == OP_CAPABILITY;
        found.needs_int64 |= capability && at[1] == CAPABILITY_INT64;
        found.needs_int64_atomics |= capability && at[1] == CAPABILITY_INT64_ATOMICS;
        if (operation_of(at) == OP_VARIABLE) read_variable(&module, at, &found);
    }
    if (!status) status = find_used_constants(&module, &found);
    if (!status) *spirv = found;
    free(module.definition);
    return status;
}

// ---- Demands on compilers ------------------------------------------------------------------------------------------

static uint32_t encode(uint32_t words, uint32_t operation) { return words << 16 | operation; }

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
    const uint32_t capability[] = {encode(2, OP_CAPABILITY), CAPABILITY_SIGNED_ZERO_INF_NAN_PRESERVE};
    const uint32_t mode[] = {encode(4, OP_EXECUTION_MODE), entry, MODE_SIGNED_ZERO_INF_NAN_PRESERVE, FLOAT_BITS};
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

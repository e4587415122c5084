#include "scene/name_index.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "viewworth/scene.h"

struct vw_indexed_name {
    const char *name; // borrowed
    size_t length, place;
    bool in_folder; // looked for: a slash before the name, which `length` counts
};

const char *vw_view_name_of(const char *name) {
    while (!strncmp(name, "./", 2)) name += 2;
    return name;
}

const char *vw_split_name(enum vw_split split) {
    static const char *const names[] = {"train", "val", "test", "excluded"};
    return names[split];
}

static unsigned char from_end(const struct vw_indexed_name *entry, size_t i) {
    size_t at = entry->length - i;
    if (!entry->in_folder) return (unsigned char)entry->name[at];
    return at ? (unsigned char)entry->name[at - 1] : '/';
}

static int compare_lengths(size_t a, size_t b) { return (a > b) - (a < b); }

// Compares from the ends; if one name ends with the other, the shorter is first.
static int compare_texts(const struct vw_indexed_name *a, const struct vw_indexed_name *b) {
    size_t shorter = a->length < b->length ? a->length : b->length;
    for (size_t i = 1; i <= shorter; i++) {
        unsigned char left = from_end(a, i), right = from_end(b, i);
        if (left != right) return left < right ? -1 : 1;
    }
    return compare_lengths(a->length, b->length);
}

static int compare_names(const void *left, const void *right) {
    const struct vw_indexed_name *a = left, *b = right;
    int order = compare_texts(a, b);
    return order ? order : compare_lengths(a->place, b->place);
}

enum vw_status vw_name_index_make(const void *items, size_t item_bytes, size_t name_offset, size_t place_count,
                                  struct vw_name_index *index) {
    *index = (struct vw_name_index){.sorted = vw_allocate(place_count, sizeof *index->sorted)};
    if (!index->sorted) return VW_ERROR_MEMORY;
    for (size_t place = 0; place < place_count; place++) {
        const char *name;
        memcpy(&name, (const char *)items + place * item_bytes + name_offset, sizeof name);
        if (!name) continue;
        name = vw_view_name_of(name);
        index->sorted[index->count++] = (struct vw_indexed_name){name, strlen(name), place, false};
    }
    if (index->count) qsort(index->sorted, index->count, sizeof *index->sorted, compare_names);
    return VW_OK;
}

void vw_name_index_clear(struct vw_name_index *index) {
    free(index->sorted);
    *index = (struct vw_name_index){0};
}

// Returns the first entry that is not before `wanted`, or the count.
static size_t find_first(const struct vw_name_index *index, const struct vw_indexed_name *wanted) {
    size_t begin = 0, end = index->count;
    while (begin < end) {
        size_t middle = begin + (end - begin) / 2;
        if (compare_names(&index->sorted[middle], wanted) < 0) begin = middle + 1;
        else end = middle;
    }
    return begin;
}

bool vw_name_index_find(const struct vw_name_index *index, const char *name, size_t *place) {
    const struct vw_indexed_name wanted = {.name = vw_view_name_of(name), .length = strlen(vw_view_name_of(name))};
    size_t first = find_first(index, &wanted);
    if (first == index->count || compare_texts(&index->sorted[first], &wanted) != 0) return false;
    *place = index->sorted[first].place;
    return true;
}

static bool ends_with(const struct vw_indexed_name *entry, const struct vw_indexed_name *wanted) {
    if (entry->length < wanted->length) return false;
    const char *end = entry->name + entry->length - wanted->length;
    return *end == '/' && !memcmp(end + 1, wanted->name, wanted->length - 1);
}

// Names that end with "/name" follow one another.
bool vw_name_index_find_ending(const struct vw_name_index *index, const char *name, size_t *place) {
    name = vw_view_name_of(name);
    const struct vw_indexed_name wanted = {.name = name, .length = strlen(name) + 1, .in_folder = true};
    size_t first = find_first(index, &wanted);
    if (first == index->count || !ends_with(&index->sorted[first], &wanted)) return false;
    if (first + 1 < index->count && ends_with(&index->sorted[first + 1], &wanted)) return false;
    *place = index->sorted[first].place;
    return true;
}

#include "support/cmocka_test.h"

#include "base/memory.h"

static struct owned {
    void *it;
    void (*release)(void *);
} * owned;
static size_t owned_count, owned_room;

void *test_own(void *it, void (*release)(void *)) {
    if (owned_count == owned_room) {
        owned_room = owned_room ? 2 * owned_room : 256;
        owned = realloc(owned, owned_room * sizeof *owned);
        assert_non_null(owned);
    }
    owned[owned_count++] = (struct owned){it, release};
    return it;
}

void *test_allocate(size_t count, size_t size) {
    void *zeros = vw_allocate(count, size);
    assert_non_null(zeros);
    return test_own(zeros, free);
}

void test_release(void *it) {
    for (size_t i = owned_count; i-- && it;) {
        if (owned[i].it != it) continue;
        void (*release)(void *) = owned[i].release;
        memmove(&owned[i], &owned[i + 1], (--owned_count - i) * sizeof *owned);
        release(it);
        return;
    }
    if (it) fail_msg("what is released is not the test's");
}

size_t test_owned(void) { return owned_count; }

// Releases the last objects first. An object leaves the list before it is released, which may fail the test.
void test_release_to(size_t count) {
    while (owned_count > count) {
        struct owned last = owned[--owned_count];
        last.release(last.it);
    }
    if (count) return;
    free(owned);
    owned = NULL;
    owned_room = 0;
}

void test_each_case(size_t count, void (*run)(size_t index)) {
    for (size_t i = 0, before = test_owned(); i < count; i++) {
        run(i);
        test_release_to(before);
    }
}

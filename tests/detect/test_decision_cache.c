// Decisions that are kept from run to run: used again, never believed when damaged, and never in the way.
#include "support/cmocka_test.h"

#include <dirent.h>

#include "base/file.h"
#include "base/memory.h"
#include "detect/decide.h"
#include "support/detection_cases.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"

struct decided {
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count;
};

static struct vw_scene *scene;
static enum vw_field planned_field;

// Decides for a run of another seed each time, which makes no difference. Returns the decision on sky.
static const struct vw_effect_decision *decide(struct decided *decided, uint32_t steps) {
    static uint64_t seed;
    struct vw_config config = vw_config_of_field(planned_field);
    config.seed = seed++;
    if (planned_field == VW_FIELD_HASH) config.rays = 16;
    config.pilot_steps = steps;
    strcpy(config.effects, "-unbounded,-appearance,-pose,-wide_box");
    ASSERT_OK(vw_effects_decide_cached(test_gpu(), scene, &config, decided->decisions, &decided->count));
    for (uint32_t i = 0; i < decided->count; i++)
        if (!strcmp(decided->decisions[i].name, "sky")) return &decided->decisions[i];
    fail_msg("no sky");
    return NULL;
}

// Returns the only file of decisions in the cache, owned by the caller; NULL when there is none.
static char *find_file(const char *folder) {
    char *found = NULL;
    DIR *opened = opendir(temporary_path(folder, "viewworth"));
    for (struct dirent *entry; opened && (entry = readdir(opened));) {
        if (strncmp(entry->d_name, "decisions-", 9)) continue;
        assert_null(found);
        found = vw_format_text("%s/viewworth/%s", folder, entry->d_name);
    }
    if (opened) closedir(opened);
    return found;
}

static int make_cache(void **state) {
    *state = temporary_folder_create();
    return setenv("XDG_CACHE_HOME", *state, 1);
}

static int remove_cache(void **state) {
    temporary_folder_remove(*state);
    return 0;
}

// Checks that two decisions agree, and tells whether one was kept: times that are measured are never the same twice.
static bool was_kept(const struct vw_effect_decision *a, const struct vw_effect_decision *b) {
    assert_true(test_same_bits(a->evidence, b->evidence));
    assert_int_equal(a->called_for, b->called_for);
    assert_string_equal(a->measured_on, b->measured_on);
    return test_same_bits(a->ms_per_step, b->ms_per_step);
}

TEST_WITHIN(decisions_are_kept, make_cache, remove_cache) {
    struct decided first, second, longer;
    const struct vw_effect_decision *measured = decide(&first, 8), *kept = decide(&second, 8);
    assert_true(isfinite(measured->evidence) && isfinite(measured->ms_per_step));
    assert_true(was_kept(measured, kept));
    char *path = find_file(*state);
    assert_non_null(path);
    assert_int_equal(remove(path), 0);
    free(path);
    assert_false(test_same_bits(decide(&longer, 9)->ms_per_step, measured->ms_per_step)); // another key
    assert_false(was_kept(measured, decide(&second, 8)));
    planned_field = VW_FIELD_SPLATS; // with pilots of its own
    assert_false(
        test_same_bits(decide(&longer, 8)->ms_per_step, second.decisions[kept - second.decisions].ms_per_step));
    planned_field = VW_FIELD_HASH;
}

// Every byte of the file counts, and so does its end.
TEST_WITHIN(damaged_files_are_none, make_cache, remove_cache) {
    struct decided first, second;
    const struct vw_effect_decision *measured = decide(&first, 8);
    char *path = find_file(*state), *file = NULL;
    size_t size_bytes;
    ASSERT_OK(vw_file_read(path, 1 << 20, (void **)&file, &size_bytes));
    for (size_t place = 0; place < size_bytes; place += size_bytes / 5) {
        char *damaged = vw_copy_text(file);
        damaged[place] ^= 1;
        ASSERT_OK(vw_file_write(path, damaged, size_bytes));
        free(damaged);
        assert_false(was_kept(measured, decide(&second, 8)));
    }
    ASSERT_OK(vw_file_write(path, file, size_bytes - 1));
    assert_false(was_kept(measured, decide(&second, 8)));
    ASSERT_OK(vw_file_write(path, file, size_bytes));
    assert_true(was_kept(measured, decide(&second, 8)));
    free(path);
    free(file);
}

TEST_WITHIN(a_cache_that_cannot_be_written_is_no_error, make_cache, remove_cache) {
    struct decided first, second;
    setenv("XDG_CACHE_HOME", "/dev/null", 1);
    const struct vw_effect_decision *measured = decide(&first, 8);
    assert_false(was_kept(measured, decide(&second, 8)));
}

static int open_scene(void **state) {
    (void)state;
    scene = detection_sky_scene();
    return 0;
}

static int close_all(void **state) {
    vw_scene_close(&scene);
    return test_gpu_close(state);
}

TEST_GROUP(open_scene, close_all)

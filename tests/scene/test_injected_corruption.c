// Defects injected in the photos of a scene that has none of its own: which photos, what happens to them, and that
// nothing else changes.
#include "support/cmocka_test.h"

#include "image/image.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS = 16, TRAIN = 12 }; // views 0 and 8 validate, 4 and 12 test

static int make_folder(void **state) {
    if (!(*state = temporary_folder_create())) return 1;
    tiny_scene_write(*state, &(struct tiny_scene){.count = PHOTOS});
    return 0;
}

static int remove_folder(void **state) {
    temporary_folder_remove(*state);
    return 0;
}

static struct vw_scene *open_corrupted(const char *folder, uint32_t corrupt) {
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = folder, .corrupt = corrupt));
    ASSERT_OK(vw_scene_decode_all(scene));
    return scene;
}

static bool same_pixels(const struct vw_view *a, const struct vw_view *b) {
    for (uint32_t i = 0; i < TINY_WIDTH_PX * TINY_HEIGHT_PX; i++) {
        float left[4], right[4];
        vw_image_pixel(&a->image, i % TINY_WIDTH_PX, i / TINY_WIDTH_PX, left);
        vw_image_pixel(&b->image, i % TINY_WIDTH_PX, i / TINY_WIDTH_PX, right);
        for (int c = 0; c < 4; c++)
            if (fabsf(left[c] - right[c]) > 1e-6f) return false; // 8 bit there and back
    }
    return true;
}

TEST_WITHIN(kinds_come_in_turn, make_folder, remove_folder) {
    struct vw_scene *scene = open_corrupted(*state, 10);
    static const char *const kinds[] = {"noise", "blur", "occluder", "exposure", "wrong_pose"};
    for (int i = 0; i < 5; i++) assert_int_equal(count_truth(scene, kinds[i]), 2);
    assert_int_equal(count_truth(scene, "clean"), PHOTOS - 10);
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split != VW_SPLIT_TRAIN) assert_string_equal(scene->views[v].ground_truth, "clean");
}

// Photos are of one colour, which a blur leaves as it is.
TEST_WITHIN(only_what_is_corrupted_changes, make_folder, remove_folder) {
    struct vw_scene *before = open_corrupted(*state, 0), *after = open_corrupted(*state, 5);
    assert_null(before->views[1].ground_truth);
    for (uint32_t v = 0; v < PHOTOS; v++) {
        const struct vw_view *a = &before->views[v], *b = &after->views[v];
        bool clean = !strcmp(b->ground_truth, "clean"), turned = !strcmp(b->ground_truth, "wrong_pose"),
             blurred = !strcmp(b->ground_truth, "blur");
        assert_int_equal(memcmp(a->camera_to_world, b->camera_to_world, sizeof a->camera_to_world) != 0, turned);
        assert_int_equal(same_pixels(a, b), clean || turned || blurred);
        assert_int_equal(memcmp(a->sha256, b->sha256, sizeof a->sha256) == 0, clean || turned);
        assert_memory_equal(&a->camera, &b->camera, sizeof a->camera);
        if (turned) check_turned(a, b);
    }
    assert_memory_not_equal(before->hash, after->hash, sizeof before->hash);
}

TEST_WITHIN(injection_is_repeatable_and_grows, make_folder, remove_folder) {
    struct vw_scene *first = open_corrupted(*state, 4), *second = open_corrupted(*state, 4),
                    *more = open_corrupted(*state, 7);
    assert_memory_equal(first->hash, second->hash, sizeof first->hash);
    assert_memory_not_equal(first->hash, more->hash, sizeof first->hash);
    for (uint32_t v = 0; v < PHOTOS; v++)
        if (strcmp(first->views[v].ground_truth, "clean") != 0)
            assert_string_equal(first->views[v].ground_truth, more->views[v].ground_truth);
}

static struct vw_scene *open_listed(const char *folder, uint32_t first) {
    static const char names[] =
        "images/02.png\nimages/03.png\nimages/05.png\nimages/06.png\nimages/07.png\nimages/09.png\nimages/10.png";
    AUTO_FREE char *list = vw_path_join(folder, "train.txt");
    tiny_scene_write(folder, &(struct tiny_scene){.first = first, .count = PHOTOS - first});
    ASSERT_OK(vw_file_write(list, names, sizeof names - 1));
    return tiny_scene_open(SCENE_PARAMS(.path = folder, .corrupt = 7, .train_list = list));
}

// The same photos elsewhere in the scene file, and trained on by a list, suffer the same.
TEST_WITHIN(injection_does_not_depend_on_places, make_folder, remove_folder) {
    struct vw_scene *scene = open_listed(*state, 0), *shifted = open_listed(*state, 2);
    for (uint32_t v = 2; v < PHOTOS; v++) {
        const struct vw_view *a = &scene->views[v], *b = &shifted->views[v - 2];
        assert_string_equal(a->name, b->name);
        assert_string_equal(a->ground_truth, b->ground_truth);
        assert_memory_equal(a->sha256, b->sha256, sizeof a->sha256); // noise and occluders among them
    }
    assert_int_equal(count_truth(shifted, "clean"), PHOTOS - 2 - 7);
}

// A scene of headers alone has the same ground_truths.
TEST_WITHIN(headers_tell_the_truth, make_folder, remove_folder) {
    struct vw_scene *whole = open_corrupted(*state, 6);
    struct vw_scene *headers = tiny_scene_open(SCENE_PARAMS(.path = *state, .corrupt = 6, .headers_only = true));
    for (uint32_t v = 0; v < PHOTOS; v++)
        assert_string_equal(whole->views[v].ground_truth, headers->views[v].ground_truth);
}

TEST_WITHIN(what_cannot_be_corrupted_is_refused, make_folder, remove_folder) {
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .corrupt = TRAIN + 1), VW_ERROR_USAGE, "--corrupt", "12");
    open_corrupted(*state, TRAIN);
    tiny_scene_refused(SCENE_PARAMS(.path = VW_SOURCE_FOLDER "/scenes/clean.json", .corrupt = 2, .headers_only = true),
                       VW_ERROR_USAGE, "--corrupt", "recipe");
}

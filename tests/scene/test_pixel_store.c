// Pixels are decoded when they are needed, from the files that were hashed, and live in a file without a name when they
// are more than the memory for them.
// wrap: fstatvfs
#include "support/cmocka_test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include "image/image.h"
#include "scene/photo_source.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS = 8, PHOTO_BYTES = TINY_WIDTH_PX * TINY_HEIGHT_PX * 4 };

static int make_folder(void **state) {
    char *folder = temporary_folder_create();
    *state = folder;
    tiny_scene_write(folder, &(struct tiny_scene){.count = PHOTOS});
    return setenv("XDG_CACHE_HOME", temporary_path(folder, "cache"), 1);
}

static int remove_folder(void **state) {
    vw_scene_set_memory(0);
    temporary_folder_remove(*state);
    return 0;
}

static struct vw_scene *open_in(const char *folder, uint64_t memory_bytes) {
    vw_scene_set_memory(memory_bytes);
    return tiny_scene_open(SCENE_PARAMS(.path = folder));
}

static uint32_t count_files(const char *folder) {
    DIR *files = opendir(folder);
    uint32_t count = 0;
    for (const struct dirent *file; files && (file = readdir(files));) count += file->d_name[0] != '.';
    if (files) closedir(files);
    return count;
}

TEST_WITHIN(pixels_are_there_only_once_they_are_asked_for, make_folder, remove_folder) {
    struct vw_scene *scene = open_in(*state, 0);
    const uint32_t wanted[] = {5, 2, 5};
    for (uint32_t v = 0; v < PHOTOS; v++) assert_null(scene->views[v].image.pixels);
    assert_int_equal(scene->views[0].image.width_px, TINY_WIDTH_PX); // the size is known without pixels
    ASSERT_OK(vw_scene_decode(scene, wanted, 3));
    for (uint32_t v = 0; v < PHOTOS; v++) assert_int_equal(scene->views[v].image.pixels != NULL, v == 2 || v == 5);
    assert_int_equal(scene->source->decoded_count, 2);
    void *pixels = scene->views[2].image.pixels;
    ASSERT_OK(vw_scene_decode_all(scene));
    assert_ptr_equal(scene->views[2].image.pixels, pixels);
    assert_int_equal(scene->source->decoded_count, PHOTOS);
}

TEST_WITHIN(the_file_has_the_pixels_that_memory_has, make_folder, remove_folder) {
    struct vw_scene *in_memory = open_in(*state, PHOTOS * PHOTO_BYTES),
                    *in_file = open_in(*state, PHOTOS * PHOTO_BYTES - 1);
    assert_null(in_memory->source->store.bytes);
    assert_non_null(in_file->source->store.bytes);
    assert_memory_equal(in_memory->hash, in_file->hash, VW_HASH_BYTES);
    ASSERT_OK(vw_scene_decode_all(in_memory));
    ASSERT_OK(vw_scene_decode_all(in_file));
    for (uint32_t v = 0; v < PHOTOS; v++) {
        const unsigned char *pixels = in_file->views[v].image.pixels, *first = in_file->source->store.bytes;
        assert_true(pixels >= first && pixels + PHOTO_BYTES <= first + in_file->source->store.size_bytes);
        assert_memory_equal(pixels, in_memory->views[v].image.pixels, PHOTO_BYTES);
    }
    assert_int_equal(count_files(temporary_path(*state, "cache/viewworth")), 0); // also while it is in use
}

TEST_WITHIN(injected_corruption_replaces_pixels_of_the_file, make_folder, remove_folder) {
    struct vw_scene *plain = open_in(*state, 1),
                    *corrupted = tiny_scene_open(SCENE_PARAMS(.path = *state, .corrupt = 1)); // by noise
    ASSERT_OK(vw_scene_decode_all(corrupted));
    ASSERT_OK(vw_scene_decode_all(plain));
    uint32_t differ = 0;
    for (uint32_t v = 0; v < PHOTOS; v++)
        differ += memcmp(plain->views[v].image.pixels, corrupted->views[v].image.pixels, PHOTO_BYTES) != 0;
    assert_int_equal(differ, 1);
}

TEST_WITHIN(a_disk_without_room_is_an_error, make_folder, remove_folder) {
    struct vw_scene *scene = NULL;
    struct rlimit kept, least;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &kept), 0);
    least = (struct rlimit){.rlim_cur = PHOTO_BYTES, .rlim_max = kept.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    vw_scene_set_memory(1);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &least), 0);
    enum vw_status status = vw_scene_open(SCENE_PARAMS(.path = *state), &scene);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &kept), 0);
    ASSERT_FAILS(status, VW_ERROR_IO, "cache/viewworth", "--memory");
}

static bool almost_full;
WRAPS(fstatvfs);

int __wrap_fstatvfs(int descriptor, struct statvfs *disk) {
    int failed = __real_fstatvfs(descriptor, disk);
    if (almost_full) disk->f_bavail = (64 << 20) / disk->f_frsize;
    return failed;
}

// The disk has the room, but then none for results.
TEST_WITHIN(the_last_of_a_disk_is_left_to_others, make_folder, remove_folder) {
    struct vw_pixel_store store = {0};
    vw_scene_set_memory(1);
    almost_full = true;
    enum vw_status status = vw_pixel_store_open(1 << 20, &store);
    almost_full = false;
    ASSERT_FAILS(status, VW_ERROR_IO, "cannot reserve 0.000977 GiB for pixels: No space left on device");
    ASSERT_OK(vw_pixel_store_open(1 << 20, &store));
    vw_pixel_store_close(&store);
}

TEST_WITHIN(another_file_than_was_hashed_is_refused, make_folder, remove_folder) {
    struct vw_scene *scene = open_in(*state, 0);
    const uint32_t replaced = 3, intact = 4;
    tiny_photo_write(temporary_path(*state, "images/03.png"), 11);
    ASSERT_OK(vw_scene_decode(scene, &intact, 1));
    ASSERT_FAILS(vw_scene_decode(scene, &replaced, 1), VW_ERROR_IO,
                 "images/03.png: changed since the scene was opened");
    assert_null(scene->views[replaced].image.pixels);
    tiny_photo_write(temporary_path(*state, "images/03.png"), 3); // restored
    ASSERT_OK(vw_scene_decode(scene, &replaced, 1));
}

TEST_WITHIN(a_file_that_cannot_be_decoded_is_an_error_when_it_is_needed, make_folder, remove_folder) {
    const char *path = temporary_path(*state, "images/03.png");
    const uint32_t broken = 3;
    size_t size_bytes = 0;
    AUTO_FREE void *bytes = temporary_read(path, &size_bytes);
    ASSERT_OK(vw_file_write(path, bytes, size_bytes - 20));
    struct vw_scene *scene = open_in(*state, 1);
    ASSERT_FAILS(vw_scene_decode(scene, &broken, 1), VW_ERROR_IO, "cannot decode the image");
}

TEST_WITHIN(photos_with_alpha_are_decoded_at_once, make_folder, remove_folder) {
    const float clear[TINY_WIDTH_PX * TINY_HEIGHT_PX * 4] = {0};
    ASSERT_OK(vw_image_save(temporary_path(*state, "images/01.png"), TINY_WIDTH_PX, TINY_HEIGHT_PX, 4, clear));
    struct vw_scene *scene = open_in(*state, 1);
    assert_true(scene->has_alpha);
    assert_non_null(scene->views[1].image.pixels);
    assert_null(scene->views[2].image.pixels);
}

TEST_WITHIN(reading_pixels_that_are_not_there_ends_the_program, make_folder, remove_folder) {
    struct vw_scene *scene = open_in(*state, 0);
    float rgba[4];
    int result = 0;
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        signal(SIGABRT, SIG_DFL);
        (void)!freopen("/dev/null", "w", stderr);
        vw_image_pixel(&scene->views[0].image, 0, 0, rgba);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &result, 0), child);
    assert_true(WIFSIGNALED(result) && WTERMSIG(result) == SIGABRT);
}

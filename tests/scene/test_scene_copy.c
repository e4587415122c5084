// A copy of a scene, read back by both of its formats: cameras, poses, splits, points and where photos see them, masks;
// names; what is refused. (What select makes of a run, and COLMAP of a copy, is in tests/cli/test_select_copy.sh and
// tests/cli/test_colmap_reads_copy.sh.)
#include "support/cmocka_test.h"

#include <sys/stat.h>
#include <unistd.h>

#include "base/hash.h"
#include "scene/formats/scene_copy.h"
#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS_MOST = 16 };

// A pose is turned into a quaternion and back, which takes some twenty roundings of 2^-53 of numbers up to 10.
static const double POSE_TOLERANCE = 1e-13;

static struct vw_scene *open_headers(const char *path, const char *format) {
    return tiny_scene_open(SCENE_PARAMS(.path = path, .format = format, .headers_only = true));
}

// Copies a scene. A train photo is kept if its letter in `chosen` is y. `sha256` is that of its first photo.
static enum vw_status copy(const struct vw_scene *scene, const char *chosen, const char *to, const char *sha256,
                           const struct vw_interrupt *interrupt) {
    struct vw_listed_photo photos[PHOTOS_MOST];
    assert_int_equal(strlen(chosen), scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++)
        photos[v] = (struct vw_listed_photo){scene->views[v].name, scene->views[v].split,
                                             scene->views[v].split == VW_SPLIT_TRAIN && chosen[v] == 'y',
                                             v == 0 ? sha256 : NULL};
    const struct vw_photo_list list = {
        .scene_path = scene->path, .photos = photos, .photo_count = scene->view_count, .to = to};
    return vw_scene_copy(&list, scene, interrupt);
}

static void check_same_file(const char *a, const char *b) {
    size_t size_a, size_b;
    AUTO_FREE void *bytes_a = temporary_read(a, &size_a), *bytes_b = temporary_read(b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
}

// Returns the only view whose name ends with that of a view of the scene, below its folder of photos.
static const struct vw_view *find(const struct vw_scene *copied, const char *name) {
    const struct vw_view *found = NULL;
    const char *slash = strchr(name, '/');
    size_t length = strlen(slash ? slash + 1 : name);
    for (uint32_t v = 0; v < copied->view_count; v++) {
        const char *own = copied->views[v].name;
        if (strlen(own) > length && !strcmp(own + strlen(own) - length, name + strlen(name) - length))
            found = &copied->views[v];
    }
    return found;
}

static void check_view(const struct vw_scene *scene, const struct vw_view *view, const struct vw_scene *copied,
                       const struct vw_view *again) {
    AUTO_FREE char *from = vw_path_join(scene->path, view->name), *to = vw_path_join(copied->path, again->name);
    assert_true(vw_camera_same(&view->camera, &again->camera));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            assert_true(fabs(view->camera_to_world[i][j] - again->camera_to_world[i][j]) <= POSE_TOLERANCE);
    assert_int_equal(view->has_mask, again->has_mask);
    check_same_file(from, to);
}

// Checks that both formats of the copy hold the kept photos as the scene has them, in their splits, and no others.
static void check_copy(const struct vw_scene *scene, const char *chosen, const char *to) {
    static const char *const formats[] = {"colmap", "transforms"};
    for (int f = 0; f < 2; f++) {
        const struct vw_scene *copied = open_headers(to, formats[f]);
        uint32_t kept = 0;
        for (uint32_t v = 0; v < scene->view_count; v++) {
            const struct vw_view *view = &scene->views[v], *again = find(copied, view->name);
            bool keeps = view->split == VW_SPLIT_VAL || view->split == VW_SPLIT_TEST ||
                         (view->split == VW_SPLIT_TRAIN && chosen[v] == 'y');
            assert_int_equal(keeps, again != NULL);
            if (!keeps) continue;
            check_view(scene, view, copied, again);
            if (f) assert_int_equal(view->split, again->split); // a COLMAP model has no splits
            kept++;
        }
        assert_int_equal(copied->view_count, kept);
    }
}

// ---- Cameras ----

static const char *const lenses[] = {
    "\"fl_x\": 9.1, \"fl_y\": 8.7, \"cx\": 4.3, \"cy\": 2.9,",
    "\"camera_model\": \"SIMPLE_RADIAL\", \"fl_x\": 9.1, \"k1\": -0.0123,",
    "\"camera_model\": \"OPENCV\", \"fl_x\": 9.1, \"k1\": 0.1, \"k2\": -0.02, \"p1\": 0.003, \"p2\": -0.004,",
    "\"camera_model\": \"OPENCV\", \"fl_x\": 9.1, \"k1\": 0.1, \"k2\": -0.02, \"k3\": 0.005,",
    "\"camera_model\": \"FULL_OPENCV\", \"fl_x\": 9.1, \"k1\": 0.1, \"k4\": 0.11, \"k5\": 0.01, \"k6\": 0.001,",
    "\"camera_model\": \"OPENCV_FISHEYE\", \"fl_x\": 4.1, \"k1\": 0.01, \"k2\": 0.02, \"k3\": 0.003, \"k4\": 0.0004,",
};

FOLDER_TEST(every_lens_is_read_back) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        AUTO_FREE char *folder = vw_format_text("%s/%zu", (const char *)*state, i);
        const char *to = temporary_path(folder, "copy");
        ASSERT_OK(vw_folder_create(folder));
        tiny_scene_write(folder, &(struct tiny_scene){.keys = lenses[i], .offset_world = {1, -2, 3}});
        const struct vw_scene *scene = open_headers(folder, NULL);
        ASSERT_OK(copy(scene, "nyynyyny", to, NULL, NULL));
        check_copy(scene, "nyynyyny", to);
    }
}

// Every frame has its own camera; the world is large.
FOLDER_TEST(several_cameras_and_masks_are_read_back) {
    const char *to = temporary_path(*state, "copy"), *path = tiny_scene_write(*state, &(struct tiny_scene){0});
    AUTO_FREE char *text = temporary_read(path, NULL);
    FILE *json = fopen(path, "w");
    assert_non_null(json);
    const char *rest = text;
    for (int i = 0; rest; i++) { // before each frame's file_path
        const char *next = strstr(rest, "\"file_path\"");
        fprintf(json, "%.*s", (int)(next ? next - rest : (long)strlen(rest)), rest);
        if (!next) break;
        fprintf(json, "%s%s\"file_path\"", lenses[i % 6], i % 2 ? "\"mask_path\": \"hide/all.png\", " : "");
        rest = next + strlen("\"file_path\"");
    }
    assert_int_equal(fclose(json), 0);
    tiny_photo_write(temporary_path(*state, "hide/all.png"), 15);
    const struct vw_scene *scene = open_headers(*state, "transforms");
    assert_true(scene->masked_view_count == 4);
    ASSERT_OK(copy(scene, "yyynyyyy", to, NULL, NULL));
    check_copy(scene, "yyynyyyy", to);
    check_same_file(temporary_path(to, "masks/01.png.png"), temporary_path(*state, "hide/all.png"));
    assert_false(vw_file_exists(temporary_path(to, "masks/00.png.png")));
}

// ---- Points ----

// Returns where a scene's view of that name sees the point at a place; false: nowhere.
static bool sees(const struct vw_scene *scene, uint32_t point, const char *name, float at_px[2]) {
    for (uint32_t t = 0; t < scene->points[point].track_count; t++) {
        const struct vw_track *track = &scene->tracks[scene->points[point].first_track + t];
        if (strcmp(scene->views[track->view].name, name) != 0) continue;
        at_px[0] = track->x_px;
        at_px[1] = track->y_px;
        return true;
    }
    return false;
}

// Photos 0, 1 and 2 of eight see points 0 and 1; 1 and 2 see point 2, and point 3, which photo 2 sees twice.
FOLDER_TEST(points_are_cut_to_what_kept_photos_see) {
    static const char *const names[DENSE_PHOTOS] = {"0.png", "1.png", "2.png", "s/3.png",
                                                    "4.png", "5.png", "6.png", "7.png"};
    struct colmap_test_model model = colmap_dense_model(names);
    memcpy(model.points[1].rgb, (const uint8_t[]){1, 254, 255}, sizeof model.points[1].rgb);
    model.points[0].track_count = 3;
    memcpy(model.points[0].tracks[2], (const uint32_t[]){12, 1}, sizeof model.points[0].tracks[2]);
    model.points[2] = (struct colmap_test_point){90, {1, 2, 3}, 0.5, {1, 2, 255}, 2, {{11, 0}, {12, 0}}};
    model.points[3] = (struct colmap_test_point){91, {3, 2, 1}, 0.5, {3, 2, 1}, 3, {{12, 0}, {12, 1}, {11, 1}}};
    model.point_count = 4;
    colmap_write_photos(*state, "images", names);
    colmap_write_binary(*state, "sparse/0", &model);
    const char *to = temporary_path(*state, "copy");
    const struct vw_scene *scene = open_headers(*state, "colmap"); // 0 validates, 4 tests
    assert_int_equal(scene->point_count, 4);
    ASSERT_OK(copy(scene, "nnyyyyyy", to, NULL, NULL)); // points 2 and 3 have one photo left
    check_copy(scene, "nnyyyyyy", to);
    const struct vw_scene *copied = open_headers(to, "colmap");
    assert_int_equal(copied->point_count, 2);
    for (uint32_t p = 0; p < 2; p++) {
        float before[2], after[2];
        assert_memory_equal(copied->points[p].position_world, scene->points[p].position_world, 3 * sizeof(double));
        assert_memory_equal(copied->points[p].rgb, scene->points[p].rgb, 3 * sizeof(float));
        assert_int_equal(copied->points[p].track_count, scene->points[p].track_count - 1);
        for (uint32_t v = 0; v < scene->view_count; v++)
            if (v != 1 && sees(scene, p, scene->views[v].name, before)) {
                assert_true(sees(copied, p, scene->views[v].name, after));
                assert_memory_equal(before, after, sizeof before);
            }
    }
    assert_int_equal(open_headers(to, "transforms")->point_count, 2); // by the model beside the file
}

// ---- Names ----

// Writes a scene of three photos of these names, of which the last one validates. A name without an extension has no
// file of its own.
static void write_named(const char *folder, const char *const names[3]) {
    char frames[3][300];
    for (int k = 0; k < 3; k++) {
        if (strchr(names[k], '.')) tiny_photo_write(temporary_path(folder, names[k]), (uint32_t)k);
        snprintf(frames[k], sizeof frames[k],
                 "{\"file_path\": \"%s\", \"transform_matrix\": [[1,0,0,%d],[0,1,0,0],[0,0,1,%d]]}", names[k], k,
                 k * k);
    }
    AUTO_FREE char *json = vw_format_text(
        "{\"fl_x\": 9, \"train_filenames\": [\"%s\", \"%s\"], \"val_filenames\": [\"%s\"], \"frames\": [%s, %s, %s]}",
        names[0], names[1], names[2], frames[0], frames[1], frames[2]);
    temporary_file(folder, "transforms.json", json);
}

FOLDER_TEST(folders_that_all_photos_share_are_left_out) {
    static const struct {
        const char *names[3], *copied[3];
    } cases[] = {
        {{"images/a.png", "images/b.png", "images/c.png"}, {"a.png", "b.png", "c.png"}},
        {{"x/images/s/a.png", "x/images/s/b.png", "x/images/s/c.png"}, {"s/a.png", "s/b.png", "s/c.png"}},
        {{"p/ab/a.png", "p/abc/a.png", "p/c.png"}, {"ab/a.png", "abc/a.png", "c.png"}},
        {{"images/a.png", "images2/a.png", "a.png"}, {"images/a.png", "images2/a.png", "a.png"}},
        {{"./=$(x) 'q'/a b.png", "./=$(x) 'q'/-c.png", "=$(x) 'q'/é.png"}, {"a b.png", "-c.png", "é.png"}},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        AUTO_FREE char *folder = vw_format_text("%s/%zu", (const char *)*state, i);
        const char *to = temporary_path(folder, "copy");
        ASSERT_OK(vw_folder_create(folder));
        write_named(folder, cases[i].names);
        ASSERT_OK(copy(open_headers(folder, NULL), "yyn", to, NULL, NULL));
        for (int k = 0; k < 3; k++) {
            AUTO_FREE char *name = vw_format_text("images/%s", cases[i].copied[k]);
            check_same_file(temporary_path(to, name), temporary_path(folder, cases[i].names[k]));
        }
        assert_int_equal(open_headers(to, "colmap")->view_count, 3);
        assert_int_equal(open_headers(to, "transforms")->view_count, 3);
    }
}

// A name without an extension is read with one.
FOLDER_TEST(two_photos_of_one_file_are_refused) {
    static const char *const names[3] = {"images/a.png", "images/a", "images/c.png"};
    const char *to = temporary_path(*state, "copy");
    write_named(*state, names);
    const struct vw_scene *scene = open_headers(*state, NULL);
    ASSERT_FAILS(copy(scene, "yyn", to, NULL, NULL), VW_ERROR_INPUT, "another file of the scene would be images/a.png");
    assert_false(vw_folder_exists(to));
    ASSERT_OK(copy(scene, "nyn", to, NULL, NULL));
    check_same_file(temporary_path(to, "images/a.png"), temporary_path(*state, "images/a.png"));
}

// ---- What is refused; nothing is left of it ----

static void check_nothing_left(const char *folder, const char *expected) {
    AUTO_FREE char *command = vw_format_text("ls -A '%s' | tr '\\n' ' '", folder);
    char listed[200] = "";
    FILE *list = popen(command, "r");
    assert_non_null(list);
    if (!fgets(listed, sizeof listed, list)) listed[0] = 0;
    pclose(list);
    assert_string_equal(listed, expected);
}

static bool always(void *context) { return context == NULL; }

FOLDER_TEST(a_failure_leaves_nothing) {
    const char *source = temporary_path(*state, "scene"), *to = temporary_path(*state, "here/copy"), *all = "yyyyyyyy";
    ASSERT_OK(vw_folder_create(source));
    tiny_scene_write(source, &(struct tiny_scene){0});
    const struct vw_scene *scene = open_headers(source, NULL);
    ASSERT_FAILS(copy(scene, all, to, NULL, NULL), VW_ERROR_IO, "here/copy: cannot make", "name one");
    ASSERT_OK(vw_folder_create(temporary_path(*state, "here")));
    ASSERT_FAILS(copy(scene, all, to, "00", NULL), VW_ERROR_INPUT, "images/00.png: not the file that was valued");
    const struct vw_interrupt interrupt = {always, NULL};
    ASSERT_FAILS(copy(scene, all, to, NULL, &interrupt), VW_ERROR_INTERRUPTED, "interrupted");
    check_nothing_left(temporary_path(*state, "here"), "");
    assert_int_equal(unlink(temporary_path(source, "images/06.png")), 0);
    assert_int_equal(symlink("/etc/passwd", temporary_path(source, "images/06.png")), 0);
    ASSERT_FAILS(copy(scene, all, to, NULL, NULL), VW_ERROR_INPUT, "images/06.png",
                 "leads out of the folder through a link");
    check_nothing_left(temporary_path(*state, "here"), "");
    ASSERT_OK(vw_folder_create(to)); // an empty folder is fine
    const struct kept_file whole = temporary_keep(temporary_path(source, "images/00.png"));
    uint8_t hash[VW_HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    vw_sha256(whole.bytes, whole.size_bytes, hash);
    vw_hash_to_hex(hash, hex);
    ASSERT_OK(copy(scene, "yyyyyyny", temporary_path(*state, "here/copy/"), hex, NULL));
    check_nothing_left(temporary_path(*state, "here"), "copy ");
    struct stat info;
    mode_t mask = umask(0);
    umask(mask);
    assert_int_equal(stat(to, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0777 & ~mask);
    ASSERT_FAILS(copy(scene, "yyyyyyny", to, NULL, NULL), VW_ERROR_USAGE, "here/copy: exists; name a new");
    ASSERT_FAILS(vw_scene_copy_check(temporary_file(*state, "file", ""), scene), VW_ERROR_USAGE, "file: exists");
    assert_int_equal(symlink("nowhere", temporary_path(*state, "link")), 0);
    ASSERT_FAILS(vw_scene_copy_check(temporary_path(*state, "link"), scene), VW_ERROR_USAGE, "link: exists");
}

FOLDER_TEST(a_scene_without_the_photo_or_without_files_is_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){0});
    const struct vw_scene *scene = open_headers(*state, NULL);
    const struct vw_listed_photo photos[] = {{"images/00.png", VW_SPLIT_VAL, false, NULL},
                                             {"images/99.png", VW_SPLIT_TRAIN, true, NULL}};
    struct vw_photo_list list = {
        .scene_path = *state, .photos = photos, .photo_count = 2, .to = temporary_path(*state, "copy")};
    ASSERT_FAILS(vw_scene_copy(&list, scene, NULL), VW_ERROR_INPUT, "it lacks images/99.png");
    const struct vw_scene *recipe = open_headers(VW_SOURCE_FOLDER "/scenes/clean.json", NULL);
    ASSERT_FAILS(vw_scene_copy(&list, recipe, NULL), VW_ERROR_USAGE, "a recipe has no photo files");
}

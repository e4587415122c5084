// Lists of chosen photos in the formats of scenes, and that they open again: splits that lists moved, paths, what is
// refused. (What select makes of whole runs is in tests/cli/test_select.sh.)
#include "support/cmocka_test.h"

#include <sys/stat.h>
#include <unistd.h>

#include <jansson.h>

#include "scene/formats/photo_list.h"
#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS_MOST = 16 };

#define HEADERS(...) SCENE_PARAMS(.headers_only = true, __VA_ARGS__)

// Writes the list of a scene as it is opened with these params. A train photo is chosen if its letter in `chosen` is y.
static enum vw_status write_list(const struct vw_scene_params *params, const char *chosen, const char *to,
                                 const char *format, bool opens) {
    struct vw_listed_photo photos[PHOTOS_MOST];
    struct vw_scene *scene = tiny_scene_open(params);
    const char *written = NULL;
    bool written_opens = !opens;
    assert_int_equal(strlen(chosen), scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++)
        photos[v] = (struct vw_listed_photo){scene->views[v].name, scene->views[v].split,
                                             scene->views[v].split == VW_SPLIT_TRAIN && chosen[v] == 'y'};
    const struct vw_photo_list list = {params->path, params->format, photos, scene->view_count, to};
    enum vw_status status = vw_photo_list_write(&list, &written, &written_opens);
    if (!status && format) assert_string_equal(written, format);
    if (!status) assert_int_equal(written_opens, opens);
    return status;
}

// Checks that such a list is refused.
static void check_not_written(const struct vw_scene_params *params, const char *chosen, const char *to,
                              enum vw_status status, const char *text) {
    ASSERT_FAILS(write_list(params, chosen, to, NULL, false), status, text);
}

// Checks the splits of the scene. `expected` has a word per view: its name and t(rain), v(al), T(est) or x(excluded).
static void check_scene(const struct vw_scene_params *params, const char *expected) {
    char text[1000] = "";
    struct vw_scene *scene = tiny_scene_open(params);
    for (uint32_t v = 0; v < scene->view_count; v++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s:%c", v > 0 ? " " : "", scene->views[v].name,
                 "tvTx"[scene->views[v].split]);
    assert_string_equal(text, expected);
}

static void check_text(const char *path, const char *expected) {
    AUTO_FREE void *text = temporary_read(path, NULL);
    assert_string_equal(text, expected);
}

// ---- transforms.json ------------------------------------------------------------------------------------------------

FOLDER_TEST(splits_of_the_file_are_kept) {
    const struct vw_scene_params params = {.path = *state, .headers_only = true};
    tiny_scene_write(*state, &(struct tiny_scene){
                                 .count = 6,
                                 .keys = "\"fl_x\": 7, \"val_filenames\": [\"./images/01.png\", \"images/01.png\"], "
                                         "\"test_filenames\": [], \"train_filenames\": [\"images/02.png\", "
                                         "\"images/05.png\", \"images/none.png\"],"});
    check_scene(&params,
                "images/00.png:x images/01.png:v images/02.png:t images/03.png:x images/04.png:x images/05.png:t");
    const char *train = temporary_file(*state, "train.txt", "images/00.png\nimages/03.png\n"); // lists win
    check_scene(HEADERS(.path = *state, .train_list = train),
                "images/00.png:t images/01.png:v images/02.png:x images/03.png:t images/04.png:x images/05.png:x");
    static const struct {
        const char *keys, *said;
    } cases[] = {
        {"\"fl_x\": 7, \"val_filenames\": \"images/01.png\",", "field val_filenames is not a list"},
        {"\"fl_x\": 7, \"train_filenames\": [\"images/01.png\", 3],", "field train_filenames: entry 1 is not a text"},
        {"\"fl_x\": 7, \"train_filenames\": [\"images/01.png\"], \"test_filenames\": [\"./images/01.png\"],",
         "images/01.png is in two splits, train_filenames and test_filenames"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = 6, .keys = cases[i].keys});
        tiny_scene_refused(&params, VW_ERROR_INPUT, "transforms.json", cases[i].said);
    }
}

// Splits that lists made hold in the file, without the lists.
FOLDER_TEST(transforms_keep_the_splits_of_lists) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 6});
    const char *val = temporary_file(*state, "val.txt", "01.png\n"),
               *test = temporary_file(*state, "test.txt", "04.png\n");
    const struct vw_scene_params lists = {.path = *state, .headers_only = true, .val_list = val, .test_list = test};
    const char *to = temporary_path(*state, "list.json");
    ASSERT_OK(write_list(&lists, "ynyyny", to, "transforms", true));
    check_scene(HEADERS(.path = to),
                "images/00.png:t images/01.png:v images/02.png:t images/03.png:t images/04.png:T images/05.png:t");
    check_not_written(&lists, "ynyyny", to, VW_ERROR_USAGE, "exists; name a new");
}

// With a file for each split, photos go to the file of their split, as long as all else in the files is the same.
FOLDER_TEST(three_files_hold_a_split_each) {
    AUTO_FREE char *scene = vw_path_join(*state, "a/b");
    ASSERT_OK(vw_folder_create(scene));
    tiny_scene_write(scene, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 4});
    tiny_scene_write(
        scene, &(struct tiny_scene){.file = "transforms_test.json", .first = 4, .count = 3}); // two of them validate
    const struct vw_scene_params params = {.path = scene, .headers_only = true};
    ASSERT_OK(write_list(&params, "nyynnnn", *state, "transforms", true));
    check_scene(HEADERS(.path = *state),
                "a/b/images/01.png:t a/b/images/02.png:t a/b/images/04.png:v a/b/images/05.png:v a/b/images/06.png:T");
    ASSERT_OK(write_list(&params, "nyynnnn", temporary_path(scene, "best.json"), "transforms",
                         true)); // they fit into one, too
    check_scene(HEADERS(.path = temporary_path(scene, "best.json")),
                "images/01.png:t images/02.png:t images/04.png:v images/05.png:v images/06.png:T");
    check_not_written(&params, "yyyynnn", *state, VW_ERROR_USAGE, "transforms_train.json: exists");
    check_not_written(&params, "yyyynnn", scene, VW_ERROR_USAGE, "read as another scene");
    check_not_written(&params, "yyyynnn", temporary_path(scene, "transforms.json"), VW_ERROR_USAGE, "another scene");

    check_not_written(&params, "yyyynnn", temporary_path(*state, "c.tsv"), VW_ERROR_USAGE,
                      "name a .json file, or a folder");
    const char *beside = temporary_path(*state, "c.d/");
    const char *val = temporary_file(*state, "val.txt", "00.png\n");
    ASSERT_OK(write_list(HEADERS(.path = scene, .val_list = val), "nyynnnn", beside, NULL, false));
    tiny_scene_write(
        scene, &(struct tiny_scene){.file = "transforms_test.json", .first = 4, .count = 3, .keys = "\"fl_x\": 3,"});
    check_not_written(&params, "yyyynnn", temporary_path(scene, "one.json"), VW_ERROR_INPUT, "name a folder");
    const char *mixed = temporary_path(*state, "mixed");
    const char *test = temporary_file(*state, "test.txt", "00.png\n06.png\n");
    check_not_written(HEADERS(.path = scene, .test_list = test), "nyyynnn", mixed, VW_ERROR_INPUT,
                      "without lists of splits");
    assert_false(vw_folder_exists(mixed)); // as it was not there before
    check_not_written(&params, "yyyynnn", temporary_path(*state, "p/q/r"), VW_ERROR_USAGE, "a folder that exists");
    assert_false(vw_folder_exists(temporary_path(*state, "p")));
}

// A way that starts anywhere leads to the photos, links followed.
FOLDER_TEST(paths_lead_from_the_list) {
    static const struct {
        const char *to, *path;
        bool opens;
    } cases[] = {
        {"s/s/t.json", "images/00.png", true},        {"s/t.json", "s/images/00.png", true},
        {"t.json", "s/s/images/00.png", true},        {"s/sb/t.json", "../s/images/00.png", false},
        {"s/s/in/t.json", "../images/00.png", false}, {"x/y/z/t.json", "../../../s/s/images/00.png", false},
        {"link/t.json", "../images/00.png", false},
    };
    AUTO_FREE char *scene = vw_path_join(*state, "s/s");
    ASSERT_OK(vw_folder_create(scene));
    tiny_scene_write(scene, &(struct tiny_scene){.count = 4, .name_prefix = "./images/"});
    const char *folders[] = {"s/sb", "s/s/in", "x/y/z"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(folders); i++)
        ASSERT_OK(vw_folder_create(temporary_path(*state, folders[i])));
    assert_int_equal(symlink("s/s/in", temporary_path(*state, "link")), 0);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const char *to = temporary_path(*state, cases[i].to);
        unlink(to);
        ASSERT_OK(write_list(HEADERS(.path = scene), "yyyy", to, NULL, cases[i].opens));
        AUTO_FREE void *text = temporary_read(to, NULL);
        AUTO_FREE char *wanted = vw_format_text("\"file_path\": \"%s%s\"", i == 0 ? "./" : "",
                                                cases[i].path); // untouched in the same folder
        if (!strstr(text, wanted)) fail_msg("%s: %s is not in %s", cases[i].to, wanted, (char *)text);
    }
    ASSERT_FAILS(write_list(HEADERS(.path = scene), "yyyy", temporary_path(*state, "no/t.json"), NULL, false),
                 VW_ERROR_USAGE, "name a folder that exists");
    ASSERT_OK(vw_folder_create(temporary_path(*state, "bad\xff")));
    ASSERT_OK(write_list(HEADERS(.path = scene), "yyyy", temporary_path(*state, "bad\xff/t.json"), NULL,
                         false)); // only the way down matters
}

// ---- PhotoTourism ---------------------------------------------------------------------------------------------------

static const char *const names[DENSE_PHOTOS] = {"p0.png", "p1.png", "p2.png", "p3.png",
                                                "p4.png", "p5.png", "p6.png", "sub/p1.png"};

static const char rows[] =
    "split\tid\tnote\tfilename\tdataset\r\ntest\t7.0\ta b\tp6.png\td\r\ntrain\t\t\tp1.png\td\r\n"
    "test\t\t\tgone.png\td\r\ntrain\t5\t=x\tp2.png\td\r\ntrain\t6\t\tnot there.png\td\r\ntest\t9\t\tp0.png\td\r\n";

FOLDER_TEST(a_tsv_holds_the_chosen_photos) {
    colmap_write_dense(*state, names, rows);
    const struct vw_scene_params params = {.path = *state, .headers_only = true};
    check_scene(
        &params,
        "dense/images/p0.png:T dense/images/p1.png:t dense/images/p2.png:t dense/images/p3.png:t dense/images/p4.png:t "
        "dense/images/p5.png:t dense/images/p6.png:v dense/images/sub/p1.png:t");
    const char *to = temporary_path(*state, "list.txt");
    ASSERT_OK(write_list(&params, "nynnyyny", to, "phototourism", false));
    check_text(
        to,
        "split\tid\tnote\tfilename\tdataset\ntest\t7.0\ta b\tp6.png\td\ntrain\t11\t\tp1.png\td\n" // with COLMAP's id
        "test\t\t\tgone.png\td\ntest\t9\t\tp0.png\td\ntrain\t14\t\tp4.png\td\ntrain\t15\t\tp5.png\td\ntrain\t17\t\tsub/"
        "p1.png\td\n");
    check_scene(
        HEADERS(.path = *state, .train_list = to),
        "dense/images/p0.png:T dense/images/p1.png:t dense/images/p2.png:x dense/images/p3.png:x dense/images/p4.png:t "
        "dense/images/p5.png:t dense/images/p6.png:v dense/images/sub/p1.png:t");
    check_not_written(&params, "nynnyyny", to, VW_ERROR_USAGE, "exists; name a new");
    assert_int_equal(rename(to, temporary_path(*state, "splits.tsv")), 0); // in the place of the scene's own
    check_scene(
        HEADERS(.path = *state, .pool = "list"),
        "dense/images/p0.png:T dense/images/p1.png:t dense/images/p2.png:x dense/images/p3.png:x dense/images/p4.png:t "
        "dense/images/p5.png:t dense/images/p6.png:v dense/images/sub/p1.png:t");
    check_not_written(&params, "nynnyyny", temporary_path(*state, "list.tsv"), VW_ERROR_USAGE, "may have only one TSV");
}

// Photos that lists move from one split to another: none trains that validates or tests.
FOLDER_TEST(a_tsv_keeps_the_splits_of_lists) {
    colmap_write_dense(*state, names, rows);
    const char *train = temporary_file(*state, "train.txt", "p0.png\np2.png\np3.png\n"),
               *val = temporary_file(*state, "val.txt", "p1.png\n");
    const char *to = temporary_path(*state, "list.txt");
    ASSERT_OK(write_list(HEADERS(.path = *state, .train_list = train, .val_list = val), "ynnynnnn", to, NULL, false));
    check_text(
        to,
        "split\tid\tnote\tfilename\tdataset\ntest\t7.0\ta b\tp6.png\td\ntest\t\t\tp1.png\td\ntest\t\t\tgone.png\td\n"
        "train\t9\t\tp0.png\td\ntrain\t13\t\tp3.png\td\n");
}

FOLDER_TEST(a_tsv_serves_as_a_list) {
    colmap_write_dense(*state, names, rows);
    const char *tsv =
        temporary_file(*state, "lists/a.tsv", "filename\tsplit\np3.png\ttest\np4.png\ttrain\np5.png\ttrain\n");
    const char *none = temporary_file(*state, "lists/b.tsv", "filename\tsplit\np4.png\ttrain\n");
    const char *unknown = temporary_file(*state, "lists/c.tsv", "filename\tsplit\np4.png\ttrain\np9.png\ttrain\n");
    check_scene(
        HEADERS(.path = *state, .train_list = tsv, .val_list = tsv),
        "dense/images/p0.png:T dense/images/p1.png:x dense/images/p2.png:x dense/images/p3.png:v dense/images/p4.png:t "
        "dense/images/p5.png:t dense/images/p6.png:x dense/images/sub/p1.png:x");
    tiny_scene_refused(HEADERS(.path = *state, .test_list = none), VW_ERROR_INPUT, "b.tsv", "no row for --test");
    tiny_scene_refused(HEADERS(.path = *state, .train_list = unknown), VW_ERROR_INPUT, "c.tsv:3", "p9.png");
}

// ---- COLMAP, and no scene -------------------------------------------------------------------------------------------

// Names as the model spells them, also where another folder has the same.
FOLDER_TEST(an_image_list_spells_names_as_the_model_does) {
    struct colmap_test_model model = colmap_test_scene(*state);
    model.images[1].name = "sub/a.png";
    tiny_photo_write(temporary_file(*state, "images/sub/a.png", ""), 9);
    colmap_write_binary(*state, "sparse/0", &model);
    const char *val = temporary_file(*state, "val.txt", "sub/c d.png\n"), *to = temporary_path(*state, "list.txt");
    const struct vw_scene_params params = {.path = *state, .headers_only = true, .val_list = val};
    check_scene(&params, "images/a.png:t images/sub/a.png:t images/sub/c d.png:v");
    ASSERT_OK(write_list(&params, "yyn", to, "colmap", false));
    check_text(to, "a.png\nsub/a.png\n");
    check_scene(HEADERS(.path = *state, .val_list = val, .train_list = to),
                "images/a.png:t images/sub/a.png:t images/sub/c d.png:v");
    const struct vw_listed_photo gone[] = {{"images/a.png", VW_SPLIT_TRAIN, true},
                                           {"images/gone.png", VW_SPLIT_VAL, false}};
    const struct vw_photo_list list = {*state, NULL, gone, 2, temporary_path(*state, "gone.txt")};
    const char *format = NULL;
    bool opens = false;
    ASSERT_FAILS(vw_photo_list_write(&list, &format, &opens), VW_ERROR_INPUT, "it lacks images/gone.png");
}

// A folder that holds transforms.json is read as that format before all others, so lists of other formats must not take
// its name.
FOLDER_TEST(lists_of_other_formats_leave_the_scene_as_it_is) {
    static const char *const taken[] = {"transforms.json", "transforms_train.json", "transforms_val.json",
                                        "transforms_test.json"};
    struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    AUTO_FREE char *tourism = vw_path_join(*state, "tourism");
    colmap_write_dense(tourism, names, rows);
    for (size_t i = 0; i < VW_ARRAY_COUNT(taken); i++) {
        const struct vw_scene_params colmap = {.path = *state, .headers_only = true};
        check_not_written(&colmap, "yyn", temporary_path(*state, taken[i]), VW_ERROR_USAGE, "another scene");
        ASSERT_FAILS(write_list(HEADERS(.path = tourism), "nynnyyny", temporary_path(tourism, taken[i]), NULL, false),
                     VW_ERROR_USAGE, "another scene");
    }
    const char *elsewhere =
        temporary_path(*state, "tourism/transforms.json"); // not the folder of the scene that is listed
    ASSERT_OK(write_list(HEADERS(.path = *state), "yyn", elsewhere, "colmap", false));
}

// A list is whole or absent, wherever memory runs out.
static size_t allocations_left;
static void *allocate_some(size_t size_bytes) {
    return allocations_left && allocations_left-- ? malloc(size_bytes) : NULL;
}

FOLDER_TEST(transforms_are_whole_or_not_there) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 2});
    const struct vw_listed_photo photos[] = {{"images/00.png", VW_SPLIT_TRAIN, true},
                                             {"images/01.png", VW_SPLIT_TRAIN, true}};
    const struct vw_photo_list list = {
        .scene_path = *state, .photos = photos, .photo_count = 2, .to = temporary_path(*state, "l.json")};
    const char *format = NULL;
    size_t shortages = 0, size_bytes = 0;
    AUTO_FREE void *text = NULL;
    bool opens = false;
    enum vw_status status = VW_ERROR_MEMORY;
    for (; status && shortages < 100000; shortages++) {
        json_set_alloc_funcs(allocate_some, free);
        allocations_left = shortages;
        status = vw_photo_list_write(&list, &format, &opens);
        json_set_alloc_funcs(malloc, free);
        assert_true(vw_file_exists(list.to) == !status);
    }
    assert_true(shortages > 10); // that many at least are made
    ASSERT_OK(status);
    ASSERT_OK(vw_file_read(list.to, 1 << 20, &text, &size_bytes));
    ASSERT_OK(vw_photo_list_write(
        &(struct vw_photo_list){
            .scene_path = *state, .photos = photos, .photo_count = 2, .to = temporary_path(*state, "whole.json")},
        &format, &opens));
    check_text(temporary_path(*state, "whole.json"), text);
}

FOLDER_TEST(names_unfit_for_lists_are_refused) {
    static const char *const bad[] = {"two\nlines", "a\rb", " a", "a ", "\ta", "", "a\xff"};
    const struct vw_listed_photo good[] = {
        {"=a, \"b\"", VW_SPLIT_TRAIN, true}, {"c", VW_SPLIT_TRAIN, false}, {"é/d e", VW_SPLIT_TRAIN, true}};
    struct vw_photo_list list = {.photos = good, .photo_count = 3, .to = temporary_path(*state, "list.txt")};
    const char *format = NULL;
    bool opens = true;
    ASSERT_OK(vw_photo_list_write(&list, &format, &opens));
    assert_string_equal(format, "text");
    assert_false(opens);
    check_text(list.to, "=a, \"b\"\né/d e\n");
    ASSERT_FAILS(vw_photo_list_write(&list, &format, &opens), VW_ERROR_USAGE, "exists; name a new");
    list.to = temporary_path(*state, "bad.txt");
    for (size_t i = 0; i < VW_ARRAY_COUNT(bad); i++) {
        const struct vw_listed_photo photos[] = {{"fine", VW_SPLIT_TRAIN, true}, {bad[i], VW_SPLIT_TRAIN, true}};
        list.photos = photos;
        list.photo_count = 2;
        ASSERT_FAILS(vw_photo_list_write(&list, &format, &opens), VW_ERROR_INPUT, "photo 1");
        assert_false(vw_file_exists(list.to));
    }
    assert_int_equal(symlink("nowhere", temporary_path(*state, "link")), 0);
    list = (struct vw_photo_list){.photos = good, .photo_count = 3, .to = temporary_path(*state, "link")};
    ASSERT_FAILS(vw_photo_list_write(&list, &format, &opens), VW_ERROR_USAGE,
                 "exists; name a new"); // also a link to nothing
}

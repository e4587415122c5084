// Lists of chosen photos, and that scenes take them: splits that lists moved, what is refused. (What select makes of
// whole runs is in tests/cli/test_select.sh.)
#include "support/cmocka_test.h"

#include <sys/stat.h>
#include <unistd.h>

#include "scene/formats/photo_list.h"
#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS_MOST = 16 };

#define HEADERS(...) SCENE_PARAMS(.headers_only = true, __VA_ARGS__)

// Writes the list of a scene as it is opened with these params. A train photo is chosen if its letter in `chosen` is y.
static enum vw_status write_list(const struct vw_scene_params *params, const char *chosen, const char *to) {
    struct vw_listed_photo photos[PHOTOS_MOST];
    struct vw_scene *scene = tiny_scene_open(params);
    assert_int_equal(strlen(chosen), scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++)
        photos[v] = (struct vw_listed_photo){scene->views[v].name, scene->views[v].split,
                                             scene->views[v].split == VW_SPLIT_TRAIN && chosen[v] == 'y'};
    return vw_photo_list_write(&(struct vw_photo_list){params->path, photos, scene->view_count, to});
}

static void check_not_written(const struct vw_scene_params *params, const char *chosen, const char *to,
                              enum vw_status status, const char *text) {
    ASSERT_FAILS(write_list(params, chosen, to), status, text);
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

// ---- Splits of transforms.json -------------------------------------------------------------------------------------

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
    const char *to = temporary_path(*state, "lists/list.tsv");
    ASSERT_OK(vw_folder_create(temporary_path(*state, "lists")));
    ASSERT_OK(write_list(&params, "nynnyyny", to));
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
    check_not_written(&params, "nynnyyny", temporary_path(*state, "another.tsv"), VW_ERROR_USAGE,
                      "may have only one TSV");
}

// Photos that lists move from one split to another: none trains that validates or tests.
FOLDER_TEST(a_tsv_keeps_the_splits_of_lists) {
    colmap_write_dense(*state, names, rows);
    const char *train = temporary_file(*state, "train.txt", "p0.png\np2.png\np3.png\n"),
               *val = temporary_file(*state, "val.txt", "p1.png\n");
    const char *to = temporary_path(*state, "lists/list.tsv");
    ASSERT_OK(vw_folder_create(temporary_path(*state, "lists")));
    ASSERT_OK(write_list(HEADERS(.path = *state, .train_list = train, .val_list = val), "ynnynnnn", to));
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

// ---- Names ----------------------------------------------------------------------------------------------------------

FOLDER_TEST(names_unfit_for_lists_are_refused) {
    static const char *const bad[] = {"two\nlines", "a\rb", " a", "a ", "\ta", "", "a\xff"};
    const struct vw_listed_photo good[] = {
        {"=a, \"b\"", VW_SPLIT_TRAIN, true}, {"c", VW_SPLIT_TRAIN, false}, {"é/d e", VW_SPLIT_TRAIN, true}};
    struct vw_photo_list list = {.photos = good, .photo_count = 3, .to = temporary_path(*state, "list.txt")};
    ASSERT_OK(vw_photo_list_write(&list));
    check_text(list.to, "=a, \"b\"\né/d e\n");
    ASSERT_FAILS(vw_photo_list_write(&list), VW_ERROR_USAGE, "exists; name a new");
    list.to = temporary_path(*state, "bad.txt");
    for (size_t i = 0; i < VW_ARRAY_COUNT(bad); i++) {
        const struct vw_listed_photo photos[] = {{"fine", VW_SPLIT_TRAIN, true}, {bad[i], VW_SPLIT_TRAIN, true}};
        list.photos = photos;
        list.photo_count = 2;
        ASSERT_FAILS(vw_photo_list_write(&list), VW_ERROR_INPUT, "photo 1");
        assert_false(vw_file_exists(list.to));
    }
    assert_int_equal(symlink("nowhere", temporary_path(*state, "link.txt")), 0);
    list = (struct vw_photo_list){.photos = good, .photo_count = 3, .to = temporary_path(*state, "link.txt")};
    ASSERT_FAILS(vw_photo_list_write(&list), VW_ERROR_USAGE,
                 "exists; name a new"); // also a link to nothing
}

FOLDER_TEST(other_extensions_are_refused) {
    const struct vw_listed_photo photo = {"a", VW_SPLIT_TRAIN, true};
    struct vw_photo_list list = {.photos = &photo, .photo_count = 1};
    static const char *const others[] = {"list", "list.json", "list.csv", "txt"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(others); i++) {
        list.to = temporary_path(*state, others[i]);
        ASSERT_FAILS(vw_photo_list_write(&list), VW_ERROR_USAGE, "takes a file of names (.txt)");
    }
    list.to = temporary_path(*state, "list.tsv");
    ASSERT_FAILS(vw_photo_list_write(&list), VW_ERROR_USAGE, "only a PhotoTourism scene has a TSV");
}

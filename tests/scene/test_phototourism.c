// PhotoTourism folders, which format a folder is read as, and points beside another scene file.
#include "support/cmocka_test.h"

#include <unistd.h>

#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static const char *const names[DENSE_PHOTOS] = {"p0.png", "p1.png", "p2.png", "p3.png",
                                                "p4.png", "p5.png", "p6.png", "p7.png"};

static const char rows[] =
    "id\tsplit\tfilename\n3.0\ttest\tp6.png\n\ttest\tp1.png\n9\ttest\tgone.png\n\ttrain\tp0.png\n4\ttest\tp4.png\n"
    "8\ttrain\tgone too.png\n1\ttrain\tp2.png\n";

FOLDER_TEST(splits_come_from_the_tsv) {
    colmap_write_dense(*state, names, rows);
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_string_equal(scene->format, "phototourism");
    assert_string_equal(scene->views[1].name, "dense/images/p1.png");
    check_splits(scene, "tvttTtvt"); // test rows in file order: p6 and p1 validate, p4 tests
    check_note(scene, "2 of 7 TSV rows skipped (1 of them test)");
    check_note(scene, "gone.png");
    check_note(scene, "2 TSV rows have no id");
    check_note(scene, "3 registered photos are not in the TSV and are train photos");
    assert_int_equal(scene->point_count, 2);
    assert_int_equal(scene->track_count, 5);
    assert_near(scene->views[3].camera_to_world[0][3], 3, 1e-12);
}

FOLDER_TEST(pool_list_excludes_unlisted_photos) {
    colmap_write_dense(*state, names, rows);
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .pool = "list"));
    check_splits(scene, "tvtxTxvx");
    check_note(scene, "3 registered photos are not in the TSV and are excluded");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .pool = "all")), "tvttTtvt");
    const char *train = temporary_file(*state, "train.txt", "p3.png\np5.png\n"); // lists win, also over the pool
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .pool = "list", .train_list = train)), "xvxtTtvx");
}

FOLDER_TEST(a_tsv_without_test_rows_is_split_by_index) {
    colmap_write_dense(*state, names, "filename\tsplit\np0.png\ttrain\np2.png\ttrain\np5.png\ttrain\np7.png\ttrain\n");
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    check_splits(scene, "vtttTttt");
    check_note(scene, "no test row");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .pool = "list")),
                 "vxtxxtxt"); // every eighth of those listed
}

FOLDER_TEST(bad_scenes_are_refused) {
    const struct vw_scene_params params = {.path = *state, .format = "phototourism"};
    colmap_write_dense(*state, names, "filename\tsplit\np0.png\tval\n");
    tiny_scene_refused(&params, VW_ERROR_INPUT, "splits.tsv:2", "neither train nor test");
    temporary_file(*state, "splits.tsv", rows);
    temporary_file(*state, "other.tsv", "name\tscore\n"); // another kind of TSV is nobody's business
    tiny_scene_open(&params);
    temporary_file(*state, "other.tsv", "filename\tsplit\n");
    tiny_scene_refused(&params, VW_ERROR_INPUT, *state, "2 TSV files");
    unlink(temporary_path(*state, "other.tsv"));
    unlink(temporary_path(*state, "splits.tsv"));
    tiny_scene_refused(&params, VW_ERROR_INPUT, *state, "no TSV");
    temporary_file(*state, "splits.tsv", rows);
    unlink(temporary_path(*state, "dense/sparse/images.txt"));
    tiny_scene_refused(&params, VW_ERROR_INPUT, "dense/sparse", "the COLMAP model is not complete");
    unlink(temporary_path(*state, "dense/sparse/cameras.txt"));
    unlink(temporary_path(*state, "dense/sparse/points3D.txt"));
    tiny_scene_refused(&params, VW_ERROR_INPUT, "dense/sparse", "no COLMAP model");
}

// A TSV that links out of the folder is not read, not even to see what it is.
FOLDER_TEST(the_tsv_stays_in_the_folder) {
    AUTO_FOLDER char *elsewhere = temporary_folder_create();
    colmap_write_dense(*state, names, rows);
    assert_int_equal(rename(temporary_path(*state, "splits.tsv"), temporary_path(elsewhere, "a.tsv")), 0);
    assert_int_equal(symlink(temporary_path(elsewhere, "a.tsv"), temporary_path(*state, "splits.tsv")), 0);
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .format = "phototourism"), VW_ERROR_INPUT, "no TSV");
}

// ---- Precedence -----------------------------------------------------------------------------------------------------

// Writes transforms.json with the cameras of colmap_dense_model(), moved by `shift` and rolled by `turn`.
static void write_transforms(const char *folder, double focal_px, double shift, double turn) {
    char *json = vw_format_text("{\"fl_x\": %.17g, \"frames\": [", focal_px);
    for (uint32_t i = 0; i < DENSE_PHOTOS; i++) {
        char *longer = vw_format_text("%s%s{\"file_path\": \"images/p%u\", \"transform_matrix\": "
                                      "[[%.17g,%.17g,0,%.17g],[%.17g,%.17g,0,0],[0,0,1,0],[0,0,0,1]]}",
                                      json, i ? "," : "", i, cos(turn), -sin(turn), i + shift, sin(turn), cos(turn));
        free(json);
        json = longer;
    }
    AUTO_FREE char *whole = vw_format_text("%s]}", json);
    temporary_file(folder, "transforms.json", whole);
    free(json);
}

static void check_format(const char *folder, const char *asked, const char *got) {
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = folder, .format = asked, .headers_only = true));
    assert_string_equal(scene->format, got);
}

FOLDER_TEST(formats_have_a_precedence) {
    struct colmap_test_model model = colmap_dense_model(names);
    colmap_write_dense(*state, names, rows);
    colmap_write_photos(*state, "images", names);
    colmap_write_binary(*state, "sparse/0", &model);
    write_transforms(*state, 7, 0, 0);
    check_format(*state, NULL, "transforms");
    check_format(*state, "phototourism", "phototourism");
    check_format(*state, "colmap", "colmap");
    unlink(temporary_path(*state, "transforms.json"));
    check_format(*state, NULL, "phototourism");
    unlink(temporary_path(*state, "splits.tsv"));
    check_format(*state, NULL, "colmap");
}

// ---- Points beside transforms.json ----------------------------------------------------------------------------------

static struct vw_scene *open_with_points(const char *folder, double focal_px, double shift, double turn) {
    struct colmap_test_model model = colmap_dense_model(names);
    colmap_write_photos(folder, "images", names);
    colmap_write_text(folder, "sparse/0", &model);
    write_transforms(folder, focal_px, shift, turn);
    return tiny_scene_open(SCENE_PARAMS(.path = folder));
}

FOLDER_TEST(points_are_evidence) {
    struct vw_scene *scene = open_with_points(*state, 7, 1e-4, 1e-4);
    assert_string_equal(scene->format, "transforms");
    assert_int_equal(scene->point_count, 2);
    assert_near(scene->points[1].position_world[2], -20, 1e-12);
    assert_int_equal(scene->tracks[scene->points[1].first_track + 2].view, 2);
    assert_int_equal(scene->note_count, 1);
    assert_string_equal(scene->notes[0], "read as transforms; --format colmap fits, too");
}

FOLDER_TEST(points_of_other_cameras_are_no_evidence) {
    struct vw_scene *scene = open_with_points(*state, 7, 0.1, 0);
    assert_int_equal(scene->point_count, 0);
    check_note(scene, "its camera of images/p0 differs");
    assert_int_equal(open_with_points(*state, 7.1, 0, 0)->point_count, 0);
    assert_int_equal(open_with_points(*state, 7, 0, 0.01)->point_count, 0);
}

FOLDER_TEST(points_of_other_photos_are_no_evidence) {
    struct colmap_test_model model = colmap_dense_model(names);
    for (uint32_t i = 1; i < DENSE_PHOTOS; i++) model.images[i].name = names[i - 1]; // p7 is in the model no more
    model.images[0].name = "other.png";
    for (uint32_t i = 0; i < DENSE_PHOTOS; i++) model.images[i].translation[0] = i ? -(double)(i - 1) : -100;
    colmap_write_photos(*state, "images", names);
    colmap_write_text(*state, "sparse/0", &model);
    write_transforms(*state, 7, 0, 0);
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_int_equal(scene->point_count,
                     1); // p0 alone sees the first, p0 and p1 the second: image 10 is not in the scene
    for (uint32_t i = 0; i < DENSE_PHOTOS; i++)
        model.images[i].name = &"x0.png\0x1.png\0x2.png\0x3.png\0x4.png\0x5.png\0x6.png\0x7.png"[7 * i];
    colmap_write_text(*state, "sparse/0", &model);
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_int_equal(scene->point_count, 0);
    check_note(scene, "other photos");
}

// A broken model is refused also where only its points would be used.
FOLDER_TEST(broken_points_are_refused) {
    open_with_points(*state, 7, 0, 0);
    temporary_file(*state, "sparse/0/points3D.txt", "1 2 3 nan 0 0 0 0\n");
    tiny_folder_refused(*state, "points3D.txt");
}

FOLDER_TEST(downscale_moves_tracks) {
    struct vw_scene *scene = open_with_points(*state, 7, 0, 0);
    float x_px = scene->tracks[0].x_px, y_px = scene->tracks[0].y_px;
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .downscale = 4)); // 8 x 6 becomes 2 x 1
    assert_near(scene->tracks[0].x_px, x_px / 4, 1e-6);
    assert_near(scene->tracks[0].y_px, y_px / 6, 1e-6);
}

// ---- Real data ------------------------------------------------------------------------------------------------------

TEST(sacre_coeur_is_read) {
    const char *path = real_scene_path("sacre_coeur");
    if (!path) skip();
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = path, .format = "phototourism"));
    assert_int_equal(scene->view_count, 11);
    assert_int_equal(scene->split_count[VW_SPLIT_TRAIN], 9);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 1);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (strstr(scene->views[v].name, "10265353_3838484249.jpg"))
            assert_int_equal(scene->views[v].split, VW_SPLIT_VAL); // the first test row
        if (strstr(scene->views[v].name, "93341989_396310999.jpg"))
            assert_int_equal(scene->views[v].split, VW_SPLIT_TEST);
    }
    assert_true(scene->point_count > 1000);
    scene = tiny_scene_open(SCENE_PARAMS(.path = path)); // transforms.json wins; sparse/ has its cameras
    assert_string_equal(scene->format, "transforms");
    assert_int_equal(scene->point_count, 1645);
}

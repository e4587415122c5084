// The laboratory's copies of photos: each kind is made, and those with the same pixels and the same pose are found.
#include "support/cmocka_test.h"

#include "lab/copied_photos.h"
#include "support/synthetic_scene.h"

TEST(each_kind_is_made) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 2, .val_views = 1, .width_px = 64, .height_px = 48});
    for (uint32_t i = 0; i < vw_copying_count; i++) {
        const struct vw_copying *copying = &vw_copyings[i];
        struct vw_view copy;
        ASSERT_OK(vw_copy_photo(&scene->views[1], copying, &copy));
        double scale = (1 - copying->crop + copying->border) / (copying->halved ? 2 : 1);
        assert_int_equal(copy.image.width_px, lrint(64 * scale));
        assert_int_equal(copy.image.height_px, lrint(48 * scale));
        uint32_t hidden = 0, columns = copy.image.width_px;
        const uint8_t *pixels = copy.image.pixels;
        for (uint32_t x = 0; x < columns; x++)
            hidden += !copying->jpeg && (copy.mask[x] == VW_MASK_HIDE || pixels[4 * x + 3] == 0);
        assert_int_equal(hidden, ceil((copying->masked + copying->clear) * columns));
        vw_copied_photo_clear(&copy);
    }
}

TEST(copies_are_counted) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 2, .val_views = 1, .width_px = 64, .height_px = 48});
    struct vw_copies_found found;
    ASSERT_OK(vw_find_copies(scene, NULL, &found));
    assert_true(found.photos == 3 && found.copies == 0 && found.found == 0 && found.pairs == 3 && found.wrong == 0);
    ASSERT_OK(vw_find_copies(scene, &vw_copyings[0], &found));
    assert_true(found.photos == 3 && found.copies == 3 && found.found == 3 && found.wrong == 0);
    ASSERT_OK(vw_find_copies(scene, &(struct vw_copying){.name = "black", .gain = 1e-9}, &found));
    assert_true(found.copies == 3 && found.found == 0);
    scene->views[2].split = VW_SPLIT_EXCLUDED;
    ASSERT_OK(vw_find_copies(scene, &vw_copyings[0], &found));
    assert_true(found.photos == 2 && found.copies == 2 && found.found == 2 && found.pairs == 1);
}

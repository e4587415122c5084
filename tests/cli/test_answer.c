// The last lines of value: the verdict, the advice, and the command that comes next.
#include "support/ledger_fixture.h"

#include "cli/output/results.h"
#include "support/printed.h"
#include "support/temporary_folder.h"

// Photos of a folder, with advice and score; NaN: none.
static const struct {
    const char *name;
    enum vw_advice_word advice;
    const char *reason;
    double score;
} photos[] = {
    {"images/a.jpg", VW_ADVICE_KEEP, "helps", 1.5},    {"images/b.jpg", VW_ADVICE_UNCLEAR, "within noise", 0.1},
    {"images/c.jpg", VW_ADVICE_KEEP, "helps", 2.5},    {"images/d.jpg", VW_ADVICE_LOOK, "exposure", -3},
    {"images/e.jpg", VW_ADVICE_KEEP, "lone view", -1}, {"images/f.jpg", VW_ADVICE_UNCLEAR, "duplicate", NAN},
    {"images/n.jpg", VW_ADVICE_DROP, "too dark", NAN}, {"images/m.jpg", VW_ADVICE_DROP, "too dark", 0.3},
    {"images/l.jpg", VW_ADVICE_DROP, "too dark", NAN}, {"images/k.jpg", VW_ADVICE_DROP, "too dark", 0.2},
    {"images/j.jpg", VW_ADVICE_DROP, "too dark", 0.3}, {"images/g.jpg", VW_ADVICE_KEEP, "helps", 0.5},
    {"images/h.jpg", VW_ADVICE_KEEP, "helps", 0.7},    {"images/i.jpg", VW_ADVICE_KEEP, "helps", 0.6}};
enum { COUNT = sizeof photos / sizeof photos[0] };

// Lets the answer take the photos, as from the results of a run.
static void take_photos(struct vw_answer *answer) {
    struct vw_ledger_image images[COUNT];
    struct vw_ledger_score scores[COUNT];
    struct vw_photo_advice advised[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        images[i] = (struct vw_ledger_image){.image_id = i, .name = photos[i].name, .split = "train"};
        scores[i] = (struct vw_ledger_score){.image_id = i, .method = "dv_psnr", .value = photos[i].score};
        advised[i] = (struct vw_photo_advice){.image = &images[i],
                                              .advice = photos[i].advice,
                                              .reason = photos[i].reason,
                                              .score = isnan(photos[i].score) ? NULL : &scores[i]};
    }
    const struct vw_results results = {.score_count = COUNT, .advice = {.photos = advised, .count = COUNT}};
    ASSERT_OK(vw_answer_take(answer, &results));
}

static void print(const void *context) { vw_answer_print((struct vw_answer *)context); }

static const struct vw_reconstruction usable = {.view_count = 1,
                                                .trained_px = {60, 40},
                                                .measured_px = {120, 80},
                                                .psnr_db = 21.26,
                                                .ssim = 0.594,
                                                .mean_colour_db = 12.6,
                                                .nearest_photo_db = 16.7};

TEST(photos_stand_by_advice_and_reason) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    AUTO(vw_answer_free)
    struct vw_answer answer = {.out = folder, .reconstruction = usable, .has_report = true, .training_s = NAN};
    take_photos(&answer);
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    AUTO_FREE char *expected =
        vw_format_text("reconstruction  usable: 21.3 dB and SSIM 0.59, median of 1 validation photo at 120 x 80, "
                       "trained at 60 x 40; their mean colour has 12.6 dB, the nearest train photo 16.7\n"
                       "keep            6: c.jpg, a.jpg, h.jpg, i.jpg, g.jpg (helps); e.jpg (lone view)\n"
                       "look at         1: d.jpg (exposure)\n"
                       "leave out       5: k.jpg, j.jpg, m.jpg, l.jpg, n.jpg (too dark)\n"
                       "cannot tell     2: 1 duplicate; 1 within noise\n"
                       "next            open %s/report.html in a browser\n",
                       folder);
    assert_string_equal(text, expected);
}

// A reconstruction too coarse to rank photos by needs a better training first, whose time follows from this one's.
TEST(a_coarse_reconstruction_asks_for_a_finer_one) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    struct vw_answer answer = {.out = folder, .reconstruction = usable, .times_at_most = 20, .training_s = 30};
    answer.reconstruction.psnr_db = 17;
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    assert_non_null(strstr(text, "too coarse to rank photos by"));
    assert_non_null(
        strstr(text, "\nnext            this command with --accuracy reference and another --out   (about 10 min)\n"));
}

// A field that was trained smaller than the photos are is told how to be kept, at what cost.
TEST(a_smaller_field_tells_how_to_train_a_larger_one) {
    struct vw_answer answer = {.out = "o u t",
                               .scene = "fox",
                               .reconstruction = usable,
                               .downscale = 2,
                               .epochs = 30,
                               .training_s = 60,
                               .unvalidated_share = 0.5};
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    assert_non_null(strstr(text, "\nto keep it      viewworth train fox --splits 'o u t'/splits.json --downscale 1 "
                                 "--epochs 120 --out FIELD   (about 2 min)\n"));
    answer.downscale = 1;
    AUTO_FREE char *stored = printed_on(stdout, print, &answer);
    assert_null(strstr(stored, "to keep it"));
}

// One validation photo cannot verify a selection; two can, at the price that info tells.
TEST(a_usable_reconstruction_asks_for_a_selection) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    AUTO(vw_answer_free)
    struct vw_answer answer = {.out = folder, .reconstruction = usable, .training_s = 30, .unvalidated_share = 0.5};
    take_photos(&answer);
    answer.val_count = 2;
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    AUTO_FREE char *expected =
        vw_format_text("\nnext            viewworth select %s --to LIST   (up to 34 trainings, about 8 min)\n", folder);
    assert_non_null(strstr(text, expected));
}

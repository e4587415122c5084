// The last lines of value: the verdict, advice as advice.csv has it, and the command that comes next.
#include "support/ledger_fixture.h"

#include "cli/output/answer.h"
#include "support/printed.h"
#include "support/temporary_folder.h"

static const char table[] = "name,advice,reason,score,ci_low,ci_high,unit,method\n"
                            "images/a.jpg,keep,helps,1.5,1,2,dB,dv_psnr\n"
                            "images/b.jpg,unclear,within noise,0.1,-1,2,dB,dv_psnr\n"
                            "images/c.jpg,keep,helps,2.5,1,2,dB,dv_psnr\n"
                            "images/d.jpg,look,exposure,-3,-4,-2,dB,dv_psnr\n"
                            "images/e.jpg,keep,lone view,-1,-4,2,dB,dv_psnr\n"
                            "images/f.jpg,unclear,duplicate,,,,,\n"
                            "images/n.jpg,drop,too dark,,,,,\n"
                            "images/m.jpg,drop,too dark,0.3,0,1,dB,dv_psnr\n"
                            "images/l.jpg,drop,too dark,,,,,\n"
                            "images/k.jpg,drop,too dark,0.2,0,1,dB,dv_psnr\n"
                            "images/j.jpg,drop,too dark,0.3,0,1,dB,dv_psnr\n"
                            "images/g.jpg,keep,helps,0.5,0,1,dB,dv_psnr\n"
                            "images/h.jpg,keep,helps,0.7,0,1,dB,dv_psnr\n"
                            "images/i.jpg,keep,helps,0.6,0,1,dB,dv_psnr\n";

static void print(const void *context) { ASSERT_OK(vw_answer_print(context)); }

static const struct vw_reconstruction usable = {
    .view_count = 1, .psnr_db = 21.26, .ssim = 0.594, .mean_colour_db = 12.6, .nearest_photo_db = 16.7};

TEST(photos_stand_by_advice_and_reason) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    temporary_file(folder, "advice.csv", table);
    const struct vw_answer answer = {.out = folder, .reconstruction = usable, .has_report = true, .training_s = NAN};
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    AUTO_FREE char *expected =
        vw_format_text("reconstruction  usable: 21.3 dB and SSIM 0.59 in the middle of 1 validation "
                       "photo; their mean colour has 12.6 dB, the nearest train photo 16.7\n"
                       "keep            6: c.jpg, a.jpg, h.jpg, i.jpg, g.jpg (helps); e.jpg (lone view)\n"
                       "look at         1: d.jpg (exposure)\n"
                       "leave out       5: k.jpg, j.jpg, m.jpg, l.jpg, n.jpg (too dark)\n"
                       "cannot tell     2: 1 duplicate; 1 within noise\n"
                       "next            open %s/report.html in a browser\n",
                       folder);
    assert_string_equal(text, expected);
    json_t *json = vw_answer_advice_to_json(folder);
    const json_t *counts = json_object_get(json, "counts"), *photos = json_object_get(json, "photos");
    assert_int_equal(json_integer_value(json_object_get(counts, "keep")), 6);
    assert_int_equal(json_integer_value(json_object_get(counts, "drop")), 5);
    assert_int_equal(json_array_size(photos), 14);
    assert_string_equal(json_string_value(json_object_get(json_array_get(photos, 3), "name")), "images/d.jpg");
    assert_string_equal(json_string_value(json_object_get(json_array_get(photos, 3), "advice")), "look");
    json_decref(json);
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

// One validation photo cannot verify a selection; two can, at the price that info tells.
TEST(a_usable_reconstruction_asks_for_a_selection) {
    AUTO_FOLDER char *folder = temporary_folder_create();
    temporary_file(folder, "advice.csv", table);
    struct vw_answer answer = {.out = folder, .reconstruction = usable, .training_s = 30, .unvalidated_share = 0.5};
    answer.reconstruction.view_count = 2;
    AUTO_FREE char *text = printed_on(stdout, print, &answer);
    AUTO_FREE char *expected =
        vw_format_text("\nnext            viewworth select %s --to LIST   (up to 34 trainings, about 8 min)\n", folder);
    assert_non_null(strstr(text, expected));
}

// report.html: what hostile texts, unknown numbers and empty runs become in it, and that it loads nothing. What a
// browser makes of it is tests/report/test_report.sh's.
#include "support/ledger_fixture.h"

#include <jansson.h>
#include <sys/mman.h>

#include "base/json.h"
#include "image/image.h"
#include "report/advice.h"
#include "report/page.h"
#include "value/lasting_scores.h"

struct fixture {
    char *folder;
    struct vw_results run;
    const struct vw_results *runs[4]; // that one, unless a test sets others
    struct vw_report_page page;
    char *html; // as written
    json_t *data;
};

static int set_up(void **state) {
    struct fixture *fixture = vw_allocate(1, sizeof *fixture);
    assert_non_null(fixture);
    fixture->folder = temporary_folder_create();
    fixture->run = (struct vw_results){.label = "out",
                                       .row = test_run("{\"epochs\":4}"),
                                       .head = HEX_A,
                                       .input = {.images = test_images, .image_count = TEST_IMAGE_COUNT},
                                       .reconstruction = vw_reconstruction_unknown};
    fixture->runs[0] = &fixture->run;
    fixture->page = (struct vw_report_page){.runs = fixture->runs, .run_count = 1};
    *state = fixture;
    return 0;
}

static int tear_down(void **state) {
    AUTO_FREE struct fixture *fixture = *state;
    temporary_folder_remove(fixture->folder);
    json_decref(fixture->data);
    free(fixture->html);
    free(fixture->run.advice.photos);
    return 0;
}

// Writes the page, and reads it and its data.
static void write_page(struct fixture *fixture) {
    static const char begin[] = "<script type=\"application/json\" id=\"data\">", end[] = "</script>";
    size_t size_bytes;
    AUTO_FREE char *path = vw_path_join(fixture->folder, "report.html");
    free(fixture->html);
    json_decref(fixture->data);
    free(fixture->run.advice.photos);
    ASSERT_OK(vw_results_advise(&fixture->run));
    ASSERT_OK(vw_report_write_html(path, &fixture->page));
    ASSERT_OK(vw_file_read(path, 10000000, (void **)&fixture->html, &size_bytes));
    char *text = strstr(fixture->html, begin);
    assert_non_null(text);
    text += strlen(begin);
    json_error_t error;
    fixture->data = json_loadb(text, (size_t)(strstr(text, end) - text), 0, &error);
    if (!fixture->data) fail_msg("%s", error.text);
}

static const json_t *run_of(const struct fixture *fixture) {
    return json_array_get(json_object_get(fixture->data, "runs"), 0);
}

static uint32_t count(const char *text, const char *part) {
    uint32_t found = 0;
    for (; (text = strstr(text, part)); text++) found++;
    return found;
}

// ---- Texts ----------------------------------------------------------------------------------------------------------

TEST_WITHIN(hostile_texts_stay_data, set_up, tear_down) {
    struct fixture *fixture = *state;
    write_page(fixture);
    uint32_t scripts = count(fixture->html, "<script"), ends = count(fixture->html, "</script"),
             comments = count(fixture->html, "<!--");
    static const char *const names[] = {"</script><script>alert(1)</script>",
                                        "<!-- ",
                                        "]]> &lt;",
                                        "\"quoted\" 'single' \\",
                                        "\xe2\x80\xa8\xe2\x80\xa9",
                                        "{{data}}{{script}}",
                                        "tab\tand\nline"};
    struct vw_ledger_image images[VW_ARRAY_COUNT(names)];
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(names); i++)
        images[i] = (struct vw_ledger_image){i, names[i], "train", names[i], HEX_A, names[i]};
    fixture->run.input.images = images;
    fixture->run.input.image_count = VW_ARRAY_COUNT(names);
    fixture->run.row.scene_path = names[0];
    fixture->run.row.device = names[1];
    fixture->run.label = names[0];
    write_page(fixture);
    const json_t *columns = json_object_get(run_of(fixture), "images");
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        assert_string_equal(json_string_value(json_array_get(json_object_get(columns, "name"), i)), names[i]);
        assert_string_equal(json_string_value(json_array_get(json_object_get(columns, "provider"), i)), names[i]);
    }
    assert_int_equal(count(fixture->html, "<script"), scripts);
    assert_int_equal(count(fixture->html, "</script"), ends);
    assert_int_equal(count(fixture->html, "<!--"), comments);
    assert_null(strstr(fixture->html, "\xe2\x80\xa8"));
    assert_non_null(strstr(fixture->html, "\\u003c/script\\u003e"));
}

TEST(bytes_that_are_no_utf8_are_replaced) {
    static const struct {
        const char *text, *repaired;
    } cases[] = {{"caf\xe9.png", "caf\xef\xbf\xbd.png"},
                 {"\xff\xfe", "\xef\xbf\xbd\xef\xbf\xbd"},
                 {"cut \xe2\x80", "cut \xef\xbf\xbd\xef\xbf\xbd"},
                 {"\xed\xa0\x80", "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd"}, // half of a surrogate pair
                 {"\xc3\xa9 \xf0\x9f\x93\xb7", "\xc3\xa9 \xf0\x9f\x93\xb7"},
                 {"", ""}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        json_t *value = vw_json_string(cases[i].text);
        assert_string_equal(json_string_value(value), cases[i].repaired);
        json_decref(value);
    }
    json_t *nothing = vw_json_string(NULL);
    assert_true(json_is_null(nothing));
    json_decref(nothing);
}

// ---- Numbers and what is missing ------------------------------------------------------------------------------------

TEST_WITHIN(unknown_numbers_are_null, set_up, tear_down) {
    struct fixture *fixture = *state;
    const struct vw_ledger_score scores[] = {{1, "dv_psnr", NAN, "dB", NAN, 0, NAN, INFINITY, 0, 0},
                                             {6, "dv_psnr", -0.25, "dB", 0.1, 3, -0.5, 0.125, 1, 2}};
    fixture->run.scores = scores;
    fixture->run.score_count = VW_ARRAY_COUNT(scores);
    write_page(fixture);
    const json_t *columns = json_object_get(json_object_get(run_of(fixture), "scores"), "dv_psnr");
    static const char *const unknown[] = {"value", "ci_low", "ci_high", "rank_ci_low", "rank_ci_high"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(unknown); i++) {
        assert_true(json_is_null(json_array_get(json_object_get(columns, unknown[i]), 0)));
        assert_true(json_is_number(json_array_get(json_object_get(columns, unknown[i]), 1)));
    }
    assert_true(json_number_value(json_array_get(json_object_get(columns, "ci_high"), 1)) == 0.125);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(columns, "image"), 1)), 6);
    assert_null(strstr(fixture->html, ":nan"));
}

TEST_WITHIN(runs_may_be_empty, set_up, tear_down) {
    struct fixture *fixture = *state;
    write_page(fixture); // no scores, no steps
    assert_int_equal(json_object_size(json_object_get(run_of(fixture), "scores")), 0);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(run_of(fixture), "steps"), "count")), 0);
    assert_true(json_is_null(json_object_get(run_of(fixture), "matrix")));
    assert_true(json_is_null(json_object_get(run_of(fixture), "thumbnails")));
    assert_true(json_is_null(json_object_get(json_object_get(run_of(fixture), "run"), "finished_utc")));
    fixture->run.input.image_count = 1;
    write_page(fixture);
    fixture->page.run_count = 0;
    write_page(fixture);
    assert_int_equal(json_array_size(json_object_get(fixture->data, "runs")), 0);
}

TEST_WITHIN(long_runs_are_thinned_to_their_last_step, set_up, tear_down) {
    enum { COUNT = 5321 };
    struct fixture *fixture = *state;
    AUTO_FREE struct vw_step_record *records = vw_allocate(COUNT, sizeof *records);
    for (uint32_t i = 0; i < COUNT; i++)
        records[i] = test_step(i, i / 100, i ? 1 : (uint32_t)VW_RECORD_UNTRAINED, 10 + i);
    records[7].nonfinite = true;
    records[COUNT - 1].val_psnr = NAN;
    fixture->run.input.records = records;
    fixture->run.input.record_count = COUNT;
    write_page(fixture);
    const json_t *steps = json_object_get(run_of(fixture), "steps"), *shown = json_object_get(steps, "step");
    size_t size = json_array_size(shown);
    assert_in_range(size, 500, 1001);
    assert_int_equal(json_integer_value(json_array_get(shown, 0)), 0);
    assert_int_equal(json_integer_value(json_array_get(shown, 1)),
                     json_integer_value(json_object_get(steps, "stride")));
    assert_int_equal(json_integer_value(json_array_get(shown, size - 1)), COUNT - 1);
    assert_int_equal(json_integer_value(json_object_get(steps, "nonfinite")), 1);
    assert_int_equal(json_integer_value(json_object_get(steps, "epochs")), 54);
    assert_true(json_number_value(json_object_get(steps, "first_psnr")) == 10);
    assert_true(json_number_value(json_object_get(steps, "last_psnr")) == 10 + COUNT - 2);
}

static json_t *of_run(const struct fixture *fixture, const char *key, const char *column) {
    return json_object_get(json_object_get(run_of(fixture), key), column);
}

TEST_WITHIN(credit_is_summed_by_photo_and_epoch, set_up, tear_down) {
    enum { COUNT = 10, LONG = 100000 };
    struct fixture *fixture = *state;
    AUTO_FREE struct vw_step_record *records = vw_allocate(LONG + 1, sizeof *records);
    for (uint32_t i = 0; i < COUNT; i++) // photos 1, 2 and 3 in turn; epoch 0 is burn-in
        records[i] =
            test_step(i, i ? (i - 1) / 3 : 0, i ? 1 + (i - 1) % 3 : (uint32_t)VW_RECORD_UNTRAINED, i * i / 8.0);
    records[5].val_psnr = NAN, records[5].nonfinite = true; // photo 2 in epoch 1; the next delta spans it
    fixture->run.input.records = records, fixture->run.input.record_count = COUNT,
    fixture->run.input.burn_in_epochs = 1;
    write_page(fixture);
    json_t *rows = of_run(fixture, "credit", "rows");
    assert_int_equal(json_array_size(rows), TEST_IMAGE_COUNT);
    assert_true(json_is_null(json_array_get(rows, 0)));                               // validates
    static const int wanted[3][2] = {{87500, 162500}, {0, 187500}, {250000, 212500}}; // 1e-5 dB
    for (uint32_t photo = 0; photo < 3; photo++)
        for (uint32_t epoch = 0; epoch < 2; epoch++)
            assert_int_equal(json_integer_value(json_array_get(json_array_get(rows, 1 + photo), epoch)),
                             wanted[photo][epoch]);
    assert_int_equal(json_integer_value(of_run(fixture, "credit", "first_epoch")), 1);
    assert_int_equal(json_integer_value(of_run(fixture, "credit", "group_epochs")), 1);
    for (uint32_t i = 0; i <= LONG; i++) // an epoch per step: as many as are shown in groups
        records[i] = test_step(i, i ? i - 1 : 0, i ? 1 : (uint32_t)VW_RECORD_UNTRAINED, i * 1e-4);
    fixture->run.input.record_count = LONG + 1;
    write_page(fixture);
    json_t *row = json_array_get(of_run(fixture, "credit", "rows"), 1);
    int64_t sum = 0;
    for (size_t i = 0; i < json_array_size(row); i++) sum += json_integer_value(json_array_get(row, i));
    assert_in_range(json_array_size(row) * TEST_IMAGE_COUNT, 100000, 200000);
    assert_int_equal(sum, 10 * (LONG - 1)); // all but burn-in, in 1e-5 dB
}

TEST_WITHIN(gate_growth_and_retrainings_are_shown, set_up, tear_down) {
    enum { STEPS = 3000 };
    struct fixture *fixture = *state;
    write_page(fixture);
    assert_true(json_is_null(json_object_get(run_of(fixture), "gate")));
    assert_true(json_is_null(json_object_get(run_of(fixture), "growth")));
    assert_true(json_is_null(json_object_get(run_of(fixture), "retrainings")));
    assert_true(json_is_null(json_object_get(run_of(fixture), "accuracy")));
    const struct vw_gate_check gate[] = {{6, 0, 0.5, 0.25, 0, 0}, {99, 0, 1, NAN, 0, 0}};
    AUTO_FREE struct vw_lasting_step *growth = vw_allocate(STEPS, sizeof *growth);
    for (uint32_t i = 0; i < STEPS; i++) growth[i] = (struct vw_lasting_step){.step = 1 + i, .size_psnr = i};
    static const uint32_t some[] = {1, 3}, others[] = {1, 2};
    const struct vw_ledger_retraining retrainings[] = {{.image_ids = some, .image_count = 2, .val_psnr = 20.5},
                                                       {.image_ids = others, .image_count = 2, .val_psnr = NAN}};
    const struct vw_ledger_score scores[] = {
        {.image_id = 1, .method = "worth_psnr", .value = 1, .unit = "dB", .visits = 1, .ci_low = NAN, .ci_high = NAN},
        {.image_id = 3, .method = "worth_psnr", .value = 2, .unit = "dB", .visits = 1, .ci_low = NAN, .ci_high = NAN}};
    struct vw_results *run = &fixture->run;
    run->input.lasting =
        (struct vw_lasting_pass){.steps = growth, .step_count = STEPS, .checks = gate, .check_count = 2};
    run->retrainings = retrainings, run->retraining_count = 2, run->scores = scores, run->score_count = 2;
    write_page(fixture);
    assert_int_equal(json_integer_value(json_array_get(of_run(fixture, "gate", "image"), 0)), 6);
    assert_true(json_number_value(json_array_get(of_run(fixture, "gate", "measured"), 0)) == 0.25);
    assert_true(json_is_null(json_array_get(of_run(fixture, "gate", "image"), 1)));
    assert_true(json_is_null(json_array_get(of_run(fixture, "gate", "measured"), 1)));
    assert_true(json_is_null(of_run(fixture, "gate", "correlation"))); // a single photo has none
    assert_true(json_number_value(of_run(fixture, "gate", "least")) == vw_lasting_gate_least);
    size_t shown = json_array_size(of_run(fixture, "growth", "step"));
    assert_in_range(shown, 500, 1001);
    assert_int_equal(json_integer_value(json_array_get(of_run(fixture, "growth", "step"), shown - 1)), STEPS);
    json_t *means = of_run(fixture, "retrainings", "means"), *worths = json_object_get(means, "worth_psnr");
    assert_int_equal(json_object_size(means), 1);
    assert_true(json_number_value(json_array_get(worths, 0)) == 1.5);
    assert_true(json_is_null(json_array_get(worths, 1))); // photo 2 has no score
}

// A retraining gains a dB times the share of its photos that photo 1 is: 24 of them show that, and advice rests on it.
TEST_WITHIN(accuracy_of_worth_is_shown, set_up, tear_down) {
    enum { COUNT = 24 };
    static const uint32_t subsets[4][TEST_TRAIN_COUNT] = {{1, 2, 3, 5, 6}, {1, 2}, {1, 3}, {2, 3}};
    static const double means_db[4] = {20.2, 20.5, 20.5, 20};
    struct fixture *fixture = *state;
    struct vw_ledger_retraining retrainings[COUNT];
    for (uint32_t i = 0; i < COUNT; i++)
        retrainings[i] = (struct vw_ledger_retraining){.image_ids = subsets[i % 4],
                                                       .image_count = i % 4 ? 2 : TEST_TRAIN_COUNT,
                                                       .val_psnr = means_db[i % 4] + (i * 7 % 5) * 0.001};
    struct vw_results *run = &fixture->run;
    run->retrainings = retrainings, run->retraining_count = COUNT;
    write_page(fixture);
    assert_string_equal(json_string_value(json_array_get(of_run(fixture, "accuracy", "method"), 0)), "worth_psnr");
    assert_true(json_number_value(json_array_get(of_run(fixture, "accuracy", "ci_low"), 0)) > 0.5);
    assert_int_equal(json_integer_value(of_run(fixture, "accuracy", "retrainings")), COUNT);
    assert_in_range(json_number_value(of_run(fixture, "accuracy", "noise_db")) * 1e6, 1000, 2000);
    assert_true(json_is_false(of_run(fixture, "advice", "tested"))); // there is no score worth_psnr
    const struct vw_ledger_score scores[] = {
        {.image_id = 1, .method = "dv_psnr", .value = 1, .unit = "dB", .visits = 1},
        {.image_id = 1, .method = "worth_psnr", .value = 1, .unit = "dB", .visits = 1}};
    run->scores = scores, run->score_count = 2;
    write_page(fixture);
    assert_true(json_is_true(of_run(fixture, "advice", "tested")));
}

// ---- Pictures and files ---------------------------------------------------------------------------------------------

TEST_WITHIN(runs_share_their_thumbnails, set_up, tear_down) {
    struct fixture *fixture = *state;
    const struct vw_report_picture first[TEST_IMAGE_COUNT] = {[1] = {"\x00\xff", 2}},
                                   second[TEST_IMAGE_COUNT] = {[2] = {"abc", 3}};
    struct vw_results without = fixture->run, other = fixture->run;
    fixture->run.thumbnails = first;
    other.thumbnails = second;
    memcpy(fixture->runs, (const struct vw_results *[]){&fixture->run, &without, &fixture->run, &other},
           sizeof fixture->runs);
    fixture->page.run_count = 4;
    write_page(fixture);
    const json_t *sets = json_object_get(fixture->data, "thumbnail_sets"),
                 *written = json_object_get(fixture->data, "runs");
    assert_int_equal(json_array_size(sets), 2);
    static const int places[] = {0, -1, 0, 1};
    for (uint32_t i = 0; i < 4; i++) {
        const json_t *place = json_object_get(json_array_get(written, i), "thumbnails");
        if (places[i] < 0) assert_true(json_is_null(place));
        else assert_int_equal(json_integer_value(place), places[i]);
    }
    assert_true(json_is_null(json_array_get(json_array_get(sets, 0), 0)));
    assert_string_equal(json_string_value(json_array_get(json_array_get(sets, 0), 1)), "data:image/webp;base64,AP8=");
    assert_string_equal(json_string_value(json_array_get(json_array_get(sets, 1), 2)), "data:image/webp;base64,YWJj");
}

TEST_WITHIN(documents_carry_their_pictures, set_up, tear_down) {
    struct fixture *fixture = *state;
    static const char *const files[] = {"renders/0.png"}, *const names[] = {"a.png", "constructor"};
    const struct vw_report_picture picture = {"png", 3}, thumbnails[] = {{"abc", 3}, {0}};
    json_t *content = json_pack("{s:[]}", "lists");
    const struct vw_report_document document = {.kind = "compare",
                                                .label = "out",
                                                .file = "compare.json",
                                                .content = content,
                                                .picture_files = files,
                                                .pictures = &picture,
                                                .picture_count = 1,
                                                .thumbnail_names = names,
                                                .thumbnails = thumbnails,
                                                .thumbnail_count = 2};
    fixture->page.documents = &document;
    fixture->page.document_count = 1;
    write_page(fixture);
    const json_t *written = json_array_get(json_object_get(fixture->data, "documents"), 0);
    assert_string_equal(json_string_value(json_object_get(json_object_get(written, "pictures"), "renders/0.png")),
                        "data:image/png;base64,cG5n");
    assert_int_equal(json_array_size(json_object_get(json_object_get(written, "content"), "lists")), 0);
    written = json_object_get(written, "thumbnails");
    assert_string_equal(json_string_value(json_object_get(written, "a.png")), "data:image/webp;base64,YWJj");
    assert_true(json_is_null(json_object_get(written, "constructor")));
    json_decref(content);
}

// ---- Short memory ---------------------------------------------------------------------------------------------------

enum { BLOCKS_MOST = 4000, BLOCK_BYTES = 8192 };
static struct {
    char *blocks[BLOCKS_MOST]; // none is used twice: what was freed cannot be touched
    uint32_t given, left, held;
} memory;

static void *give_block(size_t size_bytes) {
    if (!memory.left || size_bytes > BLOCK_BYTES) return NULL;
    assert_true(memory.given < BLOCKS_MOST);
    char *block = mmap(NULL, BLOCK_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(block != MAP_FAILED);
    memory.left--;
    memory.held++;
    return memory.blocks[memory.given++] = block;
}

static void take_block(void *block) {
    if (!block) return;
    memory.held--;
    mprotect(block, BLOCK_BYTES, PROT_NONE);
}

// Returns whether the page is written with so many pieces of memory for its JSON; none of them is used once freed, or
// lost.
static bool fits_into(const struct vw_report_page *page, const char *path, uint32_t blocks) {
    json_malloc_t give;
    json_free_t take;
    json_get_alloc_funcs(&give, &take);
    memory.given = memory.held = 0;
    memory.left = blocks;
    json_set_alloc_funcs(give_block, take_block);
    enum vw_status status = vw_report_write_html(path, page);
    json_set_alloc_funcs(give, take);
    assert_true(!status || status == VW_ERROR_MEMORY ||
                status == VW_ERROR_INPUT); // jansson does not say why it cannot read a text
    assert_int_equal(memory.held, 0);
    for (uint32_t i = 0; i < memory.given; i++) munmap(memory.blocks[i], BLOCK_BYTES);
    return !status;
}

TEST_WITHIN(short_memory_is_an_error, set_up, tear_down) {
    struct fixture *fixture = *state;
    static const char *const names[] = {"a.png"};
    const struct vw_report_picture picture = {"abc", 3}, thumbnails[2] = {0};
    const struct vw_report_document document = {"compare", "out", "compare.json", NULL,     names,
                                                &picture,  1,     names,          &picture, 1};
    const struct vw_ledger_score score = {test_images[0].image_id, "dv_psnr", 1, "dB", NAN, 1, NAN, NAN, 0, 0};
    struct vw_results *run = &fixture->run;
    const struct vw_step_record records[] = {{.step = 0, .val_psnr = 10}, {.step = 1, .val_psnr = 11}};
    uint32_t ids[] = {test_images[0].image_id, test_images[1].image_id};
    double values[4] = {0};
    run->matrix = (struct vw_matrix){
        .photos = ids, .photo_count = 2, .views = ids, .view_count = 2, .visit_count = 2, .psnr = values, .l1 = values};
    struct vw_view_evidence views[2] = {0};
    run->input.image_count = 2, run->scores = &score, run->score_count = 1;
    run->input.records = records, run->input.record_count = 2;
    run->views = views, run->standard_errors = values, run->thumbnails = thumbnails;
    fixture->page.documents = &document, fixture->page.document_count = 1;
    AUTO_FREE char *path = vw_path_join(fixture->folder, "short.html");
    uint32_t blocks = 0;
    while (!fits_into(&fixture->page, path, blocks)) {
        assert_false(vw_file_exists(path));
        assert_true(++blocks < BLOCKS_MOST);
    }
    assert_in_range(blocks, 100, BLOCKS_MOST);
}

TEST_WITHIN(a_score_of_no_image_is_refused, set_up, tear_down) {
    struct fixture *fixture = *state;
    const struct vw_ledger_score score = {77, "dv_psnr", 1, "dB", NAN, 1, NAN, NAN, 0, 0};
    fixture->run.scores = &score;
    fixture->run.score_count = 1;
    AUTO_FREE char *path = vw_path_join(fixture->folder, "report.html");
    ASSERT_FAILS(vw_report_write_html(path, &fixture->page), VW_ERROR_INPUT, "image 77");
    assert_false(vw_file_exists(path));
}

TEST(a_thumbnail_is_small_and_keeps_its_shape) {
    const struct {
        uint32_t width_px, height_px, small_width_px, small_height_px;
    } cases[] = {{400, 300, 128, 96}, {64, 48, 64, 48}, {1, 1, 1, 1},
                 {300, 3, 300, 3},    {3, 500, 1, 96},  {4000, 100, 384, 96}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const float background[3] = {1, 1, 1};
        AUTO(vw_image_clear)
        struct vw_image image = {
            .width_px = cases[i].width_px, .height_px = cases[i].height_px, .format = VW_PIXEL_UINT8};
        image.pixels = vw_allocate((size_t)image.width_px * image.height_px, 4); // transparent: the background shows
        AUTO_FREE void *bytes = NULL;
        size_t size_bytes = 0;
        ASSERT_OK(vw_image_make_thumbnail(&image, 96, background, &bytes, &size_bytes));
        char *folder = temporary_folder_create(), *path = vw_path_join(folder, "thumbnail.webp");
        AUTO(vw_image_clear) struct vw_image small;
        float rgba[4];
        ASSERT_OK(vw_file_write(path, bytes, size_bytes));
        ASSERT_OK(vw_image_load(path, 1, &small));
        assert_int_equal(small.width_px, cases[i].small_width_px);
        assert_int_equal(small.height_px, cases[i].small_height_px);
        vw_image_pixel(&small, 0, 0, rgba);
        assert_true(rgba[0] > 0.98f && rgba[2] > 0.98f); // WebP may be off by a few of 255
        temporary_folder_remove(folder);
        free(path);
    }
}

// ---- The page itself ------------------------------------------------------------------------------------------------

TEST_WITHIN(the_page_loads_nothing, set_up, tear_down) {
    struct fixture *fixture = *state;
    static const char *const requests[] = {"src=",
                                           "href=",
                                           "url(",
                                           "@import",
                                           "<link",
                                           "<iframe",
                                           "srcdoc",
                                           "fetch(",
                                           "XMLHttpRequest",
                                           "innerHTML",
                                           "insertAdjacentHTML",
                                           "document.write"};
    const char *const texts[] = {vw_html_template, vw_html_style,  vw_html_widgets, vw_html_script,
                                 vw_html_tradeoff, vw_html_photos, vw_html_scores,  vw_html_tables};
    write_page(fixture);
    for (size_t i = 0; i < VW_ARRAY_COUNT(requests); i++)
        for (size_t k = 0; k < VW_ARRAY_COUNT(texts); k++)
            if (strstr(texts[k], requests[i])) fail_msg("text %zu of the page has \"%s\"", k, requests[i]);
    assert_non_null(strstr(
        fixture->html, "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; style-src 'sha256-"));
    assert_null(strstr(fixture->html, "unsafe"));
    assert_null(strstr(fixture->html, "{{policy}}"));
    assert_null(strstr(vw_html_chart, "</script")); // it would end its element
    assert_true(strstr(fixture->html, "Content-Security-Policy") < strstr(fixture->html, "<style"));
}

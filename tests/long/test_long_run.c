// 200,000 steps of the smallest run: memory and open files stay as they are, and what the device says of the validation
// photos stays what the reference computes from the params, in double, without anything of the steps before.
#include "support/cmocka_test.h"

#include <dirent.h>
#include <inttypes.h>

#include "base/clock.h"
#include "base/statistics.h"
#include "gpu/compute.h"
#include "reference/reference.h"
#include "run/run_private.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "train/trainer_private.h"
#include "viewworth/viewworth.h"

enum { PHOTOS = 6, EPOCHS = 33334, STEPS = PHOTOS * EPOCHS, FILES_MORE = 0, KIB_MORE = 4096 };
// Tolerance of a view's RMSE and L1: that of one step, see hard_run.c.
static const double ERROR_TOLERANCE = 1e-5;
static const uint64_t looks[] = {1, 1000, STEPS / 10, STEPS / 4, STEPS / 2, STEPS};
enum { LOOKS = sizeof looks / sizeof looks[0], FIRST_MEASURED = 2 };

struct look {                              // at the run after some steps
    double psnr_db, l1, psnr_tolerance_db; // by the reference
    long resident_kib;
    int files;
};

// ---- The process ----------------------------------------------------------------------------------------------------

static long resident_kib(void) {
    char line[256];
    long found = -1;
    FILE *file = fopen("/proc/self/status", "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) sscanf(line, "VmRSS: %ld", &found);
    fclose(file);
    return found;
}

static int open_files(void) {
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

// ---- The reference --------------------------------------------------------------------------------------------------

static void *read_whole(struct vw_buffer *buffer) {
    uint64_t size_bytes = vw_buffer_size_bytes(buffer);
    void *data = vw_allocate(size_bytes, 1);
    ASSERT_OK(vw_buffer_read(buffer, 0, data, size_bytes));
    return data;
}

static void add_view(const struct reference_step *reference, struct vw_ray_range range, uint32_t views,
                     struct look *look) {
    double squared = 0.0, absolute = 0.0;
    for (uint32_t ray = range.first; ray < range.first + range.count; ray++)
        for (int c = 0; c < 3; c++) {
            double error = reference->colours[ray][c] - reference->rays[ray].target[c];
            squared += error * error / (3.0 * range.count);
            absolute += fabs(error) / (3.0 * range.count);
        }
    look->psnr_db += vw_psnr_db(squared) / views;
    look->l1 += absolute / views; // all views have as many rays
    look->psnr_tolerance_db += 20.0 / log(10.0) * ERROR_TOLERANCE / sqrt(squared) / views;
}

static void look_at(struct vw_trainer *trainer, struct look *look) {
    const size_t before = test_owned();
    AUTO_FREE float *params = read_whole(trainer->field.params);
    AUTO_FREE struct vw_ray *rays = read_whole(trainer->validation.evaluator.rays);
    AUTO_FREE struct vw_ray_range *ranges = read_whole(trainer->validation.ranges);
    struct reference_params *reference_params = reference_params_create(&trainer->model, params);
    struct reference_step *reference =
        reference_step_create(&trainer->model, rays, trainer->validation.evaluator.ray_count);
    reference_step_forward(reference, reference_params, false, 0);
    uint32_t views = 0;
    vw_trainer_validation_views(trainer, &views);
    for (uint32_t i = 0; i < views; i++) add_view(reference, ranges[i], views, look);
    test_release_to(before); // else the reference of every look would grow the process
}

// ---- The run --------------------------------------------------------------------------------------------------------

static struct vw_config smallest_config(void) {
    struct vw_config config = small_config(0, EPOCHS);
    config.rays = 16;
    config.levels = 2;
    config.log2_table = 6;
    return config;
}

static void take_steps(const char *out, struct look found[LOOKS]) {
    const struct vw_config config = smallest_config();
    const struct vw_run_params params = {.scene = {.path = SMALL_SCENE}, .config = &config, .out = out};
    AUTO(vw_run_close) struct vw_run *run = small_run_open(&params);
    double started_s = vw_now_s();
    for (size_t i = 0; i < LOOKS; i++) {
        ASSERT_OK(vw_run_advance(run, looks[i] - (i ? looks[i - 1] : 0)));
        found[i].resident_kib = resident_kib(); // before the reference takes any
        found[i].files = open_files();
        look_at(run->trainer, &found[i]);
    }
    double steps_s = vw_now_s() - started_s;
    ASSERT_OK(vw_run_finish(run));
    printf("%.2f ms a step; scores, tables and report after %.1f s more\n", 1e3 * steps_s / STEPS,
           vw_now_s() - started_s - steps_s);
}

static void compare(const struct look found[LOOKS], const struct vw_step_record *records) {
    printf("%8s %11s %11s %9s %9s %9s %6s\n", "step", "PSNR, dB", "error", "L1", "error", "RSS, KiB", "files");
    for (size_t i = 0; i < LOOKS; i++) {
        const struct vw_step_record *record = &records[looks[i]];
        assert_int_equal(record->step, looks[i]);
        double psnr_error_db = record->val_psnr - found[i].psnr_db, l1_error = record->val_l1 - found[i].l1;
        printf("%8" PRIu64 " %11.6f %11.2e %9.6f %9.2e %9ld %6d\n", looks[i], record->val_psnr, psnr_error_db,
               record->val_l1, l1_error, found[i].resident_kib, found[i].files);
        assert_true(fabs(psnr_error_db) <= found[i].psnr_tolerance_db);
        assert_true(fabs(l1_error) <= ERROR_TOLERANCE);
    }
}

static void check_ledger(const char *path, const struct look found[LOOKS]) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    AUTO_FREE struct vw_step_record *records = NULL;
    uint64_t count = 0;
    ASSERT_OK(vw_ledger_open(path, &ledger));
    double started_s = vw_now_s();
    ASSERT_OK(vw_ledger_verify(ledger));
    printf("verified in %.1f s\n", vw_now_s() - started_s);
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &count));
    assert_int_equal(count, STEPS + 1);
    for (uint64_t i = 0; i < count; i++) assert_false(records[i].nonfinite);
    compare(found, records);
}

TEST(nothing_grows_and_nothing_drifts) {
    struct look found[LOOKS] = {0};
    AUTO_FOLDER char *folder = temporary_folder_create();
    take_steps(temporary_path(folder, "out"), found);
    check_ledger(temporary_path(folder, "out/ledger.db"), found);
    assert_true(found[LOOKS - 1].resident_kib - found[FIRST_MEASURED].resident_kib <= KIB_MORE);
    assert_int_equal(found[LOOKS - 1].files - found[FIRST_MEASURED].files, FILES_MORE);
}

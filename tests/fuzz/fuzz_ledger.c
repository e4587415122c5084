#include <unistd.h>

#include "fuzz/database_edits.h"
#include "fuzz/fuzz.h"
#include "ledger/find_image.h"
#include "support/ledger_fixture.h"

// Values that a column takes and no run writes, and what a ledger does not have.
static const char *const changes[] = {
    "UPDATE step SET step = ?1 WHERE step = 4",
    "UPDATE step SET epoch = ?1 WHERE step = 4",
    "UPDATE step SET image_id = ?1 WHERE step = 4",
    "UPDATE step SET clamped = ?1, floored = -?1 WHERE step = 4",
    "UPDATE step SET val_psnr = ?1, val_l1 = 'x' WHERE step = 4",
    "UPDATE view SET image_id = ?1 WHERE step = 4 AND image_id = 0",
    "UPDATE view SET step = ?1 WHERE step = 4 AND image_id = 0",
    "UPDATE image SET image_id = ?1 WHERE image_id = 2",
    "UPDATE image SET name = substr(x'610062', 1, 1 + abs(?1) % 3) WHERE image_id = 2",
    "UPDATE score SET image_id = ?1 WHERE image_id = 2",
    "UPDATE score SET visits = ?1, rank_ci_low = ?1",
    "UPDATE score SET method = ?1",
    "UPDATE run SET seed = ?1",
    "UPDATE run SET status = 'running'",
    "UPDATE run SET device = printf('%.*c', abs(?1), 'x')",
    "DELETE FROM step WHERE step = abs(?1) % 11",
    "DELETE FROM image WHERE image_id = abs(?1) % 8",
    "CREATE INDEX extra ON step (run_id, step)",
    "UPDATE sqlite_schema SET rootpage = abs(?1) WHERE name = 'score'",
    "UPDATE sqlite_schema SET sql = replace(sql, 'TEXT', 'BLOB')",
};

static uint8_t *valid;
static size_t valid_bytes;

static void free_valid(void) { free(valid); }

static void make_valid(void) {
    struct test_trainer trainer = test_four_epochs;
    void *bytes = NULL;
    trainer.epochs = 2;
    AUTO_FREE char *path = test_ledger_record(fuzz_folder(), "valid.db", &trainer, 11);
    if (vw_file_read(path, FUZZ_FILE_BYTES_MOST, &bytes, &valid_bytes)) abort();
    unlink(path);
    valid = bytes;
    atexit(free_valid);
}

static void take_view(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error) {
    const struct vw_ledger_image *image = vw_ledger_find_image(test_images, TEST_IMAGE_COUNT, image_id);
    (void)context, (void)step, (void)image;
    fuzz_check(isfinite(error->mse) && isfinite(error->l1), "a view's errors are finite");
}

static void read_rows(struct vw_ledger *ledger) {
    const struct vw_ledger_image *images = NULL;
    AUTO_FREE struct vw_step_record *records = NULL;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    uint32_t image_count = 0, score_count = 0;
    uint64_t record_count = 0;
    fuzz_check_message(vw_ledger_get_images(ledger, &images, &image_count));
    fuzz_check_message(vw_ledger_get_steps(ledger, &records, &record_count));
    fuzz_check_message(vw_ledger_get_scores(ledger, &scores, &score_count));
    fuzz_check_message(vw_ledger_each_view(ledger, take_view, NULL));
    for (uint64_t i = 0; i < record_count; i++)
        fuzz_check(
            records[i].step == i && records[i].epoch <= i &&
                (records[i].view == VW_RECORD_UNTRAINED || vw_ledger_find_image(images, image_count, records[i].view)),
            "steps follow each other and name images");
    for (uint32_t i = 0; i < score_count; i++)
        fuzz_check(vw_ledger_find_image(images, image_count, scores[i].image_id) != NULL, "scores name images");
}

static void read_ledger(const char *path) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    struct vw_ledger_run run;
    fuzz_forget_message();
    enum vw_status status = vw_ledger_open(path, &ledger);
    fuzz_check_message(status);
    fuzz_check(!status == (ledger != NULL), "a ledger, or a failure");
    if (!ledger) return;
    fuzz_check(!vw_ledger_get_run(ledger, &run) && run.run_id && run.status, "it has a run");
    fuzz_check_message(vw_ledger_verify(ledger));
    read_rows(ledger);
}

static void append_to_ledger(const char *path) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    fuzz_forget_message();
    fuzz_check_message(vw_ledger_open_to_append(path, &ledger));
    if (!ledger) return;
    const struct vw_step_record more = {.step = vw_ledger_next_step(ledger), .validated = true, .train_loss = 1};
    fuzz_check_message(vw_ledger_compare(ledger, &(struct vw_step_record){0}, 1, test_validation_views));
    fuzz_check_message(vw_ledger_extend(ledger, "{}"));
    fuzz_check_message(vw_ledger_append(ledger, &more, 1, test_validation_views));
    fuzz_check_message(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", test_scores, TEST_SCORE_COUNT));
    fuzz_check_message(vw_ledger_verify(ledger));
    read_rows(ledger);
}

void fuzz_ledger(const uint8_t *data, size_t size_bytes) {
    static struct fuzz_database database;
    char victim[1024], path[1024];
    snprintf(victim, sizeof victim, "%s", fuzz_write("victim.txt", (const uint8_t *)"my thesis", 9));
    snprintf(path, sizeof path, "%s/ledger.db", fuzz_folder());
    if (!valid) make_valid();
    fuzz_edit_database(valid, valid_bytes, data, size_bytes, victim, changes, VW_ARRAY_COUNT(changes), &database);
    fuzz_write_database(path, &database);
    read_ledger(path);
    fuzz_check(fuzz_database_is_unchanged(path, &database), "reading changes nothing");
    append_to_ledger(path);
    fuzz_check(vw_file_exists(victim), "a journal deletes no file");
}

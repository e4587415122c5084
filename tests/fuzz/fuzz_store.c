#include <unistd.h>

#include "fuzz/database_edits.h"
#include "fuzz/fuzz.h"
#include "ledger/retraining.h"
#include "support/ledger_fixture.h"

static const char *const changes[] = {
    "UPDATE retraining SET val_psnr = ?1",
    "UPDATE retraining SET retraining_id = ?1",
    "UPDATE retraining SET seconds = 'x', row_hash = ?1",
    "CREATE INDEX extra ON view (image_id)",
    "CREATE VIEW extra AS SELECT * FROM view",
    "UPDATE sqlite_schema SET rootpage = abs(?1) WHERE name = 'view'",
};

static uint8_t *valid;
static size_t valid_bytes;

static void free_valid(void) { free(valid); }

static void use(const char *path) {
    static const uint32_t views[] = {1, 3, 17};
    const struct vw_retrain_params params = {.views = views, .view_count = 3, .seed = 5, .epochs = 30};
    const struct vw_retrain_result outcome = {.val_psnr = 20, .val_ssim = NAN, .seconds = 1};
    const struct vw_retrain_view view = {.image_id = 4, .psnr_db = 19};
    struct vw_retrain_view found_view = {.image_id = 4};
    struct vw_retrain_result result = {0};
    AUTO(vw_retraining_store_close) struct vw_retraining_store *retrainings = NULL;
    bool found = false;
    fuzz_forget_message();
    fuzz_check_message(vw_retraining_store_open(path, &retrainings));
    if (!retrainings) return;
    fuzz_check_message(vw_retraining_store_find(retrainings, HEX_A, &found, &result));
    fuzz_check_message(vw_retraining_store_find_views(retrainings, HEX_A, &found_view, 1));
    fuzz_check_message(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &params, &outcome, &view, 1));
}

static void make_valid(const char *path) {
    void *bytes = NULL;
    unlink(path);
    use(path);
    if (vw_file_read(path, FUZZ_FILE_BYTES_MOST, &bytes, &valid_bytes)) abort();
    valid = bytes;
    atexit(free_valid);
}

void fuzz_store(const uint8_t *data, size_t size_bytes) {
    static struct fuzz_database database;
    char victim[1024], path[1024];
    snprintf(victim, sizeof victim, "%s", fuzz_write("victim.txt", (const uint8_t *)"my thesis", 9));
    snprintf(path, sizeof path, "%s/retrainings.db", fuzz_folder());
    if (!valid) make_valid(path);
    fuzz_edit_database(valid, valid_bytes, data, size_bytes, victim, changes, VW_ARRAY_COUNT(changes), &database);
    fuzz_write_database(path, &database);
    use(path);
    fuzz_check(vw_file_exists(victim), "a journal deletes no file");
}

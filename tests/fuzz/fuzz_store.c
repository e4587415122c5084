#include <unistd.h>

#include "fuzz/database_edits.h"
#include "fuzz/fuzz.h"
#include "ledger/retraining_store.h"
#include "ledger/sweeps.h"
#include "support/ledger_fixture.h"

static const char *const changes[] = {
    "UPDATE retraining SET val_psnr = ?1",
    "UPDATE retraining SET retraining_id = ?1",
    "UPDATE retraining SET seconds = 'x', row_hash = ?1",
    "UPDATE measurement SET value = ?1",
    "UPDATE measurement SET row_hash = ?1",
    "UPDATE metric SET place = ?1",
    "UPDATE metric SET method = printf('%.*c', abs(?1), 'x')",
    "CREATE INDEX extra ON metric (place)",
    "CREATE VIEW extra AS SELECT * FROM metric",
    "UPDATE sqlite_schema SET rootpage = abs(?1) WHERE name = 'metric'",
};

enum { STORES = 2 };
static const char *const names[STORES] = {"retrainings.db", "tradeoff.db"};
static uint8_t *valid[STORES];
static size_t valid_bytes[STORES];

static void free_valid(void) {
    for (int i = 0; i < STORES; i++) free(valid[i]);
}

static void use_retrainings(const char *path) {
    static const uint32_t views[] = {1, 3, 17};
    const struct vw_retrain_params params = {.views = views, .view_count = 3, .seed = 5, .epochs = 30};
    const struct vw_retrain_result outcome = {.val_psnr = 20, .val_ssim = NAN, .seconds = 1};
    const struct vw_retrain_view view = {.image_id = 4, .psnr_db = 19};
    struct vw_retrain_view found_view = {.image_id = 4};
    const struct vw_metric metric = {.metric = "auc/blur", .method = "dv_psnr", .value = 0.5, .ci_low = NAN};
    struct vw_retrain_result result = {0};
    AUTO(vw_retraining_store_close) struct vw_retraining_store *retrainings = NULL;
    bool found = false;
    fuzz_forget_message();
    fuzz_check_message(vw_retraining_store_open(path, &retrainings));
    if (!retrainings) return;
    fuzz_check_message(vw_retraining_store_find(retrainings, HEX_A, &found, &result));
    fuzz_check_message(vw_retraining_store_find_views(retrainings, HEX_A, &found_view, 1));
    fuzz_check_message(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &params, &outcome, &view, 1));
    fuzz_check_message(vw_retraining_store_set_metrics(retrainings, HEX_B, HEX_A, &metric, 1));
}

static void use_sweeps(const char *path) {
    const struct vw_measurement measurements[] = {{"train_ms", 1.5}, {"device_mib", NAN}};
    const struct vw_sweep_metrics metric = {
        .configuration = "base", .parameter = "rays", .value = "500", .method = "dv_psnr"};
    AUTO(vw_sweeps_close) struct vw_sweeps *sweeps = NULL;
    bool found = false;
    double value = 0;
    fuzz_forget_message();
    fuzz_check_message(vw_sweeps_open(path, &sweeps));
    if (!sweeps) return;
    fuzz_check_message(vw_sweeps_find(sweeps, HEX_A, "train_ms", &found, &value));
    fuzz_check_message(vw_sweeps_keep(sweeps, HEX_A, measurements, 2));
    fuzz_check_message(vw_sweeps_set_metrics(sweeps, HEX_B, &metric, 1));
}

static void use(int store, const char *path) {
    if (store) use_sweeps(path);
    else use_retrainings(path);
}

static void make_valid(int store, const char *path) {
    void *bytes = NULL;
    unlink(path);
    use(store, path);
    if (vw_file_read(path, FUZZ_FILE_BYTES_MOST, &bytes, &valid_bytes[store])) abort();
    valid[store] = bytes;
    if (store == 0) atexit(free_valid);
}

// Tries a changed store; the first byte says which store.
void fuzz_store(const uint8_t *data, size_t size_bytes) {
    static struct fuzz_database database;
    int store = size_bytes ? data[0] % STORES : 0;
    char victim[1024], path[1024];
    snprintf(victim, sizeof victim, "%s", fuzz_write("victim.txt", (const uint8_t *)"my thesis", 9));
    for (int i = 0; i < STORES && !valid[STORES - 1]; i++) {
        snprintf(path, sizeof path, "%s/%s", fuzz_folder(), names[i]);
        make_valid(i, path);
    }
    snprintf(path, sizeof path, "%s/%s", fuzz_folder(), names[store]);
    fuzz_edit_database(valid[store], valid_bytes[store], data + (size_bytes > 0), size_bytes - (size_bytes > 0), victim,
                       changes, VW_ARRAY_COUNT(changes), &database);
    fuzz_write_database(path, &database);
    use(store, path);
    fuzz_check(vw_file_exists(victim), "a journal deletes no file");
}

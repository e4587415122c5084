#include "ledger/ledger_private.h"

enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context) {
    const struct vw_ledger_image *images = NULL; // which the rows may name
    uint32_t image_count = 0;
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status)
        status = vw_database_prepare(
            &ledger->database, "SELECT step, image_id, mse, l1 FROM view ORDER BY run_id, step, image_id", &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        uint64_t step = vw_ledger_read_count(ledger, statement, 0, INT64_MAX, &status);
        uint32_t image_id = vw_ledger_read_image_id(ledger, statement, 1, &status);
        const struct vw_view_error error = {.mse = vw_ledger_read_real(ledger, statement, 2, &status),
                                            .l1 = vw_ledger_read_real(ledger, statement, 3, &status)};
        if (!status) take(context, step, image_id, &error);
    }
    sqlite3_finalize(statement);
    return status;
}

#include "ledger/ledger_private.h"

enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT step, image_id, mse, l1 FROM view ORDER BY run_id, step, image_id", &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        const struct vw_view_error error = {.mse = sqlite3_column_double(statement, 2),
                                            .l1 = sqlite3_column_double(statement, 3)};
        take(context, (uint64_t)sqlite3_column_int64(statement, 0), (uint32_t)sqlite3_column_int64(statement, 1),
             &error);
    }
    sqlite3_finalize(statement);
    return status;
}

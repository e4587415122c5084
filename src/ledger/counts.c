#include "ledger/counts.h"

#include "ledger/ledger_private.h"

enum vw_status vw_ledger_count(struct vw_ledger *ledger, struct vw_ledger_counts *counts) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status =
        vw_database_prepare(&ledger->database,
                            "SELECT (SELECT count(*) FROM step), (SELECT count(*) FROM image), (SELECT count(*) FROM "
                            "view), (SELECT count(*) FROM probe), (SELECT count(*) FROM score), "
                            "(SELECT user_version FROM pragma_user_version)",
                            &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status)
        *counts = (struct vw_ledger_counts){.schema_version = (uint64_t)sqlite3_column_int64(statement, 5),
                                            .steps = (uint64_t)sqlite3_column_int64(statement, 0),
                                            .images = (uint64_t)sqlite3_column_int64(statement, 1),
                                            .views = (uint64_t)sqlite3_column_int64(statement, 2),
                                            .probes = (uint64_t)sqlite3_column_int64(statement, 3),
                                            .scores = (uint64_t)sqlite3_column_int64(statement, 4)};
    sqlite3_finalize(statement);
    return status;
}

#include <string.h>

#include "ledger/ledger_private.h"

// ---- Reading -------------------------------------------------------------------------------------------------------

// Reads both hashes of a name; "", which equals no hash, where there is none.
static enum vw_status find(struct vw_ledger *ledger, const char *name, char hash[VW_HASH_HEX_BYTES],
                           char previous[VW_HASH_HEX_BYTES]) {
    struct vw_row key = {0};
    bool found = false;
    hash[0] = previous[0] = 0;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT sha256, previous_sha256 FROM kept WHERE run_id = ? AND name = ?", &key.statement);
    if (status) return status;
    vw_row_add_text(&key, ledger->run.run_id);
    vw_row_add_text(&key, name);
    status = key.failed ? vw_database_fail(&ledger->database, "query the ledger")
                        : vw_database_next(&ledger->database, key.statement, &found);
    if (!status && found) {
        vw_row_copy_hash(key.statement, 0, hash);
        vw_row_copy_hash(key.statement, 1, previous);
    }
    sqlite3_finalize(key.statement);
    return status;
}

enum vw_status vw_ledger_is_kept(struct vw_ledger *ledger, const char *name, const char *sha256, bool *kept) {
    char hash[VW_HASH_HEX_BYTES], previous[VW_HASH_HEX_BYTES];
    enum vw_status status = find(ledger, name, hash, previous);
    if (!status) *kept = *sha256 && (strcmp(hash, sha256) == 0 || strcmp(previous, sha256) == 0);
    return status;
}

enum vw_status vw_ledger_get_kept(struct vw_ledger *ledger, const char *name, char sha256[VW_HASH_HEX_BYTES]) {
    char previous[VW_HASH_HEX_BYTES];
    return find(ledger, name, sha256, previous);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

struct keeping {
    struct vw_kept_row row;
    char final_hash[VW_HASH_HEX_BYTES]; // filled
};

static enum vw_status keep(struct vw_ledger *ledger, void *context) {
    struct keeping *keeping = context;
    struct vw_kept_row *row = &keeping->row;
    char hash[VW_HASH_HEX_BYTES], previous[VW_HASH_HEX_BYTES];
    enum vw_status status = find(ledger, row->name, hash, previous);
    if (status) return status;
    // The same file again replaces none: the one before it stays believed.
    if (*hash) row->previous_sha256 = strcmp(hash, row->sha256) ? hash : *previous ? previous : NULL;
    status = vw_table_insert(&ledger->database, &vw_kept_table, ledger->run.run_id, row, 1, NULL);
    row->previous_sha256 = NULL; // the buffers end here
    return status ? status
                  : vw_ledger_write_final_hash(&ledger->database, ledger->run_hash, ledger->head, keeping->final_hash);
}

enum vw_status vw_ledger_keep(struct vw_ledger *ledger, const char *name, const char *sha256) {
    struct keeping keeping = {.row = {.name = name, .sha256 = sha256}};
    enum vw_status status = vw_ledger_change(ledger, NULL, keep, &keeping);
    if (!status) memcpy(ledger->final_hash, keeping.final_hash, sizeof ledger->final_hash);
    return status;
}

// OUT/SHA256SUMS: the list of the result files of a finished run, as `sha256sum -c` reads it. Its first line is a
// comment with the chain head of the ledger. Whoever signs the list signs the run. A command lists the files that it
// has made, or compared with what they should be, by the bytes that it had in hand: never by what is in OUT meanwhile.
#ifndef VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H
#define VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/csv.h"
#include "run/out_files.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// The results of table vw_out_files (run/out_files.h). Checkpoints, the state of a stopped lasting pass,
// retrainings.db, renders and files of the user are not results of the run: they are never listed.
enum { VW_RESULT_FILE_COUNT = 15 };

struct vw_checksum {
    bool known, present; // known and not present: there is no such file
    char sha256[VW_HASH_HEX_BYTES];
};

// Hashes a file of OUT, unless there is none. VW_ERROR_INPUT for a link, a folder, a pipe or a device.
enum vw_status vw_checksum_make(const char *out, const char *name, struct vw_checksum *checksum);

// The result files in the order of the list; known are those that a command has made or read. All zero: none.
struct vw_checksums {
    struct vw_checksum files[VW_RESULT_FILE_COUNT];
};

// Notes the bytes of a file; NULL: there is none. Ignores names that are not of results. VW_ERROR_MISMATCH when the
// file was noted with other bytes: it was changed meanwhile.
enum vw_status vw_checksums_note(struct vw_checksums *checksums, const char *name, const void *data, size_t size_bytes);
// Notes the hash of a file; NULL: there is none.
enum vw_status vw_checksums_note_hash(struct vw_checksums *checksums, const char *name, const char *sha256);
// Notes that a run has no other results than those noted, the ledger and the report: a file of such a name that appears
// meanwhile is neither shown nor listed.
void vw_checksums_note_rest_absent(struct vw_checksums *checksums);
// Hashes a file of OUT in the same way and notes it, unless it is known.
enum vw_status vw_checksums_read(struct vw_checksums *checksums, const char *out, const char *name);
// Returns what is noted of a result file; NULL for other names.
const struct vw_checksum *vw_checksums_find(const struct vw_checksums *checksums, const char *name);
// Returns VW_ERROR_MISMATCH unless OUT/field.vwf is there and has the hash that the ledger names. Notes it.
enum vw_status vw_checksums_check_field(struct vw_checksums *checksums, const char *out, const char *recorded_sha256);
// Writes a result file and notes it.
enum vw_status vw_result_write(const char *out, const char *name, const void *data, size_t size_bytes,
                               struct vw_checksums *checksums);
// Writes a table that was made in memory, unless making it failed (`status`), and frees it.
enum vw_status vw_result_write_table(enum vw_status status, const char *out, const char *name,
                                     struct vw_csv_text *table, struct vw_checksums *checksums);

// Replaces the list by one of the files that are noted, and of the ledger. Called last, once the run has finished.
enum vw_status vw_checksums_write(const char *out, struct vw_ledger *ledger, struct vw_checksums *checksums);

// Removes the list before the ledger gets another head.
enum vw_status vw_checksums_remove(const char *out);

struct vw_checksums_found {
    bool present;    // the list; without it nothing was compared
    char **unlisted; // owned: the names of what is in OUT without being listed, in order, made harmless to print
    uint32_t unlisted_count;
};
// Compares the list with the files of OUT, which are read and noted unless they are known, with the ledger, and with
// its chain head. `replaced` is not compared, because the caller writes it anew; NULL: none. VW_ERROR_MISMATCH when the
// list was edited, has another head, or is of a run that has not finished, or when a result file was changed, removed
// or added. Free `found` also after a failure.
enum vw_status vw_checksums_check(const char *out, struct vw_ledger *ledger, const char *replaced,
                                  struct vw_checksums *checksums, struct vw_checksums_found *found);
void vw_checksums_found_free(struct vw_checksums_found *found);

#endif

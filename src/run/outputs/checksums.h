// OUT/SHA256SUMS: the list of the result files of a finished run, as `sha256sum -c` reads it. Its first line is a
// comment with the chain head of the ledger. Whoever signs the list signs the run. A command removes every derived file
// before it makes its own, so that the results that are there at its end are those it has made or checked.
#ifndef VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H
#define VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/csv.h"
#include "run/out_folder.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// Hashes a file of OUT; "": there is none. VW_ERROR_INPUT for a link, a folder, a pipe or a device.
enum vw_status vw_checksums_hash(const char *out, const char *name, char sha256[VW_HASH_HEX_BYTES]);
// Returns VW_ERROR_MISMATCH unless OUT/field.vwf is there and has the hash that the ledger names.
enum vw_status vw_checksums_check_field(const char *out, const char *recorded_sha256);

enum vw_status vw_result_write(const char *out, const char *name, const void *data, size_t size_bytes);
// Writes a table that was made in memory, unless making it failed (`status`), and frees it.
enum vw_status vw_result_write_table(enum vw_status status, const char *out, const char *name,
                                     struct vw_csv_text *table);

// Replaces the list by one of the results that are in OUT. Called last, once the run has finished.
enum vw_status vw_checksums_write(const char *out, struct vw_ledger *ledger);

struct vw_checksums_found {
    bool present;    // the list; without it nothing was compared
    char **unlisted; // owned: the names of what is in OUT without being listed, in order, made harmless to print
    uint32_t unlisted_count;
};
// Compares the list with the files of OUT, the ledger and its chain head. `replaced` is not compared, because the
// caller writes it anew; NULL: none. VW_ERROR_MISMATCH when the list was edited, has another head, or is of a run that
// has not finished, or when a result file was changed, removed or added. Free `found` also after a failure.
enum vw_status vw_checksums_check(const char *out, struct vw_ledger *ledger, const char *replaced,
                                  struct vw_checksums_found *found);
void vw_checksums_found_free(struct vw_checksums_found *found);

#endif

// OUT/SHA256SUMS: the list of the result files of a finished run, as `sha256sum -c` reads it. Its first line is a
// comment with the chain head of the ledger. Whoever signs the list signs the run.
#ifndef VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H
#define VIEWWORTH_RUN_OUTPUTS_CHECKSUMS_H

#include <stdbool.h>
#include <stdint.h>

#include "run/out_files.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// The results of table vw_out_files (run/out_files.h). Checkpoints, the state of a stopped lasting pass,
// retrainings.db, renders and files of the user are not results of the run: they are never listed.
enum { VW_RESULT_FILE_COUNT = 11 };

struct vw_checksum {
    const char *name; // "scores.csv", ...
    bool present;
    char sha256[VW_HASH_HEX_BYTES];
};

// Hashes a file of OUT, unless there is none. VW_ERROR_INPUT for a link, a folder, a pipe or a device.
enum vw_status vw_checksum_make(const char *out, const char *name, struct vw_checksum *checksum);

// Hashes the result files that are in OUT and replaces the list. Called last, once the run has finished.
enum vw_status vw_checksums_write(const char *out, const char *head);
// Replaces one line of the list after its file was written again; without a list it does nothing.
enum vw_status vw_checksums_update(const char *out, const char *name);

// Removes the list before the ledger gets another head.
enum vw_status vw_checksums_remove(const char *out);

struct vw_checksums_list;
// Reads the list and removes it, where only hashes of kept files (viewworth/ledger.h) are going to change in the
// ledger.
// `*list` is NULL where there is none.
enum vw_status vw_checksums_take(const char *out, struct vw_checksums_list **list);
// Writes it again with the new head and the new ledger, and frees it. Does nothing for NULL.
enum vw_status vw_checksums_put_back(const char *out, const char *head, struct vw_checksums_list **list);

struct vw_checksums_found {
    bool present;    // the list; without it nothing was compared
    char **unlisted; // owned: the names of what is in OUT without being listed, in order, made harmless to print
    uint32_t unlisted_count;
};
// Compares the list with the files of OUT and with the chain head of the ledger. VW_ERROR_MISMATCH when the list was
// edited, has another head, or when a result file was changed, removed or added. Free `found` also after a failure.
enum vw_status vw_checksums_check(const char *out, const char *head, struct vw_checksums_found *found);
void vw_checksums_found_free(struct vw_checksums_found *found);

#endif

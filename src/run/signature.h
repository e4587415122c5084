// The signature of a run: OUT/signature.json, over a statement of what the run is and which files it left.
#ifndef VIEWWORTH_RUN_SIGNATURE_H
#define VIEWWORTH_RUN_SIGNATURE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/signing.h"
#include "ledger/counts.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

#define VW_SIGNATURE_FILE "signature.json"

// The files beside the ledger that a signature covers, in the order in which it names them.
enum { VW_SIGNED_FILE_COUNT = 8 };
struct vw_signed_file {
    const char *name; // "scores.csv", ...
    bool present;
    uint64_t size_bytes;
    char sha256[VW_HASH_HEX_BYTES];
};

// Reads size and hash of a file of OUT, unless there is none. VW_ERROR_INPUT for a link, a folder, a pipe or a device.
enum vw_status vw_signed_file_read(const char *out, const char *name, struct vw_signed_file *file);

struct vw_statement {
    char run_id[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES]; // head: final_hash, which covers every row
    char status[32];
    struct vw_ledger_counts counts;
    struct vw_signed_file files[VW_SIGNED_FILE_COUNT];
};

// What there is to sign now. Reads every file. VW_ERROR_INPUT for a run that is running or has failed.
enum vw_status vw_statement_make(const char *out, struct vw_ledger *ledger, struct vw_statement *statement);

// Signs a statement with the key in the file `key_path` and replaces OUT/signature.json.
enum vw_status vw_statement_sign(const struct vw_statement *statement, const char *out, const char *key_path);
// Checks OUT/signature.json against a public key and the statement of what there is now.
// VW_ERROR_MISMATCH when it is missing, edited, by another key, of an earlier state, or when a file that it names is
// missing or another. `signed_files`, unless NULL, receives which files it covers.
enum vw_status vw_statement_check(const struct vw_statement *now, const char *out,
                                  const uint8_t key[VW_PUBLIC_KEY_BYTES], bool signed_files[VW_SIGNED_FILE_COUNT]);

#endif

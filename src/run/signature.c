#include "run/signature.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/signing.h"
#include "base/text_stream.h"

// The first line of every message, so that a signature of something else is never one of a run.
static const char domain[] = "viewworth signature 1";
static const char *const file_names[VW_SIGNED_FILE_COUNT] = {"scores.csv",  "matrix.csv",        "providers.csv",
                                                             "payout.csv",  "payout_photos.csv", "duplicates.csv",
                                                             "report.html", "field.vwf"};

// ---- Statements ----------------------------------------------------------------------------------------------------

static enum vw_status read_open_file(int descriptor, const char *name, struct vw_signed_file *file) {
    uint8_t hash[VW_HASH_BYTES];
    struct stat info;
    if (fstat(descriptor, &info)) return vw_fail(VW_ERROR_IO, "%s: cannot read: %s", name, strerror(errno));
    enum vw_status status = vw_sha256_descriptor(descriptor, name, hash);
    if (status) return status;
    file->present = true;
    file->size_bytes = (uint64_t)info.st_size;
    vw_hash_to_hex(hash, file->sha256);
    return VW_OK;
}

enum vw_status vw_signed_file_read(const char *out, const char *name, struct vw_signed_file *file) {
    int descriptor = -1;
    *file = (struct vw_signed_file){.name = name};
    enum vw_status status = vw_file_check_inside(out, name);
    if (status || !vw_file_exists_inside(out, name)) return status;
    status = vw_file_open_inside(out, name, &descriptor);
    if (status) return status;
    status = read_open_file(descriptor, name, file);
    close(descriptor);
    return status;
}

enum vw_status vw_statement_make(const char *out, struct vw_ledger *ledger, struct vw_statement *statement) {
    struct vw_ledger_run row;
    *statement = (struct vw_statement){0};
    enum vw_status status = vw_ledger_get_run(ledger, &row);
    if (!status) status = vw_ledger_count(ledger, &statement->counts);
    if (status) return status;
    if (strcmp(row.status, "finished") != 0 && strcmp(row.status, "interrupted") != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: the run is %s: only a finished or interrupted run has a signature", out,
                       row.status);
    snprintf(statement->run_id, sizeof statement->run_id, "%s", row.run_id);
    snprintf(statement->status, sizeof statement->status, "%s", row.status);
    vw_ledger_chain_head(ledger, statement->head);
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT && !status; i++)
        status = vw_signed_file_read(out, file_names[i], &statement->files[i]);
    return status;
}

// What is signed: lines of text in a fixed order. Their values hold no line end, since hashes, numbers and known words
// do not. To be freed; NULL when memory is short.
static char *make_message(const struct vw_statement *statement) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream message;
    FILE *stream = vw_text_stream_open(&message);
    if (!stream) return NULL;
    fprintf(stream, "%s\nschema %" PRIu64 "\nrun_id %s\nstatus %s\nhead %s\n", domain, statement->counts.schema_version,
            statement->run_id, statement->status, statement->head);
    fprintf(stream,
            "steps %" PRIu64 "\nimages %" PRIu64 "\nviews %" PRIu64 "\nprobes %" PRIu64 "\nscores %" PRIu64 "\n",
            statement->counts.steps, statement->counts.images, statement->counts.views, statement->counts.probes,
            statement->counts.scores);
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT; i++) {
        const struct vw_signed_file *file = &statement->files[i];
        if (file->present) fprintf(stream, "file %s %" PRIu64 " %s\n", file->name, file->size_bytes, file->sha256);
    }
    return vw_text_stream_close(&message, "signature", &text, &size_bytes) ? NULL : text;
}

static enum vw_status fail_memory(void) { return vw_fail(VW_ERROR_MEMORY, "out of memory for a signature"); }

// ---- Signing -------------------------------------------------------------------------------------------------------

static json_t *files_to_json(const struct vw_statement *statement) {
    json_t *array = json_array();
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT; i++) {
        const struct vw_signed_file *file = &statement->files[i];
        if (file->present &&
            json_array_append_new(array, json_pack("{s:s, s:I, s:s}", "name", file->name, "size_bytes",
                                                   (json_int_t)file->size_bytes, "sha256", file->sha256))) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static char *to_json(const struct vw_statement *statement, const char *public_key, const char *signature) {
    const struct vw_ledger_counts *counts = &statement->counts;
    json_t *object =
        json_pack("{s:s, s:I, s:s, s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:o, s:s, s:s}", "format", domain, "schema",
                  (json_int_t)counts->schema_version, "run_id", statement->run_id, "status", statement->status, "head",
                  statement->head, "steps", (json_int_t)counts->steps, "images", (json_int_t)counts->images, "views",
                  (json_int_t)counts->views, "probes", (json_int_t)counts->probes, "scores", (json_int_t)counts->scores,
                  "files", files_to_json(statement), "public_key", public_key, "signature", signature);
    char *text = vw_json_to_text(object, JSON_INDENT(2));
    json_decref(object);
    return text;
}

static enum vw_status write_signature(const struct vw_statement *statement, const char *out,
                                      const uint8_t key[VW_SECRET_KEY_BYTES]) {
    uint8_t signature[VW_SIGNATURE_BYTES];
    char public_text[VW_PUBLIC_KEY_TEXT_BYTES], signature_text[VW_SIGNATURE_TEXT_BYTES];
    char *message = make_message(statement), *path = vw_path_join(out, VW_SIGNATURE_FILE), *text = NULL, *file = NULL;
    if (message) {
        vw_sign(key, message, strlen(message), signature);
        vw_public_key_to_text(vw_public_key_of(key), public_text);
        vw_signature_to_text(signature, signature_text);
        text = to_json(statement, public_text, signature_text);
    }
    if (text) file = vw_format_text("%s\n", text);
    enum vw_status status = file && path ? vw_file_write(path, file, strlen(file)) : fail_memory();
    free(file);
    free(text);
    free(path);
    free(message);
    return status;
}

enum vw_status vw_statement_sign(const struct vw_statement *statement, const char *out, const char *key_path) {
    uint8_t key[VW_SECRET_KEY_BYTES];
    enum vw_status status = vw_secret_key_read(key_path, key);
    if (!status) status = write_signature(statement, out, key);
    vw_secret_key_wipe(key);
    return status;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

// A signature file, parsed. The statement's texts are of its own.
struct signature {
    struct vw_statement statement;
    char public_key[VW_PUBLIC_KEY_TEXT_BYTES];
    uint8_t bytes[VW_SIGNATURE_BYTES];
};

static enum vw_status fail_shape(const char *path, const char *what) {
    return vw_fail(VW_ERROR_MISMATCH, "%s: %s: it was edited; sign the run again by value --resume --sign", path, what);
}

static bool copy_hash(char to[VW_HASH_HEX_BYTES], const char *from) {
    uint8_t hash[VW_HASH_BYTES];
    if (!vw_hash_from_hex(from, hash)) return false;
    vw_hash_to_hex(hash, to);
    return true;
}

// Files come in the order of file_names; so none comes twice.
static bool read_files(const json_t *array, struct vw_statement *statement) {
    size_t next = 0, i;
    json_t *entry;
    if (!json_is_array(array)) return false;
    for (size_t f = 0; f < VW_SIGNED_FILE_COUNT; f++)
        statement->files[f] = (struct vw_signed_file){.name = file_names[f]};
    json_array_foreach(array, i, entry) {
        const char *name, *sha256;
        json_int_t size_bytes;
        if (json_unpack_ex(entry, NULL, JSON_STRICT, "{s:s, s:I, s:s}", "name", &name, "size_bytes", &size_bytes,
                           "sha256", &sha256))
            return false;
        while (next < VW_SIGNED_FILE_COUNT && strcmp(file_names[next], name) != 0) next++;
        if (next == VW_SIGNED_FILE_COUNT || size_bytes < 0) return false;
        struct vw_signed_file *file = &statement->files[next++];
        file->present = true;
        file->size_bytes = (uint64_t)size_bytes;
        if (!copy_hash(file->sha256, sha256)) return false;
    }
    return true;
}

static bool read_fields(json_t *object, struct signature *signature) {
    struct vw_statement *statement = &signature->statement;
    const char *format, *run_id, *status, *head, *public_key, *text;
    json_int_t schema, steps, images, views, probes, scores;
    json_t *files;
    if (json_unpack_ex(object, NULL, JSON_STRICT, "{s:s, s:I, s:s, s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:o, s:s, s:s}",
                       "format", &format, "schema", &schema, "run_id", &run_id, "status", &status, "head", &head,
                       "steps", &steps, "images", &images, "views", &views, "probes", &probes, "scores", &scores,
                       "files", &files, "public_key", &public_key, "signature", &text))
        return false;
    bool known = strcmp(format, domain) == 0 && (!strcmp(status, "finished") || !strcmp(status, "interrupted"));
    bool counted = schema >= 0 && steps >= 0 && images >= 0 && views >= 0 && probes >= 0 && scores >= 0;
    if (!known || !counted || strlen(public_key) != sizeof signature->public_key - 1) return false;
    statement->counts = (struct vw_ledger_counts){(uint64_t)schema, (uint64_t)steps,  (uint64_t)images,
                                                  (uint64_t)views,  (uint64_t)probes, (uint64_t)scores};
    snprintf(statement->status, sizeof statement->status, "%s", status);
    snprintf(signature->public_key, sizeof signature->public_key, "%s", public_key);
    return copy_hash(statement->run_id, run_id) && copy_hash(statement->head, head) && read_files(files, statement) &&
           vw_signature_from_text(text, signature->bytes);
}

static enum vw_status read_signature(const char *out, const char *path, struct signature *signature) {
    enum { LIMIT_BYTES = 1 << 16 };
    void *text = NULL;
    size_t size_bytes = 0;
    *signature = (struct signature){0};
    enum vw_status status = vw_file_read_inside(out, VW_SIGNATURE_FILE, LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    json_error_t error;
    json_t *object = vw_json_load(text, size_bytes, JSON_REJECT_DUPLICATES, &error);
    free(text);
    if (!object)
        return vw_fail(VW_ERROR_MISMATCH, "%s:%d: %s: it was edited; sign the run again", path, error.line, error.text);
    if (!read_fields(object, signature)) status = fail_shape(path, "its fields are not those of a signature");
    json_decref(object);
    return status;
}

// ---- Checking ------------------------------------------------------------------------------------------------------

static enum vw_status check_key(const struct signature *signature, const char *path,
                                const uint8_t key[VW_PUBLIC_KEY_BYTES]) {
    char key_text[VW_PUBLIC_KEY_TEXT_BYTES];
    vw_public_key_to_text(key, key_text);
    if (strcmp(key_text, signature->public_key) != 0)
        return vw_fail(VW_ERROR_MISMATCH, "%s: is signed by another key, %s, not by %s", path, signature->public_key,
                       key_text);
    char *message = make_message(&signature->statement);
    if (!message) return fail_memory();
    bool holds = vw_signature_holds(key, message, strlen(message), signature->bytes);
    free(message);
    return holds ? VW_OK : fail_shape(path, "the signature does not fit what it is of");
}

static enum vw_status check_run(const struct vw_statement *signed_one, const struct vw_statement *now,
                                const char *path) {
    if (strcmp(signed_one->run_id, now->run_id) != 0)
        return vw_fail(VW_ERROR_MISMATCH, "%s: is the signature of another run, %s", path, signed_one->run_id);
    if (strcmp(signed_one->head, now->head) != 0)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: is of another state of the run, with the head %s: it was continued or changed since; sign "
                       "it again by value --resume --sign",
                       path, signed_one->head);
    if (!strcmp(signed_one->status, now->status) && memcmp(&signed_one->counts, &now->counts, sizeof now->counts) == 0)
        return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH, "%s: its version, status or counts are not those of the ledger", path);
}

static enum vw_status check_files(const struct vw_statement *signed_one, const struct vw_statement *now,
                                  const char *out) {
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT; i++) {
        const struct vw_signed_file *then = &signed_one->files[i], *is = &now->files[i];
        if (!then->present && is->present) // a payout of any amount fits the ledger
            return vw_fail(VW_ERROR_MISMATCH,
                           "%s/%s: was not there when the run was signed; remove it, or have the run signed again", out,
                           is->name);
        if (!then->present) continue;
        if (!is->present)
            return vw_fail(VW_ERROR_MISMATCH, "%s/%s: is signed, but missing; restore it from a copy", out, then->name);
        if (then->size_bytes != is->size_bytes || strcmp(then->sha256, is->sha256) != 0)
            return vw_fail(VW_ERROR_MISMATCH, "%s/%s: is not the file that was signed; restore it from a copy", out,
                           then->name);
    }
    return VW_OK;
}

enum vw_status vw_statement_check(const struct vw_statement *now, const char *out,
                                  const uint8_t key[VW_PUBLIC_KEY_BYTES], bool signed_files[VW_SIGNED_FILE_COUNT]) {
    struct signature signature;
    char *path = vw_path_join(out, VW_SIGNATURE_FILE);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_file_exists(path) ? read_signature(out, path, &signature)
                                                 : vw_fail(VW_ERROR_MISMATCH,
                                                           "%s: is not there: the run is not signed; sign it by value "
                                                           "--resume --sign",
                                                           path);
    if (!status) status = check_key(&signature, path, key);
    if (!status) status = check_run(&signature.statement, now, path);
    if (!status) status = check_files(&signature.statement, now, out);
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT && !status && signed_files; i++)
        signed_files[i] = signature.statement.files[i].present;
    free(path);
    return status;
}

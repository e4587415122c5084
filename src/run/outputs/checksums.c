#include "run/outputs/checksums.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_stream.h"
#include "run/out_files.h"
#include "run/out_lock.h"

static const char heading[] = "# viewworth chain head ";

// Returns the results in the order of the list.
static const char *const *result_names(void) {
    static const char *names[VW_RESULT_FILE_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < vw_out_file_count && count < VW_RESULT_FILE_COUNT; i++)
        if (vw_out_files[i].result) names[count++] = vw_out_files[i].name;
    return names;
}

struct vw_checksums_list {
    char head[VW_HASH_HEX_BYTES];
    struct vw_checksums checksums;
};

static enum vw_status fail_memory(void) { return vw_fail(VW_ERROR_MEMORY, "out of memory for " VW_CHECKSUMS_FILE); }

// ---- The files in hand ---------------------------------------------------------------------------------------------

static struct vw_checksum *find(struct vw_checksums *checksums, const char *name) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (!strcmp(result_names()[i], name)) return &checksums->files[i];
    return NULL;
}

const struct vw_checksum *vw_checksums_find(const struct vw_checksums *checksums, const char *name) {
    return find((struct vw_checksums *)checksums, name); // it is not changed
}

enum vw_status vw_checksums_note_hash(struct vw_checksums *checksums, const char *name, const char *sha256) {
    struct vw_checksum *file = find(checksums, name);
    if (!file) return VW_OK;
    if (file->known && (file->present != !!sha256 || strcmp(file->sha256, sha256 ? sha256 : "") != 0))
        return vw_fail(VW_ERROR_MISMATCH, "%s: was changed while this command ran; repeat it", name);
    file->known = true;
    file->present = sha256;
    snprintf(file->sha256, sizeof file->sha256, "%s", sha256 ? sha256 : "");
    return VW_OK;
}

enum vw_status vw_checksums_note(struct vw_checksums *checksums, const char *name, const void *data,
                                 size_t size_bytes) {
    uint8_t hash[VW_HASH_BYTES];
    char sha256[VW_HASH_HEX_BYTES];
    if (data) vw_sha256(data, size_bytes, hash);
    if (data) vw_hash_to_hex(hash, sha256);
    return vw_checksums_note_hash(checksums, name, data ? sha256 : NULL);
}

void vw_checksums_note_rest_absent(struct vw_checksums *checksums) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        checksums->files[i].known |= strcmp(result_names()[i], VW_LEDGER_FILE) != 0 &&
                                     strcmp(result_names()[i], VW_REPORT_FILE) != 0 &&
                                     strcmp(result_names()[i], VW_ADVICE_FILE) != 0;
}

enum vw_status vw_checksum_make(const char *out, const char *name, struct vw_checksum *checksum) {
    int descriptor = -1;
    uint8_t hash[VW_HASH_BYTES];
    *checksum = (struct vw_checksum){.known = true};
    enum vw_status status = vw_file_check_inside(out, name);
    if (status || !vw_file_exists_inside(out, name)) return status;
    status = vw_file_open_inside(out, name, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, name, hash);
    close(descriptor);
    checksum->present = true;
    vw_hash_to_hex(hash, checksum->sha256);
    return status;
}

enum vw_status vw_checksums_read(struct vw_checksums *checksums, const char *out, const char *name) {
    struct vw_checksum *file = find(checksums, name);
    if (!file || file->known) return VW_OK;
    enum vw_status status = vw_checksum_make(out, name, file);
    file->known = !status;
    return status;
}

enum vw_status vw_checksums_check_field(struct vw_checksums *checksums, const char *out, const char *recorded_sha256) {
    enum vw_status status = vw_checksums_read(checksums, out, VW_FIELD_FILE);
    const struct vw_checksum *field = vw_checksums_find(checksums, VW_FIELD_FILE);
    if (status || (field->present && recorded_sha256 && strcmp(field->sha256, recorded_sha256) == 0)) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s/" VW_FIELD_FILE ": is not the field that the run ended with; restore it from a copy", out);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

enum vw_status vw_result_write(const char *out, const char *name, const void *data, size_t size_bytes,
                               struct vw_checksums *checksums) {
    struct vw_checksum *file = find(checksums, name);
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_file_write(path, data, size_bytes) : VW_ERROR_MEMORY;
    free(path);
    if (file) file->known = false; // an earlier state of it
    return status ? status : vw_checksums_note(checksums, name, data, size_bytes);
}

static enum vw_status write_list(const char *out, const struct vw_checksums_list *list) {
    struct vw_text_stream text;
    char *printed = NULL, *path = vw_path_join(out, VW_CHECKSUMS_FILE);
    size_t size_bytes = 0;
    FILE *stream = path ? vw_text_stream_open(&text) : NULL;
    if (!stream) {
        free(path);
        return fail_memory();
    }
    fprintf(stream, "%s%s\n", heading, list->head);
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (list->checksums.files[i].present)
            fprintf(stream, "%s  %s\n", list->checksums.files[i].sha256, result_names()[i]);
    enum vw_status status = vw_text_stream_close(&text, VW_CHECKSUMS_FILE, &printed, &size_bytes);
    if (!status) status = vw_file_write(path, printed, size_bytes);
    free(printed);
    free(path);
    return status;
}

enum vw_status vw_result_write_table(enum vw_status status, const char *out, const char *name,
                                     struct vw_csv_text *table, struct vw_checksums *checksums) {
    if (!status) status = vw_result_write(out, name, table->text, table->size_bytes, checksums);
    free(table->text);
    return status;
}

enum vw_status vw_checksums_write(const char *out, struct vw_ledger *ledger, struct vw_checksums *checksums) {
    struct vw_checksums_list list;
    vw_ledger_chain_head(ledger, list.head);
    find(checksums, VW_LEDGER_FILE)->known = false; // an earlier state of it
    enum vw_status status = vw_checksums_read(checksums, out, VW_LEDGER_FILE);
    list.checksums = *checksums;
    return status ? status : write_list(out, &list);
}

// ---- Reading -------------------------------------------------------------------------------------------------------

// Reads 64 digits, which move `*text` to their end.
static bool read_hex(const char **text, char hex[VW_HASH_HEX_BYTES]) {
    uint8_t hash[VW_HASH_BYTES];
    size_t length = strspn(*text, "0123456789abcdef");
    if (length != VW_HASH_HEX_BYTES - 1) return false;
    memcpy(hex, *text, length);
    hex[length] = 0;
    *text += length;
    return vw_hash_from_hex(hex, hash);
}

static bool read_word(const char **text, const char *word) {
    size_t length = strlen(word);
    if (strncmp(*text, word, length) != 0) return false;
    *text += length;
    return true;
}

// Takes exactly what write_list() writes: sha256sum would skip other comments and pass over other names.
static bool parse(const char *text, struct vw_checksums_list *list) {
    if (!read_word(&text, heading) || !read_hex(&text, list->head) || !read_word(&text, "\n")) return false;
    for (size_t next = 0; *text; next++) {
        char sha256[VW_HASH_HEX_BYTES];
        if (!read_hex(&text, sha256) || !read_word(&text, "  ")) return false;
        size_t length = strcspn(text, "\n");
        while (next < VW_RESULT_FILE_COUNT &&
               (strlen(result_names()[next]) != length || strncmp(text, result_names()[next], length) != 0))
            next++;
        if (next == VW_RESULT_FILE_COUNT || text[length] != '\n') return false;
        text += length + 1;
        list->checksums.files[next].present = true;
        memcpy(list->checksums.files[next].sha256, sha256, sizeof sha256);
    }
    return true;
}

static enum vw_status read_list(const char *out, bool *present, struct vw_checksums_list *list) {
    enum { LIMIT_BYTES = 1 << 16 };
    void *text = NULL;
    size_t size_bytes = 0;
    *present = false;
    enum vw_status status = vw_file_check_inside(out, VW_CHECKSUMS_FILE);
    if (status || !vw_file_exists_inside(out, VW_CHECKSUMS_FILE)) return status;
    status = vw_file_read_inside(out, VW_CHECKSUMS_FILE, LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    *present = true;
    if (strlen(text) != size_bytes || !parse(text, list))
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s/" VW_CHECKSUMS_FILE ": was edited; restore it from a copy, or write it again by "
                         "viewworth value --resume",
                         out);
    free(text);
    return status;
}

enum vw_status vw_checksums_remove(const char *out) { return vw_file_remove(out, VW_CHECKSUMS_FILE); }

// ---- Checking ------------------------------------------------------------------------------------------------------

static enum vw_status compare(const char *out, const char *name, const struct vw_checksum *listed,
                              const struct vw_checksum *now) {
    if (listed->present && !now->present)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is missing, but " VW_CHECKSUMS_FILE " lists it; restore it from a copy", out, name);
    if (!listed->present && now->present)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is not listed in " VW_CHECKSUMS_FILE ": it was added afterwards; remove it", out, name);
    if (!strcmp(listed->sha256, now->sha256)) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH, "%s/%s: is not the file that " VW_CHECKSUMS_FILE " lists; restore it from a copy",
                   out, name);
}

static enum vw_status compare_run(const char *out, struct vw_ledger *ledger, const struct vw_checksums_list *list) {
    char head[VW_HASH_HEX_BYTES];
    struct vw_ledger_run row;
    enum vw_status status = vw_ledger_get_run(ledger, &row);
    if (status) return status;
    vw_ledger_chain_head(ledger, head);
    if (strcmp(list->head, head) != 0)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/" VW_CHECKSUMS_FILE ": is of another state of the run, with the chain head %s; restore the "
                       "ledger and the list from the same copy",
                       out, list->head);
    if (strcmp(row.status, "finished") == 0) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s/" VW_CHECKSUMS_FILE ": lists the results of a run that is %s, which has none; remove it", out,
                   row.status);
}

static enum vw_status compare_all(const char *out, struct vw_ledger *ledger, const char *replaced,
                                  const struct vw_checksums_list *list, struct vw_checksums *checksums) {
    enum vw_status status = compare_run(out, ledger, list);
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++) {
        if (replaced && !strcmp(replaced, result_names()[i])) continue;
        status = vw_checksums_read(checksums, out, result_names()[i]);
        if (!status) status = compare(out, result_names()[i], &list->checksums.files[i], &checksums->files[i]);
    }
    return status;
}

// ---- The rest of the folder ----------------------------------------------------------------------------------------

// Returns whether nothing speaks for a file: the list does not name it, and it is not the lock file of a running
// command.
static bool is_unlisted(const char *name) {
    bool known = !strcmp(name, ".") || !strcmp(name, "..") || !strcmp(name, VW_CHECKSUMS_FILE) ||
                 !strcmp(name, VW_OUT_LOCK_FILE);
    for (size_t i = 0; i < vw_out_file_count && !known; i++)
        known = vw_out_files[i].result && !strcmp(name, vw_out_files[i].name);
    return !known;
}

static enum vw_status add_name(const char *name, struct vw_checksums_found *found) {
    char **grown = realloc(found->unlisted, (found->unlisted_count + 1) * sizeof *grown);
    if (!grown) return fail_memory();
    found->unlisted = grown;
    char *copy = vw_copy_text(name);
    if (!copy) return VW_ERROR_MEMORY;
    vw_text_make_line(copy);
    found->unlisted[found->unlisted_count++] = copy;
    return VW_OK;
}

static int compare_names(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

static enum vw_status list_unlisted(const char *out, struct vw_checksums_found *found) {
    enum vw_status status = VW_OK;
    DIR *folder = opendir(out);
    if (!folder) return vw_fail(VW_ERROR_IO, "%s: cannot list: %s; check its permissions", out, strerror(errno));
    for (struct dirent *entry; !status && (entry = readdir(folder));)
        if (is_unlisted(entry->d_name)) status = add_name(entry->d_name, found);
    closedir(folder);
    if (found->unlisted_count) qsort(found->unlisted, found->unlisted_count, sizeof(char *), compare_names);
    return status;
}

enum vw_status vw_checksums_check(const char *out, struct vw_ledger *ledger, const char *replaced,
                                  struct vw_checksums *checksums, struct vw_checksums_found *found) {
    struct vw_checksums_list list = {0};
    *found = (struct vw_checksums_found){0};
    enum vw_status status = read_list(out, &found->present, &list);
    if (status || !found->present) return status;
    status = compare_all(out, ledger, replaced, &list, checksums);
    return status ? status : list_unlisted(out, found);
}

void vw_checksums_found_free(struct vw_checksums_found *found) {
    for (uint32_t i = 0; i < found->unlisted_count; i++) free(found->unlisted[i]);
    free(found->unlisted);
    *found = (struct vw_checksums_found){0};
}

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
#include "base/text_stream.h"
#include "run/out_folder.h"

static const char heading[] = "# viewworth chain head ";

struct list {
    char head[VW_HASH_HEX_BYTES];
    char sha256[VW_RESULT_FILE_COUNT][VW_HASH_HEX_BYTES]; // in the order of vw_out_files; "": not listed
};

static enum vw_status fail_memory(void) { return vw_fail(VW_ERROR_MEMORY, "out of memory for " VW_CHECKSUMS_FILE); }

// ---- Hashes --------------------------------------------------------------------------------------------------------

enum vw_status vw_checksums_hash(const char *out, const char *name, char sha256[VW_HASH_HEX_BYTES]) {
    int descriptor = -1;
    uint8_t hash[VW_HASH_BYTES];
    *sha256 = 0;
    enum vw_status status = vw_file_check_inside(out, name);
    if (status || !vw_file_exists_inside(out, name)) return status;
    status = vw_file_open_inside(out, name, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, name, hash);
    close(descriptor);
    if (!status) vw_hash_to_hex(hash, sha256);
    return status;
}

enum vw_status vw_checksums_check_field(const char *out, const char *recorded_sha256) {
    char sha256[VW_HASH_HEX_BYTES];
    enum vw_status status = vw_checksums_hash(out, VW_FIELD_FILE, sha256);
    if (status || (recorded_sha256 && !strcmp(sha256, recorded_sha256))) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s/" VW_FIELD_FILE ": is not the field that the run ended with; restore it from a copy", out);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

enum vw_status vw_result_write(const char *out, const char *name, const void *data, size_t size_bytes) {
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_file_write(path, data, size_bytes) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_result_write_table(enum vw_status status, const char *out, const char *name,
                                     struct vw_csv_text *table) {
    if (!status) status = vw_result_write(out, name, table->text, table->size_bytes);
    free(table->text);
    return status;
}

static enum vw_status hash_results(const char *out, struct list *list) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++)
        status = vw_checksums_hash(out, vw_out_files[i].name, list->sha256[i]);
    return status;
}

enum vw_status vw_checksums_write(const char *out, struct vw_ledger *ledger) {
    struct list list;
    struct vw_text_stream text;
    char *printed = NULL;
    size_t size_bytes = 0;
    enum vw_status status = hash_results(out, &list);
    if (status) return status;
    FILE *stream = vw_text_stream_open(&text);
    if (!stream) return fail_memory();
    vw_ledger_chain_head(ledger, list.head);
    fprintf(stream, "%s%s\n", heading, list.head);
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (*list.sha256[i]) fprintf(stream, "%s  %s\n", list.sha256[i], vw_out_files[i].name);
    status = vw_text_stream_close(&text, VW_CHECKSUMS_FILE, &printed, &size_bytes);
    if (!status) status = vw_result_write(out, VW_CHECKSUMS_FILE, printed, size_bytes);
    free(printed);
    return status;
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

// Takes exactly what vw_checksums_write() writes: sha256sum would skip other comments and pass over other names.
static bool parse(const char *text, struct list *list) {
    if (!read_word(&text, heading) || !read_hex(&text, list->head) || !read_word(&text, "\n")) return false;
    for (size_t next = 0; *text; next++) {
        char sha256[VW_HASH_HEX_BYTES];
        if (!read_hex(&text, sha256) || !read_word(&text, "  ")) return false;
        while (next < VW_RESULT_FILE_COUNT && !read_word(&text, vw_out_files[next].name)) next++;
        if (next == VW_RESULT_FILE_COUNT || !read_word(&text, "\n")) return false;
        memcpy(list->sha256[next], sha256, sizeof sha256);
    }
    return true;
}

static enum vw_status read_list(const char *out, bool *present, struct list *list) {
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

// ---- Checking ------------------------------------------------------------------------------------------------------

static enum vw_status compare(const char *out, const char *name, const char *listed, const char *now) {
    if (!strcmp(listed, now)) return VW_OK;
    if (!*now)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is missing, but " VW_CHECKSUMS_FILE " lists it; restore it from a copy", out, name);
    if (!*listed)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is not listed in " VW_CHECKSUMS_FILE ": it was added afterwards; remove it", out, name);
    return vw_fail(VW_ERROR_MISMATCH, "%s/%s: is not the file that " VW_CHECKSUMS_FILE " lists; restore it from a copy",
                   out, name);
}

static enum vw_status compare_run(const char *out, struct vw_ledger *ledger, const struct list *list) {
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

static enum vw_status compare_results(const char *out, const char *replaced, const struct list *list) {
    char sha256[VW_HASH_HEX_BYTES];
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++) {
        const char *name = vw_out_files[i].name;
        if (replaced && !strcmp(replaced, name)) continue;
        status = vw_checksums_hash(out, name, sha256);
        if (!status) status = compare(out, name, list->sha256[i], sha256);
    }
    return status;
}

// ---- The rest of the folder ----------------------------------------------------------------------------------------

// Returns whether nothing speaks for a file: the list does not name it, and it is not the lock file of a running
// command.
static bool is_unlisted(const char *name) {
    return strcmp(name, ".") != 0 && strcmp(name, "..") != 0 && strcmp(name, VW_CHECKSUMS_FILE) != 0 &&
           strcmp(name, VW_OUT_LOCK_FILE) != 0 && !vw_out_is_result(name);
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
                                  struct vw_checksums_found *found) {
    struct list list = {0};
    *found = (struct vw_checksums_found){0};
    enum vw_status status = read_list(out, &found->present, &list);
    if (status || !found->present) return status;
    status = compare_run(out, ledger, &list);
    if (!status) status = compare_results(out, replaced, &list);
    return status ? status : list_unlisted(out, found);
}

void vw_checksums_found_free(struct vw_checksums_found *found) {
    for (uint32_t i = 0; i < found->unlisted_count; i++) free(found->unlisted[i]);
    free(found->unlisted);
    *found = (struct vw_checksums_found){0};
}

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
    struct vw_checksum files[VW_RESULT_FILE_COUNT];
};

static enum vw_status fail_memory(void) { return vw_fail(VW_ERROR_MEMORY, "out of memory for " VW_CHECKSUMS_FILE); }

// ---- Writing -------------------------------------------------------------------------------------------------------

enum vw_status vw_checksum_make(const char *out, const char *name, struct vw_checksum *checksum) {
    int descriptor = -1;
    uint8_t hash[VW_HASH_BYTES];
    *checksum = (struct vw_checksum){.name = name};
    enum vw_status status = vw_file_check_inside(out, name);
    if (status || !vw_file_exists_inside(out, name)) return status;
    status = vw_file_open_inside(out, name, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, name, hash);
    close(descriptor);
    if (status) return status;
    checksum->present = true;
    vw_hash_to_hex(hash, checksum->sha256);
    return VW_OK;
}

static enum vw_status hash_files(const char *out, struct vw_checksums_list *list) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++)
        status = vw_checksum_make(out, result_names()[i], &list->files[i]);
    return status;
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
        if (list->files[i].present) fprintf(stream, "%s  %s\n", list->files[i].sha256, list->files[i].name);
    enum vw_status status = vw_text_stream_close(&text, VW_CHECKSUMS_FILE, &printed, &size_bytes);
    if (!status) status = vw_file_write(path, printed, size_bytes);
    free(printed);
    free(path);
    return status;
}

enum vw_status vw_checksums_write(const char *out, const char *head) {
    struct vw_checksums_list list = {0};
    snprintf(list.head, sizeof list.head, "%s", head);
    enum vw_status status = hash_files(out, &list);
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
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++) list->files[i].name = result_names()[i];
    for (size_t next = 0; *text; next++) {
        char sha256[VW_HASH_HEX_BYTES];
        if (!read_hex(&text, sha256) || !read_word(&text, "  ")) return false;
        size_t length = strcspn(text, "\n");
        while (next < VW_RESULT_FILE_COUNT &&
               (strlen(result_names()[next]) != length || strncmp(text, result_names()[next], length) != 0))
            next++;
        if (next == VW_RESULT_FILE_COUNT || text[length] != '\n') return false;
        text += length + 1;
        list->files[next].present = true;
        memcpy(list->files[next].sha256, sha256, sizeof sha256);
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

static enum vw_status update(const char *out, const char *name, struct vw_checksums_list *list) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++)
        if (!strcmp(result_names()[i], name)) status = vw_checksum_make(out, name, &list->files[i]);
    return status ? status : write_list(out, list);
}

enum vw_status vw_checksums_update(const char *out, const char *name) {
    struct vw_checksums_list list = {0};
    bool present = false;
    enum vw_status status = read_list(out, &present, &list);
    return status || !present ? status : update(out, name, &list);
}

enum vw_status vw_checksums_remove(const char *out) {
    char *path = vw_path_join(out, VW_CHECKSUMS_FILE);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (unlink(path) && errno != ENOENT)
        status =
            vw_fail(VW_ERROR_IO, "%s: cannot remove: %s; remove it, and repeat the command", path, strerror(errno));
    free(path);
    return status;
}

enum vw_status vw_checksums_take(const char *out, struct vw_checksums_list **list) {
    struct vw_checksums_list *taken = vw_allocate(1, sizeof *taken);
    bool present = false;
    enum vw_status status = taken ? read_list(out, &present, taken) : VW_ERROR_MEMORY;
    if (!status && present) status = vw_checksums_remove(out);
    if (!status && present) *list = taken;
    else free(taken);
    return status;
}

enum vw_status vw_checksums_put_back(const char *out, const char *head, struct vw_checksums_list **list) {
    struct vw_checksums_list *held = *list;
    if (!held) return VW_OK;
    snprintf(held->head, sizeof held->head, "%s", head);
    enum vw_status status = update(out, VW_LEDGER_FILE, held);
    free(held);
    *list = NULL;
    return status;
}

// ---- Checking ------------------------------------------------------------------------------------------------------

static enum vw_status compare(const char *out, const struct vw_checksum *listed) {
    struct vw_checksum now;
    enum vw_status status = vw_checksum_make(out, listed->name, &now);
    if (status) return status;
    if (listed->present && !now.present)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is missing, but " VW_CHECKSUMS_FILE " lists it; restore it from a copy", out,
                       listed->name);
    if (!listed->present && now.present)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/%s: is not listed in " VW_CHECKSUMS_FILE ": it was added afterwards; remove it", out,
                       listed->name);
    if (!strcmp(listed->sha256, now.sha256)) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH, "%s/%s: is not the file that " VW_CHECKSUMS_FILE " lists; restore it from a copy",
                   out, listed->name);
}

static enum vw_status compare_all(const char *out, const char *head, const struct vw_checksums_list *list) {
    enum vw_status status = VW_OK;
    if (strcmp(list->head, head) != 0)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s/" VW_CHECKSUMS_FILE ": is of another state of the run, with the chain head %s; restore the "
                       "ledger and the list from the same copy",
                       out, list->head);
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT && !status; i++) status = compare(out, &list->files[i]);
    return status;
}

// Tells whether nothing speaks for a file: neither the list nor verify's table names it, and it is not the lock file of
// a running command.
static bool is_unlisted(const char *name) {
    bool known = !strcmp(name, ".") || !strcmp(name, "..") || !strcmp(name, VW_CHECKSUMS_FILE) ||
                 !strcmp(name, VW_OUT_LOCK_FILE);
    for (size_t i = 0; i < vw_out_file_count && !known; i++)
        known = !strcmp(name, vw_out_files[i].name) &&
                (vw_out_files[i].result || vw_out_files[i].protection == VW_OUT_KEPT);
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

enum vw_status vw_checksums_check(const char *out, const char *head, struct vw_checksums_found *found) {
    struct vw_checksums_list list = {0};
    *found = (struct vw_checksums_found){0};
    enum vw_status status = read_list(out, &found->present, &list);
    if (status || !found->present) return status;
    status = compare_all(out, head, &list);
    return status ? status : list_unlisted(out, found);
}

void vw_checksums_found_free(struct vw_checksums_found *found) {
    for (uint32_t i = 0; i < found->unlisted_count; i++) free(found->unlisted[i]);
    free(found->unlisted);
    *found = (struct vw_checksums_found){0};
}

#include "support/temporary_folder.h"

#include <ftw.h>
#include <unistd.h>

static void stop(const char *what, const char *path) {
    fprintf(stderr, "temporary folder: cannot %s %s: %s\n", what, path, vw_error_message());
    abort();
}

char *temporary_folder_create(void) {
    const char *parent = getenv("TMPDIR");
    char *path = vw_format_text("%s/viewworth-test-XXXXXX", parent && *parent ? parent : "/tmp");
    if (!path || !mkdtemp(path)) stop("create", path ? path : "(no memory)");
    return path;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *walk) {
    (void)info, (void)kind, (void)walk;
    return remove(path);
}

void temporary_folder_remove(char *folder) {
    if (nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS)) stop("remove", folder);
    free(folder);
}

int temporary_folder_set_up(void **state) { return !(*state = temporary_folder_create()); }

int temporary_folder_tear_down(void **state) {
    temporary_folder_remove(*state);
    return 0;
}

const char *temporary_path(const char *folder, const char *name) {
    static char paths[64][4096];
    static unsigned next;
    char *path = paths[next++ % VW_ARRAY_COUNT(paths)];
    if (snprintf(path, sizeof paths[0], "%s/%s", folder, name) >= (int)sizeof paths[0]) stop("name", name);
    return path;
}

const char *temporary_file(const char *folder, const char *name, const char *text) {
    const char *path = temporary_path(folder, name);
    char *parent = vw_path_folder(path);
    if (!parent || vw_folder_create(parent) || vw_file_write(path, text, strlen(text))) stop("write", path);
    free(parent);
    return path;
}

void temporary_write(const char *path, const void *bytes, size_t size_bytes) {
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size_bytes, file) != size_bytes || fclose(file)) stop("write", path);
}

void *temporary_read(const char *path, size_t *size_bytes) {
    size_t read_bytes = 0;
    void *data = NULL;
    if (vw_file_read(path, (size_t)1 << 30, &data, &read_bytes)) stop("read", path);
    if (size_bytes) *size_bytes = read_bytes;
    return data;
}

struct kept_file temporary_keep(const char *path) {
    struct kept_file kept = {.path = test_own(vw_copy_text(path), free)};
    kept.bytes = test_own(temporary_read(path, &kept.size_bytes), free);
    return kept;
}

void temporary_put_back(const struct kept_file *kept) { temporary_write(kept->path, kept->bytes, kept->size_bytes); }

const char *real_scene_path(const char *name) {
    const char *scenes = getenv("VIEWWORTH_SCENES");
    const char *path = temporary_path(scenes ? scenes : VW_SOURCE_FOLDER "/../shared/scenes", name);
    if (vw_folder_exists(path)) return path;
    fprintf(stderr, "SKIPPED: the scene %s is not there (%s); set VIEWWORTH_SCENES to the folder that holds it\n", name,
            path);
    return NULL;
}

// A folder of a test's own, and small files in it. Every function stops the test when it cannot do its work.
#ifndef VIEWWORTH_TESTS_SUPPORT_TEMPORARY_FOLDER_H
#define VIEWWORTH_TESTS_SUPPORT_TEMPORARY_FOLDER_H

#include "support/cmocka_test.h"

#include "base/file.h"
#include "base/memory.h"

// A test whose *state is a folder of its own.
#define FOLDER_TEST(name) TEST_WITHIN(name, temporary_folder_set_up, temporary_folder_tear_down)

int temporary_folder_set_up(void **state);
int temporary_folder_tear_down(void **state);
// Creates a folder under $TMPDIR (or /tmp) and returns its path, to be given to temporary_folder_remove().
char *temporary_folder_create(void);
// Removes the folder with all it holds, and frees the path.
void temporary_folder_remove(char *folder);
// Goes before the declaration of such a path: removes the folder when the block of the variable ends.
#define AUTO_FOLDER AUTO(temporary_folder_end)

static inline void temporary_folder_end(char **folder) { temporary_folder_remove(*folder); }

// Returns "folder/name" in storage that the next 63 calls keep.
const char *temporary_path(const char *folder, const char *name);
// Writes a text to folder/name, creating folders on the way, and returns the path as temporary_path() does.
const char *temporary_file(const char *folder, const char *name, const char *text);
// Writes bytes without the sync of vw_file_write(), which is slow.
void temporary_write(const char *path, const void *bytes, size_t size_bytes);
// A text that is refused as input, and what the message of one line says; `more` may be NULL.
struct refused_text {
    const char *text, *said, *more;
};
// Writes every text of an array to folder/name, and fails the test unless `call`, an expression of `path`, refuses it.
#define ASSERT_TEXTS_REFUSED(folder, name, refused, call)                                                              \
    for (size_t i_ = 0; i_ < VW_ARRAY_COUNT(refused); i_++) {                                                          \
        const char *path = temporary_file(folder, name, (refused)[i_].text);                                           \
        ASSERT_CASE_FAILS((refused)[i_].text, call, VW_ERROR_INPUT, (refused)[i_].said, (refused)[i_].more);           \
    }
// Reads a file whole; to be freed. A zero byte follows it. `size_bytes` may be NULL.
void *temporary_read(const char *path, size_t *size_bytes);

// A file as it was, kept until the test ends.
struct kept_file {
    const char *path;
    const void *bytes;
    size_t size_bytes;
};
struct kept_file temporary_keep(const char *path);
// Writes the file as it was again.
void temporary_put_back(const struct kept_file *kept);

// Returns the folder of the real-data scene `name` ($VIEWWORTH_SCENES, else ../shared/scenes beside the sources); NULL,
// with a message, when absent.
const char *real_scene_path(const char *name);

#endif

// Processes that decode photos: what a worker answers is not believed, what becomes of it fails one photo only, and
// nothing of it is left.
#include "support/cmocka_test.h"

#include <dirent.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/hash.h"
#include "image/decoder.h"
#include "image/image.h"
#include "support/temporary_folder.h"

static int make_folder(void **state) {
    vw_decoder_hold();
    return !(*state = temporary_folder_create());
}

static int remove_folder(void **state) {
    temporary_folder_remove(*state);
    vw_decoder_release();
    vw_decoder_configure(&(struct vw_decoder_params){0});
    return 0;
}

static const char *beside(const char *name) {
    static char path[4096];
    ssize_t length = readlink("/proc/self/exe", path, sizeof path - 64);
    assert_true(length > 0);
    path[length] = 0;
    strcpy(strrchr(path, '/') + 1, name);
    return path;
}

// ---- Hostile workers ------------------------------------------------------------------------------------------------

static int use_hostile(void **state) {
    vw_decoder_configure(&(struct vw_decoder_params){.program = beside("hostile_decoder"), .time_out_s = 1});
    return make_folder(state);
}

static const char *photo_that_says(const char *folder, const char *text) {
    char content[128];
    snprintf(content, sizeof content, "\x89PNG\r\n\x1a\n%s", text);
    return temporary_file(folder, "photo.png", content);
}

static void check_refused(const char *folder, const char *text, const char *said) {
    struct vw_image image = {0};
    const char *path = photo_that_says(folder, text);
    enum vw_status status = vw_image_load(path, 1, &image);
    if (!status) fail_msg("'%s' is believed", text);
    ASSERT_CASE_FAILS(text, status, status, path, said);
    assert_null(image.pixels);
}

static struct vw_image check_read(const char *folder, const char *text) {
    struct vw_image image = {0};
    if (vw_image_load(photo_that_says(folder, text), 1, &image)) fail_msg("%s: %s", text, vw_error_message());
    assert_int_equal(image.width_px, 4);
    return image;
}

TEST_WITHIN(lies_are_refused, use_hostile, remove_folder) {
    static const char *const cases[][2] = {
        {"crash", "crashed"},
        {"crash at the header", "crashed"},
        {"half an answer", "crashed"},
        {"half the pixels", "crashed"},
        {"another size", "another size"},
        {"large payload", "another size"},
        {"unknown status", "crashed"},
        {"endless message", "cannot decode"},
        {"nan", "invalid data"},
        {"above 1", "invalid data"},
        {"no width", "invalid data"},
        {"no format", "invalid data"},
        {"many pixels", "4294967295 x 4294967295 pixels are more than the limit"},
        {"many values", "of 64 channels are more than the limit"},
        {"many channels", "65 channels are more than the limit"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        check_refused(*state, cases[i][0], cases[i][1]);
        AUTO(vw_image_clear)
        struct vw_image next = check_read(*state, "good"); // the next photo is read by another worker
    }
}

TEST_WITHIN(time_is_limited, use_hostile, remove_folder) {
    check_refused(*state, "hang", "too much memory or time");
    check_refused(*state, "a drop at a time", "too much memory or time");
}

TEST_WITHIN(flags_are_made_plain, use_hostile, remove_folder) {
    AUTO(vw_image_clear) struct vw_image image = check_read(*state, "unusable");
    assert_true(image.has_alpha);
    assert_int_equal(image.masked_count, 1);
    assert_int_equal(image.unusable[0], 1);
}

TEST_WITHIN(what_nobody_asked_for_is_no_answer, use_hostile, remove_folder) {
    struct vw_image image = check_read(*state, "more than asked");
    vw_image_clear(&image);
    for (int i = 0; i < 3; i++) {
        image = check_read(*state, "good");
        assert_int_equal(image.masked_count, 0);
        vw_image_clear(&image);
    }
}

// The program gets its socket, the photo, and nothing that OpenImageIO might listen to.
TEST_WITHIN(the_environment_stays_outside, use_hostile, remove_folder) {
    assert_int_equal(setenv("OIIO_LIBRARY_PATH", "/hostile", 1), 0);
    assert_int_equal(setenv("OPENIMAGEIO_OPTIONS", "plugin_searchpath=/hostile", 1), 0);
    assert_int_equal(setenv("LD_LIBRARY_PATH", "/kept", 1), 0);
    int leaked = dup(STDOUT_FILENO);
    check_refused(*state, "what it has", " descriptors; not interruptible;");
    assert_non_null(strstr(vw_error_message(), "LD_LIBRARY_PATH=/kept"));
    assert_null(strstr(vw_error_message(), "hostile"));
    assert_null(strstr(vw_error_message(), "PATH=/usr"));
    assert_non_null(strstr(vw_error_message(), " 6 descriptors")); // three of /dev/null, two sockets, the photo
    close(leaked);
    unsetenv("OIIO_LIBRARY_PATH");
    unsetenv("OPENIMAGEIO_OPTIONS");
    unsetenv("LD_LIBRARY_PATH");
}

TEST_WITHIN(another_program_is_refused, make_folder, remove_folder) {
    struct vw_image image = {0};
    const char *path = photo_that_says(*state, "good");
    vw_decoder_configure(&(struct vw_decoder_params){.program = "/bin/true"});
    ASSERT_FAILS(vw_image_load(path, 1, &image), VW_ERROR_IO, "belongs to another version");
    vw_decoder_configure(&(struct vw_decoder_params){.program = temporary_path(*state, "none")});
    ASSERT_FAILS(vw_image_load(path, 1, &image), VW_ERROR_IO, "cannot start viewworth-decode");
}

// ---- Files that change ----------------------------------------------------------------------------------------------

static const char *write_photo(const char *folder, uint32_t width_px) {
    static const float pixels[64 * 8 * 3];
    const char *path = temporary_path(folder, "photo.png");
    ASSERT_OK(vw_image_save(path, width_px, 8, 3, pixels));
    return path;
}

static struct vw_image_header probe(const char *path) {
    struct vw_image_header header;
    ASSERT_OK(vw_image_probe(path, VW_IMAGE_OF_PATH, &header));
    return header;
}

static struct vw_image_load *begin_load(const char *path, struct vw_image_header header) {
    struct vw_image_load *load = NULL;
    ASSERT_OK(vw_image_load_begin(path, VW_IMAGE_OF_PATH, &header, 1, &load));
    return load;
}

TEST_WITHIN(a_file_exchanged_after_its_header_is_refused, make_folder, remove_folder) {
    struct vw_image image = {0};
    const char *path = write_photo(*state, 8);
    const struct vw_image_header header = probe(path);
    write_photo(*state, 64);
    struct vw_image_load *load = begin_load(path, header);
    ASSERT_FAILS(vw_image_load_finish(&load, NULL, NULL, &image), VW_ERROR_IO, "its header changed");
    assert_null(load);
}

// Changes it at once, within the tick of the clock in which it was opened.
TEST_WITHIN(a_file_that_changes_while_it_is_read_is_decoded_as_it_was, make_folder, remove_folder) {
    struct vw_image image = {0};
    uint8_t sha256[VW_HASH_BYTES], expected[VW_HASH_BYTES];
    const char *path = write_photo(*state, 8);
    size_t size_bytes = 0;
    AUTO_FREE void *bytes = temporary_read(path, &size_bytes);
    vw_sha256(bytes, size_bytes, expected);
    struct vw_image_load *load = begin_load(path, probe(path));
    FILE *file = fopen(path, "r+"); // the same file, with other bytes
    assert_non_null(file);
    for (int i = 0; i < 64; i++) fputs("more", file);
    assert_int_equal(fclose(file), 0);
    ASSERT_OK(vw_image_load_finish(&load, NULL, sha256, &image));
    assert_memory_equal(sha256, expected, VW_HASH_BYTES);
    vw_image_clear(&image);
}

// ---- Processes ------------------------------------------------------------------------------------------------------

// Returns a field of /proc/PROCESS/status; "" if it is not there.
static const char *status_field(const char *process, const char *name) {
    static char line[256];
    char path[300];
    snprintf(path, sizeof path, "/proc/%s/status", process);
    FILE *file = fopen(path, "r");
    size_t length = strlen(name);
    bool found = false;
    while (file && !found && fgets(line, sizeof line, file))
        found = !strncmp(line, name, length) && line[length] == ':';
    if (file) fclose(file);
    if (!found) return "";
    line[strcspn(line, "\n")] = 0;
    return line + length + 1 + strspn(line + length + 1, " \t");
}

// Returns the newest process whose parent has the id `parent`, as text; NULL: none.
static const char *child_of(long parent) {
    static char name[256];
    DIR *folder = opendir("/proc");
    assert_non_null(folder);
    const char *found = NULL;
    for (struct dirent *entry; (entry = readdir(folder));)
        if (atol(entry->d_name) > (found ? atol(found) : 0) && atol(status_field(entry->d_name, "PPid")) == parent)
            found = strcpy(name, entry->d_name);
    closedir(folder);
    return found;
}

TEST_WITHIN(workers_are_confined, make_folder, remove_folder) {
    probe(write_photo(*state, 8));
    const char *server = child_of(getpid());
    assert_non_null(server);
    const char *worker = child_of(atol(server));
    assert_non_null(worker);
    assert_string_equal(status_field(worker, "NoNewPrivs"), "1");
    if (*status_field("self", "Seccomp"))
        assert_string_equal(status_field(worker, "Seccomp"), "2"); // the kernel has it
}

// Its own, so that a photo that takes over its worker cannot touch another.
TEST_WITHIN(every_photo_has_a_worker_of_its_own, make_folder, remove_folder) {
    const char *path = write_photo(*state, 8);
    const struct vw_image_header header = probe(path);
    uint8_t sha256[VW_HASH_BYTES];
    long workers[3] = {0};
    long server = atol(child_of(getpid()));
    workers[0] = atol(child_of(server));
    for (int i = 1; i < 3; i++) {
        struct vw_image image = {0};
        struct vw_image_load *load = begin_load(path, header);
        for (int waited = 0; waited < 200 && workers[i] <= workers[i - 1]; waited++, usleep(10000))
            workers[i] = atol(child_of(server)); // the server may not have started it yet
        ASSERT_OK(vw_image_load_finish(&load, NULL, sha256, &image));
        vw_image_clear(&image);
        assert_true(workers[i] > workers[i - 1]);
    }
}

// A process that outlives its parent becomes ours here.
TEST_WITHIN(no_process_is_left, make_folder, remove_folder) {
    struct vw_image_load *loads[3] = {0};
    assert_int_equal(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
    const char *path = write_photo(*state, 8);
    const struct vw_image_header header = probe(path);
    for (int i = 0; i < 3; i++) loads[i] = begin_load(path, header);
    for (int i = 0; i < 3; i++) vw_image_load_cancel(&loads[i]);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), 0); // the server, alive
    vw_decoder_release();
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    vw_decoder_hold();
}

// A task may still meet a worker that is about to end with the server.
TEST_WITHIN(a_killed_server_is_replaced, make_folder, remove_folder) {
    AUTO(vw_image_clear) struct vw_image image = {0};
    const char *path = write_photo(*state, 8), *server = child_of(getpid());
    assert_non_null(server);
    assert_int_equal(kill((pid_t)atol(server), SIGKILL), 0);
    for (int i = 0; i < 100 && vw_image_load(path, 1, &image); i++) usleep(100000);
    if (!image.pixels) fail_msg("%s", vw_error_message());
}

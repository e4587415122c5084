#include "run/out_folder.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "run/lasting/lasting_file.h"
#include "run/outputs/checksums.h"
#include "run/outputs/residuals.h"

enum { BLOCK_BYTES = 1 << 14, BLOCK_COUNT = 64 };

// Returns the errno of the failure; 0 when the file could be written.
static int try_to_write(const char *folder) {
    static const char block[BLOCK_BYTES];
    int file = vw_file_open_unnamed(folder); // so that a kill leaves nothing
    int cause = file < 0 ? errno : 0;
    for (int i = 0; !cause && i < BLOCK_COUNT; i++) cause = vw_descriptor_write(file, block, sizeof block);
    if (!cause && fsync(file)) cause = errno;
    if (file >= 0) close(file);
    return cause;
}

enum vw_status vw_out_check(const char *out) {
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    char *place = vw_copy_text(out);
    while (place && !vw_folder_exists(place)) { // up to the nearest folder that is there; "." and "/" are
        char *parent = vw_path_folder(place);
        free(place);
        place = parent;
    }
    if (!place) return VW_ERROR_MEMORY;
    int cause = try_to_write(place);
    enum vw_status status = VW_OK;
    if (cause)
        status = vw_fail(VW_ERROR_USAGE, "--out %s: cannot write in %s: %s; name another folder or make room", out,
                         place, strerror(cause));
    free(place);
    return status;
}

static enum vw_status remove_outdated(const char *out, const char *const *names, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *path = vw_path_join(out, names[i]);
        if (!path) return VW_ERROR_MEMORY;
        enum vw_status status = VW_OK;
        if (unlink(path) && errno != ENOENT)
            status = vw_fail(VW_ERROR_IO, "%s: cannot remove what became out of date: %s; remove it, and resume", path,
                             strerror(errno));
        free(path);
        if (status) return status;
    }
    return VW_OK;
}

enum vw_status vw_run_remove_outdated(const char *out) {
    static const char *const names[] = {"matrix.csv", VW_RESIDUALS_FILE, VW_LASTING_PASS_FILE, VW_LASTING_CREDITS_FILE};
    enum vw_status status = vw_run_remove_outdated_scores(out);
    return status ? status : remove_outdated(out, names, VW_ARRAY_COUNT(names));
}

enum vw_status vw_run_remove_payouts(const char *out) {
    static const char *const names[] = {VW_CHECKSUMS_FILE, "payout.csv", "payout_photos.csv"};
    return remove_outdated(out, names, VW_ARRAY_COUNT(names));
}

enum vw_status vw_run_remove_outdated_scores(const char *out) {
    static const char *const names[] = {VW_CHECKSUMS_FILE, "scores.csv",        "report.html",   "providers.csv",
                                        "payout.csv",      "payout_photos.csv", "duplicates.csv"};
    return remove_outdated(out, names, VW_ARRAY_COUNT(names));
}

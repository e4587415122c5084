#include "run/out_folder.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "run/out_files.h"
#include "run/outputs/checksums.h"
#include "viewworth/log.h"

enum vw_status vw_out_check(const char *out) {
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    char *place = vw_copy_text(out);
    while (place && !vw_folder_exists(place)) { // up to the nearest folder that is there; "." and "/" are
        char *parent = vw_path_folder(place);
        free(place);
        place = parent;
    }
    if (!place) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (access(place, W_OK | X_OK))
        status = vw_fail(VW_ERROR_USAGE, "--out %s: cannot write in %s: %s; name another folder", out, place,
                         strerror(errno));
    free(place);
    return status;
}

// Returns whether a path is one of the files of `out`, there or not.
static bool is_out_file(const char *path, const char *out) {
    const char *name = strrchr(path, '/');
    char *folder = vw_path_folder(path);
    bool is_one = false, inside = folder && vw_folder_is_same(folder, out);
    for (size_t i = 0; inside && i < vw_out_file_count; i++)
        is_one |= !strcmp(name ? name + 1 : path, vw_out_files[i].name);
    free(folder);
    return is_one;
}

enum vw_status vw_out_check_target(const char *option, const char *path, const char *out, bool json) {
    if (!path) return VW_OK;
    if (!vw_path_ends_with(path, ".ply") && !(json && vw_path_ends_with(path, ".json")))
        return vw_fail(VW_ERROR_USAGE, "--%s %s: the name must end in .ply%s", option, path, json ? " or .json" : "");
    if (vw_file_exists(path) || vw_folder_exists(path))
        return vw_fail(VW_ERROR_USAGE, "--%s %s: exists; name a new file, or remove that one", option, path);
    if (!is_out_file(path, out)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s %s: commands write their own file of that name there; name another", option,
                   path);
}

static enum vw_status remove_outdated(const char *out, enum vw_out_outdated by) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < vw_out_file_count; i++)
        if (vw_out_files[i].outdated == by) status = vw_file_remove(out, vw_out_files[i].name);
    return status;
}

enum vw_status vw_run_remove_outdated(const char *out, bool pays) {
    enum vw_status status = vw_run_remove_derived(out, pays);
    return status ? status : remove_outdated(out, VW_OUT_BY_STEPS);
}

enum vw_status vw_run_remove_derived(const char *out, bool pays) {
    bool paid = vw_file_exists_inside(out, "payout.csv");
    enum vw_status status = vw_checksums_remove(out); // first: it vouches for the others
    if (!status) status = remove_outdated(out, VW_OUT_BY_SCORES);
    if (!status && paid && !pays)
        vw_log_warning("%s/payout.csv is removed, since this command was not asked to pay; worth or value --resume "
                       "with --payout AMOUNT pays by the scores of now",
                       out);
    return status;
}

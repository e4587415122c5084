#include "run/lasting/lasting_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"

_Static_assert(sizeof(struct vw_lasting_step) == 40, "the file holds it as it is");

static char *make_header(const struct vw_lasting_file *file) {
    return vw_format_text("viewworth lasting credits 2, run %s, rays %" PRIu32 ", steps %" PRIu64 ", views %" PRIu32
                          "\n",
                          file->run_id, file->rays, file->steps, file->views);
}

static size_t row_bytes(const struct vw_lasting_file *file) {
    return sizeof(struct vw_lasting_step) + file->views * sizeof(double);
}

// Seals the file, records its hash, and only then writes it.
static enum vw_status write_file(const struct vw_lasting_file *file, const char *path, uint8_t *bytes,
                                 size_t body_bytes) {
    uint8_t whole[VW_HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    vw_sha256_seal(bytes, body_bytes, whole);
    vw_hash_to_hex(whole, hex);
    enum vw_status status = file->binding->keep(file->binding->context, VW_LASTING_CREDITS_FILE, hex);
    return status ? status : vw_file_write(path, bytes, body_bytes + VW_HASH_BYTES);
}

enum vw_status vw_lasting_file_save(const struct vw_lasting_file *file, const struct vw_lasting_rows *credits,
                                    uint64_t first_step) {
    char *header = make_header(file), *path = vw_path_join(file->out, VW_LASTING_CREDITS_FILE);
    size_t count = (size_t)(file->steps - first_step + 1), header_bytes = header ? strlen(header) : 0,
           steps_bytes = count * sizeof *credits->steps, body_bytes = header_bytes + count * row_bytes(file);
    uint8_t *bytes = header && path ? vw_allocate(body_bytes + VW_HASH_BYTES, 1) : NULL;
    enum vw_status status = bytes ? VW_OK : VW_ERROR_MEMORY;
    if (!status) {
        memcpy(bytes, header, header_bytes);
        memcpy(bytes + header_bytes, &credits->steps[first_step - 1], steps_bytes);
        if (file->views)
            memcpy(bytes + header_bytes + steps_bytes, &credits->view_psnr[(first_step - 1) * file->views],
                   body_bytes - header_bytes - steps_bytes);
        status = write_file(file, path, bytes, body_bytes);
    }
    free(bytes);
    free(header);
    free(path);
    return status;
}

static bool are_credits(const struct vw_lasting_step *credits, uint64_t count, uint64_t first_step) {
    for (uint64_t i = 0; i < count; i++)
        if (credits[i].step != first_step + i || !isfinite(credits[i].psnr) || !isfinite(credits[i].loss) ||
            !(isfinite(credits[i].size_psnr) && credits[i].size_psnr >= 0) ||
            !(isfinite(credits[i].size_loss) && credits[i].size_loss >= 0))
            return false;
    return true;
}

static bool are_finite(const double *values, uint64_t count) {
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

// Copies rows of `count` steps, the last ones of the run; `from` contains both arrays one after the other.
static bool take_rows(const struct vw_lasting_file *file, const uint8_t *from, uint64_t count,
                      const struct vw_lasting_rows *read, const struct vw_lasting_rows *credits) {
    uint64_t first = file->steps - count, values = count * file->views;
    memcpy(read->steps, from, count * sizeof *read->steps);
    if (values) memcpy(read->view_psnr, from + count * sizeof *read->steps, values * sizeof *read->view_psnr);
    if (!are_credits(read->steps, count, first + 1) || !are_finite(read->view_psnr, values)) return false;
    memcpy(&credits->steps[first], read->steps, count * sizeof *read->steps);
    if (values) memcpy(&credits->view_psnr[first * file->views], read->view_psnr, values * sizeof *read->view_psnr);
    return true;
}

static enum vw_status check_kept(const struct vw_lasting_file *file, const uint8_t whole[VW_HASH_BYTES]) {
    char hex[VW_HASH_HEX_BYTES];
    bool kept = false;
    vw_hash_to_hex(whole, hex);
    enum vw_status status = file->binding->is_kept(file->binding->context, VW_LASTING_CREDITS_FILE, hex, &kept);
    if (status || kept) return status;
    return vw_fail(VW_ERROR_INPUT,
                   "%s/%s: not used: the ledger does not hold its hash, so this run did not leave it; remove the file: "
                   "the pass starts anew",
                   file->out, VW_LASTING_CREDITS_FILE);
}

static enum vw_status read_credits(const struct vw_lasting_file *file, const uint8_t *bytes, size_t size_bytes,
                                   const char *header, const struct vw_lasting_rows *credits, uint64_t *first_step) {
    uint8_t hash[VW_HASH_BYTES], whole[VW_HASH_BYTES];
    size_t header_bytes = strlen(header), frame_bytes = header_bytes + VW_HASH_BYTES;
    bool known = size_bytes > frame_bytes && memcmp(bytes, header, header_bytes) == 0 &&
                 (size_bytes - frame_bytes) % row_bytes(file) == 0;
    uint64_t count = known ? (size_bytes - frame_bytes) / row_bytes(file) : 0;
    if (known && count <= file->steps) {
        vw_sha256_sealed(bytes, size_bytes - VW_HASH_BYTES, hash, whole);
        enum vw_status status = check_kept(file, whole);
        if (status) return status;
        struct vw_lasting_rows read = {.steps = vw_allocate(count, sizeof *read.steps),
                                       .view_psnr = vw_allocate(count * file->views, sizeof *read.view_psnr)};
        bool room = read.steps && read.view_psnr;
        known = room && memcmp(hash, bytes + size_bytes - VW_HASH_BYTES, VW_HASH_BYTES) == 0 &&
                take_rows(file, bytes + header_bytes, count, &read, credits);
        free(read.steps);
        free(read.view_psnr);
        if (!room) return VW_ERROR_MEMORY;
        *first_step = file->steps - count + 1;
        if (known) return VW_OK;
    }
    return vw_fail(VW_ERROR_INPUT, "%s/%s: damaged, or of another backward pass; remove the file: the pass starts anew",
                   file->out, VW_LASTING_CREDITS_FILE);
}

enum vw_status vw_lasting_file_load(const struct vw_lasting_file *file, const struct vw_lasting_rows *credits,
                                    uint64_t *first_step) {
    char *header = make_header(file);
    void *bytes = NULL;
    size_t size_bytes = 0;
    if (!header) return VW_ERROR_MEMORY;
    size_t most_bytes = strlen(header) + VW_HASH_BYTES + (size_t)file->steps * row_bytes(file);
    enum vw_status status = vw_file_read_inside(file->out, VW_LASTING_CREDITS_FILE, most_bytes, &bytes, &size_bytes);
    if (!status) status = read_credits(file, bytes, size_bytes, header, credits, first_step);
    free(bytes);
    free(header);
    return status;
}

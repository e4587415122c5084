#include "fuzz/fuzz.h"

#include <math.h>

#include "interface.h"
#include "train/renderers/splats/splat_file.h"

enum { SPLATS_MOST = 1000 };

void fuzz_splats(const uint8_t *data, size_t size_bytes) {
    struct vw_splat_file file;
    const char *path = fuzz_write("splats.ply", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_splat_file_read(path, SPLATS_MOST, &file);
    fuzz_check_message(status);
    if (!status) {
        fuzz_check(file.count > 0 && file.count <= SPLATS_MOST && file.degree <= VW_SPLAT_DEGREE_MAX,
                   "sizes are sound");
        for (size_t i = 0; i < (size_t)4 * VW_SPLAT_COLUMNS(file.degree) * file.count; i++)
            fuzz_check(isfinite(file.params[i]), "every number is finite");
    }
    vw_splat_file_free(&file);
}

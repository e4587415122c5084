#include "fuzz/fuzz.h"

#include "train/files/training_files.h"

enum { PARAM_BYTES = 16 };

void fuzz_field(const uint8_t *data, size_t size_bytes) {
    struct vw_hashed_file file;
    const char *path = fuzz_write_hashed("field.vwf", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_field_file_open(path, "{\"param_bytes\":16}", PARAM_BYTES, &file);
    fuzz_check_message(status);
    if (status) return;
    fuzz_check_hashed(&file, PARAM_BYTES);
    vw_hashed_file_close(&file);
}

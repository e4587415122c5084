#include "fuzz/fuzz.h"

#include "train/files/training_files.h"

enum { STATE_BYTES = 32, LAST_STEP = 100 };

void fuzz_checkpoint(const uint8_t *data, size_t size_bytes) {
    static const uint8_t run_id[VW_HASH_BYTES]; // 64 zeros in hexadecimal digits
    struct vw_hashed_file file;
    uint64_t step = UINT64_MAX;
    const char *path = fuzz_write_hashed("checkpoint_0.vwc", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_checkpoint_open(path, run_id, LAST_STEP, STATE_BYTES, &file, &step);
    fuzz_check_message(status);
    if (status) return;
    fuzz_check(step <= LAST_STEP, "the step is one up to the last");
    fuzz_check_hashed(&file, STATE_BYTES);
    vw_hashed_file_close(&file);
}

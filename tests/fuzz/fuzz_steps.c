#include "fuzz/fuzz.h"

#include <string.h>

#include "ledger/step_log.h"

void fuzz_steps(const uint8_t *data, size_t size_bytes) {
    struct vw_step_log log = {0};
    const char *path = fuzz_write("steps.csv", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_step_log_read(path, &log);
    fuzz_check_message(status);
    for (uint32_t i = 0; !status && i < log.record_count; i++) {
        const struct vw_step_record *record = &log.records[i];
        fuzz_check(record->step == i, "steps count from 0");
        fuzz_check(record->epoch < log.epochs, "an epoch is one of the log's");
        fuzz_check(i == 0 || record->view < log.image_count, "a step has a photo");
    }
    for (uint32_t i = 1; !status && i < log.image_count; i++)
        fuzz_check(strcmp(log.images[i - 1].name, log.images[i].name) < 0, "photos are in order, each once");
    vw_step_log_clear(&log);
}

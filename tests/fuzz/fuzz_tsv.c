#include "fuzz/fuzz.h"

#include <stdlib.h>
#include <string.h>

#include "scene/formats/nerfw_tsv.h"

void fuzz_tsv(const uint8_t *data, size_t size_bytes) {
    const char *path = fuzz_write("split.tsv", data, size_bytes);
    struct vw_tsv tsv = {0};
    fuzz_forget_message();
    enum vw_status status = vw_tsv_read(NULL, path, &tsv);
    fuzz_check_message(status);
    bool has_header = vw_tsv_has_header(NULL, path);
    // A file that can be read is one that is found, as long as its header fits into what is looked at.
    if (!status && memchr(data, '\n', size_bytes < 512 ? size_bytes : 512) && !has_header) abort();
    for (size_t i = 0; i < tsv.row_count; i++)
        if (!*tsv.rows[i].name || strpbrk(tsv.rows[i].name, "\t\r\n") || tsv.rows[i].name[0] == '/') abort();
    vw_tsv_clear(&tsv);
}

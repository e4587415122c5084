#include "cli/output/json_output.h"

#include <stdio.h>

enum vw_status vw_json_print(json_t *root) {
    if (!root) return vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON output");
    // In ASCII, so that no name in it controls a terminal.
    int failed = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_ENSURE_ASCII);
    json_decref(root);
    if (failed || putchar('\n') == EOF)
        return vw_fail(VW_ERROR_IO, "stdout: cannot write the JSON output; check where it goes");
    return VW_OK;
}

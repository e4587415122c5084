#include "cli/commands/commands.h"
#include "lab/commands/commands.h"
#include "report/page.h"

enum vw_status vw_lab_report(const struct vw_options *options) {
    static const char *const columns[] = {"metric", "method", "value", "ci_low", "ci_high", NULL};
    const struct vw_report_extra benchmarks = {"benchmark.csv", columns, vw_lab_page_script};
    return vw_report_make(options, &benchmarks);
}

// The page's evidence for trust in lasting credit and worth, as JSON values.
#ifndef VIEWWORTH_REPORT_HTML_TRUST_H
#define VIEWWORTH_REPORT_HTML_TRUST_H

#include <jansson.h>

#include "report/page.h"
#include "value/verdict.h"
#include "value/worth.h"

// Returns null if the run has no such rows, and NULL when memory is short. The caller drops the reference.
// {"image": [place in images, or null], "predicted": [dB], "measured": [dB], "correlation": r, or null where too few
// are measured, "least": r below which lasting credit is not to be trusted}
json_t *vw_html_gate(const struct vw_report_run *run);
// Returns the object of vw_verdict_to_json() (value/verdict.h).
json_t *vw_html_verdict(const struct vw_report_run *run);
enum vw_verdict vw_html_judge(const struct vw_report_run *run); // the same as a value
// Returns {"step": [...], "size": [...]}: at most about a thousand steps, evenly spread, and the first and the last.
json_t *vw_html_growth(const struct vw_report_run *run);
// Returns {"measured": [dB], "photos": [count], "means": {method: [mean of the scores of the photos trained on, or
// null]}} for those of dv_psnr, lasting_psnr and worth_psnr that have scores. At equal steps PSNR is linear in these
// means if photos add up.
json_t *vw_html_retrainings(const struct vw_report_run *run);
// Returns {"method": [...], "spearman": [...], "ci_low": [...], "ci_high": [...], "retrainings": count, "noise_db": dB
// or null, "ceiling": correlation or null}: how well left-out retrainings are predicted, worth_psnr first; null if too
// few are known.
json_t *vw_html_accuracy(const struct vw_worth_summary *worth);

#endif

// Advice on each train photo as the page and advice.csv say it: one word, and why in a word or two.
#ifndef VIEWWORTH_REPORT_TOLD_H
#define VIEWWORTH_REPORT_TOLD_H

#include "report/advice.h"
#include "report/page.h"

// Told by image: static texts, or borrowed from the images. NULL for a photo that is not trained on.
struct vw_told {
    const char *advice; // "keep", "look at", "leave out" or "cannot tell"
    const char *reason; // "lone view", "exposure", "duplicate", ...: "no reason found" if none is known
    const struct vw_ledger_score *score; // by the method that answers for a photo's value; NULL: none
};

// Makes the advice on a run's photos, with what its retrainings say of worth. Free it also after a failure.
enum vw_status vw_told_advise(const struct vw_report_run *run, struct vw_worth_summary *worth,
                              struct vw_advice *advice);

// Makes one per image of the run, owned by the caller. VW_ERROR_MEMORY.
enum vw_status vw_told_make(const struct vw_report_page *page, const struct vw_report_run *run,
                            const struct vw_advice *advice, struct vw_told **told);

// Makes advice.csv of a run of the page: header name,advice,reason,score,ci_low,ci_high,unit,method; the photos that
// are trained on, in the ledger's order. What is unknown is an empty field.
enum vw_status vw_report_make_advice_csv(const char *path, const struct vw_report_page *page,
                                         const struct vw_report_run *run, struct vw_csv_text *made);

#endif

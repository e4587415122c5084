// Advice on each train photo as the page and advice.csv say it: one word, and why in a word or two. It needs a run and
// no page.
#ifndef VIEWWORTH_REPORT_TOLD_H
#define VIEWWORTH_REPORT_TOLD_H

#include "report/advice.h"
#include "report/page.h"

enum vw_told_advice { VW_TOLD_NONE, VW_TOLD_KEEP, VW_TOLD_LOOK, VW_TOLD_UNCLEAR, VW_TOLD_DROP, VW_TOLD_ADVICE_COUNT };

// Told by image.
struct vw_told {
    enum vw_told_advice advice;          // VW_TOLD_NONE: the photo is not trained on
    const char *reason;                  // static: "lone view", "exposure", ...; NULL: the photo is not trained on
    const struct vw_ledger_score *score; // by the method that answers for a photo's value; NULL: none
};

// Returns a static word of advice.csv: "keep", "look", "unclear" or "drop"; NULL for VW_TOLD_NONE.
const char *vw_told_advice_name(enum vw_told_advice advice);

// Returns the static spelling of a reason that a run may find in a photo: "exposure", "noise", "blur", "pose" or
// "occluder"; NULL for other words and NULL.
const char *vw_told_known_reason(const char *word);

// Makes the advice on a run's photos, with what its retrainings say of worth. Free it also after a failure.
enum vw_status vw_told_advise(const struct vw_report_run *run, struct vw_worth_summary *worth,
                              struct vw_advice *advice);

// Makes one per image of the run, owned by the caller. VW_ERROR_MEMORY.
enum vw_status vw_told_make(const struct vw_report_run *run, const struct vw_advice *advice, struct vw_told **told);

// Makes advice.csv of a run: header name,advice,reason,score,ci_low,ci_high,unit,method; the photos that are trained
// on, in the ledger's order. What is unknown is an empty field.
enum vw_status vw_report_make_advice_csv(const char *path, const struct vw_report_run *run, struct vw_csv_text *made);

#endif

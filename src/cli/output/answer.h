// The answer to what value was asked, in its last lines: a verdict on the reconstruction, advice on the photos, and the
// command that comes next with its cost.
#ifndef VIEWWORTH_CLI_OUTPUT_ANSWER_H
#define VIEWWORTH_CLI_OUTPUT_ANSWER_H

#include "run/run.h"

struct vw_answer_photo {
    char *name;         // owned
    const char *reason; // static
    enum vw_advice_word advice;
    double score; // NaN: none
};

struct vw_answer {
    const char *out; // borrowed
    struct vw_reconstruction reconstruction;
    double times_at_most;     // times as long that the most accurate training takes
    double training_s;        // time of this training; NaN: unknown
    double unvalidated_share; // share of it that a training without validation takes
    bool has_report;
    struct vw_answer_photo *photos; // owned; those with advice, in any order
    size_t photo_count;
};

// Keeps what is to be said of a finished run until after it is closed, since retrainings may follow that change the
// advice; then that is taken from their results. Free the answer also after a failure. VW_ERROR_MEMORY.
enum vw_status vw_answer_begin(const struct vw_run *run, const char *out, struct vw_answer *answer);
enum vw_status vw_answer_take(struct vw_answer *answer, const struct vw_results *results);
// Sorts the photos and prints the answer.
void vw_answer_print(struct vw_answer *answer);
void vw_answer_free(struct vw_answer *answer);

#endif

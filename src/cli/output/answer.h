// The answer to what value was asked, in its last lines: a verdict on the reconstruction, advice on the photos as
// advice.csv has it, and the command that comes next with its cost.
#ifndef VIEWWORTH_CLI_OUTPUT_ANSWER_H
#define VIEWWORTH_CLI_OUTPUT_ANSWER_H

#include <jansson.h>

#include "run/run.h"

struct vw_answer {
    const char *out; // borrowed
    struct vw_reconstruction reconstruction;
    double times_at_most;     // times as long that the most accurate training takes
    double training_s;        // time of this training; NaN: unknown
    double unvalidated_share; // share of it that a training without validation takes
    bool has_report;
};

// Keeps what is to be said of a finished run until it is closed, since retrainings may follow that change the advice.
void vw_answer_begin(const struct vw_run *run, const char *out, struct vw_answer *answer);
// Reads OUT/advice.csv and prints the answer.
enum vw_status vw_answer_print(const struct vw_answer *answer);

// Returns {"counts": {"keep", "look", "unclear", "drop"}, "photos": [{"name", "advice", "reason"}]} of OUT; NULL when
// the table cannot be read or memory is short.
json_t *vw_answer_advice_to_json(const char *out);

#endif

#include "report/told.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "ledger/find_image.h"
#include "report/html_trust.h"
#include "value/lasting_scores.h"
#include "viewworth/value.h"

// ---- Reasons -------------------------------------------------------------------------------------------------------

const char *vw_told_known_reason(const char *word) {
    static const char *const reasons[] = {"exposure", "noise", "blur", "pose", "occluder"};
    for (size_t i = 0; word && i < VW_ARRAY_COUNT(reasons); i++)
        if (strcmp(reasons[i], word) == 0) return reasons[i];
    return NULL;
}

static bool is_duplicate(const json_t *table, const char *name) {
    const json_t *rows = json_object_get(table, "rows"), *header = json_object_get(table, "header");
    size_t column = 0;
    while (column < json_array_size(header) && strcmp(json_string_value(json_array_get(header, column)), "name") != 0)
        column++;
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const char *other = json_string_value(json_array_get(json_array_get(rows, i), column));
        if (other && strcmp(other, name) == 0) return true;
    }
    return false;
}

struct evidence {
    json_t *map, *duplicates; // owned
};

static const char *find_reason(const struct evidence *evidence, const struct vw_ledger_image *image, uint32_t place,
                               bool look, const char *otherwise) {
    const json_t *reasons = json_object_get(evidence->map, "reasons");
    const char *found = vw_told_known_reason(json_string_value(json_array_get(reasons, place)));
    // Renders explain why a photo fits badly; a photo that fits has a region of error by chance.
    bool by_render = found && (strcmp(found, "pose") == 0 || strcmp(found, "occluder") == 0);
    if (found && (look || !by_render)) return found;
    return is_duplicate(evidence->duplicates, image->name) ? "duplicate" : otherwise;
}

// ---- Advice --------------------------------------------------------------------------------------------------------

static enum vw_status summarise_worth(const struct vw_report_run *run, struct vw_worth_summary *worth) {
    const struct vw_worth_input input = {.retrainings = run->retrainings,
                                         .retraining_count = run->retraining_count,
                                         .images = run->images,
                                         .image_count = run->image_count,
                                         .scores = run->scores,
                                         .score_count = run->score_count};
    *worth = (struct vw_worth_summary){0};
    return run->retraining_count ? vw_worth_summarise(&input, worth) : VW_OK;
}

const char *vw_told_advice_name(enum vw_told_advice advice) {
    static const char *const names[VW_TOLD_ADVICE_COUNT] = {NULL, "keep", "look", "unclear", "drop"};
    return names[advice];
}

enum vw_status vw_told_advise(const struct vw_report_run *run, struct vw_worth_summary *worth,
                              struct vw_advice *advice) {
    enum vw_status status = summarise_worth(run, worth);
    if (status) return status;
    return vw_advice_make(run->scores, run->score_count, run->images, run->image_count, worth, vw_html_judge(run),
                          advice);
}

static bool has_zero(const char *method) {
    uint32_t count, i = 0;
    const struct vw_value_method *methods = vw_value_methods(&count);
    while (i < count && strcmp(methods[i].name, method) != 0) i++;
    return i < count && methods[i].has_zero;
}

// Returns whether the basis may tell photos apart at all: worth that retrainings confirm, lasting credit that the gate
// does not refute, or credit.
static bool is_trusted(const struct vw_report_run *run, const struct vw_advice *advice) {
    if (vw_html_judge(run) == VW_VERDICT_TOO_COARSE) return false;
    if (!advice->basis) return true;
    if (!advice->by_order) return advice->tested;
    return !run->lasting.check_count || vw_lasting_gate(&run->lasting, false) >= vw_lasting_gate_least;
}

static void judge(const struct evidence *evidence, const struct vw_ledger_image *image, uint32_t place, uint8_t marks,
                  bool trusted, struct vw_told *told) {
    bool helps = told->score && has_zero(told->score->method) && told->score->ci_low > 0;
    if (marks & VW_ADVICE_LOOK)
        told->advice = VW_TOLD_LOOK, told->reason = find_reason(evidence, image, place, true, "no reason found");
    else if (marks & VW_ADVICE_LONE) told->advice = VW_TOLD_KEEP, told->reason = "lone view";
    else if (trusted && (marks & VW_ADVICE_REMOVABLE))
        told->advice = VW_TOLD_DROP, told->reason = find_reason(evidence, image, place, false, "adds little");
    else if (trusted && (marks & VW_ADVICE_IRREPLACEABLE)) told->advice = VW_TOLD_KEEP, told->reason = "among the best";
    else if (trusted && helps) told->advice = VW_TOLD_KEEP, told->reason = "helps";
    else told->advice = VW_TOLD_UNCLEAR, told->reason = find_reason(evidence, image, place, false, "within noise");
}

static json_t *parse(const char *text) { return text ? vw_json_load(text, strlen(text), 0, NULL) : NULL; }

enum vw_status vw_told_make(const struct vw_report_run *run, const struct vw_advice *advice, struct vw_told **told) {
    struct evidence evidence = {.map = parse(run->map_json), .duplicates = parse(run->duplicates_json)};
    *told = vw_allocate(run->image_count, sizeof **told);
    const char *method = run->score_count ? vw_value_main_method(run->scores, run->score_count) : "";
    for (uint32_t i = 0; *told && i < run->score_count; i++) {
        const struct vw_ledger_score *score = &run->scores[i];
        const struct vw_ledger_image *image = vw_ledger_find_image(run->images, run->image_count, score->image_id);
        if (image && strcmp(score->method, method) == 0 && score->visits && isfinite(score->value))
            (*told)[image - run->images].score = score;
    }
    bool trusted = is_trusted(run, advice);
    for (uint32_t i = 0; *told && i < run->image_count; i++)
        if (strcmp(run->images[i].split, "train") == 0)
            judge(&evidence, &run->images[i], i, advice->marks[i], trusted, &(*told)[i]);
    json_decref(evidence.map);
    json_decref(evidence.duplicates);
    return *told ? VW_OK : VW_ERROR_MEMORY;
}

// ---- The table -----------------------------------------------------------------------------------------------------

struct table {
    const struct vw_report_run *run;
    const struct vw_told *told;
};

static void print_advice(FILE *stream, const void *context) {
    const struct table *table = context;
    fputs("name,advice,reason,score,ci_low,ci_high,unit,method\n", stream);
    for (uint32_t i = 0; i < table->run->image_count; i++) {
        const struct vw_told *told = &table->told[i];
        const struct vw_ledger_score *score = told->score;
        if (!told->advice) continue;
        vw_csv_print(stream, "t,t,t", table->run->images[i].name, vw_told_advice_name(told->advice), told->reason);
        if (score)
            vw_csv_print(stream, ",r,r,r,t,t\n", score->value, score->ci_low, score->ci_high, score->unit,
                         score->method);
        else fputs(",,,,,\n", stream);
    }
}

enum vw_status vw_report_make_advice_csv(const char *path, const struct vw_report_run *run, struct vw_csv_text *made) {
    struct vw_advice advice = {0};
    struct vw_worth_summary worth;
    struct vw_told *told = NULL;
    enum vw_status status = vw_told_advise(run, &worth, &advice);
    if (!status) status = vw_told_make(run, &advice, &told);
    if (!status) status = vw_csv_make_text(path, print_advice, &(struct table){run, told}, made);
    vw_advice_free(&advice);
    free(told);
    return status;
}

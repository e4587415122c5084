#include "report/html_data.h"

#include <math.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "ledger/find_image.h"
#include "report/html_trust.h"
#include "report/told.h"
#include "value/repair.h"
#include "value/series.h"

enum { STEPS_SHOWN = 1000 };    // more than a screen has pixels for
enum { VISITS_SHOWN = 200000 }; // over all photos together: more epochs are summed in groups
#define CREDIT_UNIT_DB 1e-5     // credits are whole numbers of it, which take half the place

// Records the failure. jansson returns NULL when memory is short and refuses a NULL child everywhere, so that it
// suffices to check whether all could be added. A child that was not added is freed, and must not be filled.
static enum vw_status out_of_memory(void) {
    return vw_fail(VW_ERROR_MEMORY, "out of memory for the data of the report");
}

static int put(json_t *object, const char *key, json_t *value) { return json_object_set_new(object, key, value); }

// Returns the child itself, to be filled; NULL when it could not be added.
static json_t *put_child(json_t *object, const char *key, json_t *child) {
    return put(object, key, child) ? NULL : child;
}

static json_t *append_child(json_t *array, json_t *child) { return json_array_append_new(array, child) ? NULL : child; }

static int put_text(json_t *object, const char *key, const char *text) {
    return put(object, key, vw_json_string(text));
}

static int put_count(json_t *object, const char *key, uint64_t count) {
    return put(object, key, json_integer((json_int_t)count));
}

// ---- Pictures ------------------------------------------------------------------------------------------------------

// Returns a data URI, or null without a picture.
static json_t *picture_to_json(const struct vw_report_picture *picture, const char *media_type) {
    if (!picture->data) return json_null();
    size_t prefix_bytes = strlen("data:;base64,") + strlen(media_type);
    size_t base64_bytes = sodium_base64_encoded_len(picture->size_bytes, sodium_base64_VARIANT_ORIGINAL);
    char *text = vw_allocate(prefix_bytes + base64_bytes, 1);
    if (!text) return NULL;
    snprintf(text, prefix_bytes + 1, "data:%s;base64,", media_type);
    sodium_bin2base64(text + prefix_bytes, base64_bytes, picture->data, picture->size_bytes,
                      sodium_base64_VARIANT_ORIGINAL);
    json_t *uri = json_string_nocheck(text);
    free(text);
    return uri;
}

static json_t *thumbnails_to_json(const struct vw_report_run *run) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < run->image_count; i++)
        vw_json_append(&array, picture_to_json(&run->thumbnails[i], "image/webp"));
    return array;
}

// Returns the set's place among the page's; -1 when no earlier run has it.
static int find_set(const struct vw_report_page *page, uint32_t run) {
    for (uint32_t i = 0, set = 0; i < run; i++) {
        if (page->runs[i].thumbnails == page->runs[run].thumbnails) return (int)set;
        bool first = page->runs[i].thumbnails != NULL;
        for (uint32_t before = 0; before < i; before++)
            first = first && page->runs[before].thumbnails != page->runs[i].thumbnails;
        set += first;
    }
    return -1;
}

static int put_thumbnails(const struct vw_report_page *page, uint32_t place, json_t *sets, json_t *object) {
    if (!page->runs[place].thumbnails) return put(object, "thumbnails", json_null());
    int set = find_set(page, place);
    if (set >= 0) return put_count(object, "thumbnails", (uint64_t)set);
    return put_count(object, "thumbnails", json_array_size(sets)) |
           json_array_append_new(sets, thumbnails_to_json(&page->runs[place]));
}

// ---- Rows in columns -----------------------------------------------------------------------------------------------

// Adds a value to the column `key`, which is made when it is missing.
static int add(json_t *columns, const char *key, json_t *value) {
    json_t *column = json_object_get(columns, key);
    if (!column && put(columns, key, json_array()) == 0) column = json_object_get(columns, key);
    return json_array_append_new(column, value);
}

static json_t *rank_to_json(uint32_t rank) { return rank ? json_integer(rank) : json_null(); }

static int put_images(const struct vw_report_run *run, json_t *object) {
    json_t *columns = json_object();
    bool weighted = vw_images_have_weights(run->images, run->image_count);
    int failed = 0;
    for (uint32_t i = 0; i < run->image_count; i++) {
        const struct vw_ledger_image *image = &run->images[i];
        if (weighted) failed |= add(columns, "weight", vw_json_real(image->weight));
        failed |= add(columns, "name", vw_json_string(image->name));
        failed |= add(columns, "split", vw_json_string(image->split));
        failed |= add(columns, "provider", vw_json_string(image->provider ? image->provider : ""));
        failed |= add(columns, "ground_truth", vw_json_string(image->ground_truth));
    }
    return failed | put(object, "images", columns);
}

static int add_score(const struct vw_ledger_score *score, uint32_t image, json_t *scores) {
    json_t *columns = json_object_get(scores, score->method);
    int failed = 0;
    if (!columns) {
        failed |= put(scores, score->method, json_object());
        columns = json_object_get(scores, score->method);
        failed |= put_text(columns, "unit", score->unit);
    }
    failed |= add(columns, "image", json_integer(image));
    failed |= add(columns, "value", vw_json_real(score->value));
    failed |= add(columns, "ci_low", vw_json_real(score->ci_low));
    failed |= add(columns, "ci_high", vw_json_real(score->ci_high));
    failed |= add(columns, "visits", json_integer(score->visits));
    failed |= add(columns, "rank_ci_low", rank_to_json(score->rank_ci_low));
    failed |= add(columns, "rank_ci_high", rank_to_json(score->rank_ci_high));
    return failed;
}

static enum vw_status put_scores(const struct vw_report_run *run, json_t *object) {
    json_t *scores = put_child(object, "scores", json_object());
    int failed = !scores;
    for (uint32_t i = 0; !failed && i < run->score_count; i++) {
        const struct vw_ledger_image *image = NULL;
        enum vw_status status = vw_ledger_require_image(run->images, run->image_count, run->scores[i].image_id, &image);
        if (status) return vw_fail_context(status, "%s: scores", run->label);
        failed = add_score(&run->scores[i], (uint32_t)(image - run->images), scores);
    }
    return failed ? out_of_memory() : VW_OK;
}

// ---- Steps ---------------------------------------------------------------------------------------------------------

struct totals {
    uint64_t nonfinite, clamped, floored, epochs;
    double first_db, last_db;
};

static struct totals count(const struct vw_report_run *run) {
    struct totals totals = {.first_db = NAN, .last_db = NAN};
    for (uint64_t i = 0; i < run->record_count; i++) {
        const struct vw_step_record *record = &run->records[i];
        totals.nonfinite += record->nonfinite;
        totals.clamped += record->clamped_count > 0;
        totals.floored += record->floored_views > 0;
        totals.epochs = record->view == VW_RECORD_UNTRAINED ? totals.epochs : record->epoch + UINT64_C(1);
        if (!isfinite(record->val_psnr)) continue;
        if (isnan(totals.first_db)) totals.first_db = record->val_psnr;
        totals.last_db = record->val_psnr;
    }
    return totals;
}

// Puts every n-th step and the last.
static int put_steps(const struct vw_report_run *run, json_t *object) {
    struct totals totals = count(run);
    json_t *steps = put_child(object, "steps", json_object());
    uint64_t stride = run->record_count / STEPS_SHOWN + 1;
    int failed = !steps;
    for (uint64_t i = 0; i < run->record_count; i++) {
        const struct vw_step_record *record = &run->records[i];
        if (i % stride != 0 && i + 1 != run->record_count) continue;
        failed |= add(steps, "step", json_integer((json_int_t)record->step));
        failed |= add(steps, "epoch", json_integer(record->epoch));
        failed |= add(steps, "psnr", vw_json_real(record->val_psnr));
        failed |= add(steps, "l1", vw_json_real(record->val_l1));
    }
    failed |= put_count(steps, "stride", stride);
    failed |= put_count(steps, "count", run->record_count ? run->records[run->record_count - 1].step : 0);
    failed |= put_count(steps, "nonfinite", totals.nonfinite) | put_count(steps, "clamped", totals.clamped);
    failed |= put_count(steps, "floored", totals.floored) | put_count(steps, "epochs", totals.epochs);
    failed |=
        put(steps, "first_psnr", vw_json_real(totals.first_db)) | put(steps, "last_psnr", vw_json_real(totals.last_db));
    return failed;
}

// ---- Repair curves -------------------------------------------------------------------------------------------------

static int put_curve(const struct vw_repair_curve *curve, uint32_t count, json_t *object) {
    int failed = !object;
    for (uint32_t k = 0; k < count && !failed; k++) {
        failed |= add(object, "excess", vw_json_real(curve->excess_db[k]));
        failed |= add(object, "stderr", vw_json_real(curve->stderr_db[k]));
    }
    return failed;
}

static int put_curves(const struct vw_repair_curves *curves, uint32_t image_count, json_t *object) {
    if (!curves->horizon_count) return put(object, "repair", json_null());
    json_t *repair = put_child(object, "repair", json_object());
    json_t *photos = put_child(repair, "photos", json_array()), *kinds = put_child(repair, "kinds", json_array());
    int failed = !photos || !kinds;
    for (uint32_t k = 0; k < curves->horizon_count; k++)
        failed |= add(repair, "steps", json_integer(curves->horizons[k]));
    for (uint32_t i = 0; i < image_count && !failed; i++)
        failed = curves->photos[i].visits[0]
                     ? put_curve(&curves->photos[i], curves->horizon_count, append_child(photos, json_object()))
                     : json_array_append_new(photos, json_null());
    for (uint32_t i = 0; i < curves->kind_count && !failed; i++) {
        json_t *kind = append_child(kinds, json_object());
        failed = put_text(kind, "kind", curves->kinds[i].ground_truth) |
                 put_count(kind, "photos", curves->kinds[i].photo_count) |
                 put_curve(&curves->kinds[i].curve, curves->horizon_count, kind);
    }
    return failed;
}

static enum vw_status put_repair(const struct vw_report_run *run, json_t *object) {
    const struct vw_value_input input = {.records = run->records,
                                         .record_count = run->record_count,
                                         .burn_in_epochs = run->burn_in_epochs,
                                         .images = run->images,
                                         .image_count = run->image_count};
    struct vw_repair_curves curves;
    enum vw_status status = vw_repair_curves_make(&input, &curves);
    if (!status && put_curves(&curves, run->image_count, object)) status = out_of_memory();
    vw_repair_curves_free(&curves);
    return status;
}

// ---- Credit by epoch -----------------------------------------------------------------------------------------------

// Sums by photo and group of neighbouring epochs.
struct credits {
    double *sums;  // owned; image * group_count + group
    bool *counted; // owned; by image: it has a visit
    uint32_t group_count, group_epochs;
};

static enum vw_status sum_credits(const struct vw_report_run *run, struct credits *credits) {
    const struct vw_value_input input = {.records = run->records,
                                         .record_count = run->record_count,
                                         .burn_in_epochs = run->burn_in_epochs,
                                         .images = run->images,
                                         .image_count = run->image_count};
    struct vw_series series = {0};
    enum vw_status status = vw_series_make(&input, VW_MEASURE_PSNR, VW_FORM_STEP, &series);
    uint64_t cells = (uint64_t)series.epoch_count * run->image_count;
    credits->group_epochs = (uint32_t)(cells / VISITS_SHOWN) + 1;
    credits->group_count = (series.epoch_count + credits->group_epochs - 1) / credits->group_epochs;
    credits->sums = vw_allocate((size_t)credits->group_count * run->image_count, sizeof *credits->sums);
    credits->counted = vw_allocate(run->image_count, sizeof *credits->counted);
    if (!status && (!credits->sums || !credits->counted)) status = VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < series.count && !status; i++) {
        const struct vw_visit *visit = &series.visits[i];
        if (!isfinite(visit->delta)) continue;
        credits->counted[visit->image] = true;
        credits->sums[(size_t)visit->image * credits->group_count + visit->epoch / credits->group_epochs] +=
            visit->delta;
    }
    vw_series_free(&series);
    return status;
}

static int put_credit_rows(const struct credits *credits, uint32_t image_count, json_t *object) {
    json_t *rows = put_child(object, "rows", json_array());
    int failed = !rows;
    for (uint32_t i = 0; i < image_count && !failed; i++) {
        json_t *row = append_child(rows, credits->counted[i] ? json_array() : json_null());
        failed = !row;
        for (uint32_t g = 0; g < credits->group_count && credits->counted[i] && !failed; g++) {
            double sum_db = credits->sums[(size_t)i * credits->group_count + g];
            failed = json_array_append_new(row, json_integer((json_int_t)llround(sum_db / CREDIT_UNIT_DB)));
        }
    }
    return failed;
}

static enum vw_status put_credit(const struct vw_report_run *run, json_t *object) {
    struct credits credits = {0};
    enum vw_status status = sum_credits(run, &credits);
    if (!status && !credits.group_count) status = put(object, "credit", json_null()) ? out_of_memory() : VW_OK;
    else if (!status) {
        json_t *credit = put_child(object, "credit", json_object());
        if (!credit || put(credit, "unit", json_real(CREDIT_UNIT_DB)) ||
            put_count(credit, "first_epoch", run->burn_in_epochs) ||
            put_count(credit, "group_epochs", credits.group_epochs) ||
            put_credit_rows(&credits, run->image_count, credit))
            status = out_of_memory();
    }
    free(credits.sums);
    free(credits.counted);
    return status;
}

// ---- Advice --------------------------------------------------------------------------------------------------------

static int put_marked(const struct vw_advice *advice, uint32_t image_count, enum vw_advice_mark mark, const char *key,
                      json_t *object) {
    json_t *list = put_child(object, key, json_array());
    int failed = !list;
    for (uint32_t i = 0; i < image_count && !failed; i++)
        if (advice->marks[i] & mark) failed = json_array_append_new(list, json_integer(i));
    return failed;
}

static int put_told(const struct vw_told *told, uint32_t image_count, json_t *object) {
    json_t *columns = put_child(object, "told", json_object());
    int failed = !columns;
    for (uint32_t i = 0; i < image_count && !failed; i++)
        failed = add(columns, "advice", vw_json_string(vw_told_advice_name(told[i].advice))) |
                 add(columns, "reason", vw_json_string(told[i].reason));
    return failed;
}

static int put_marks(const struct vw_advice *advice, uint32_t image_count, json_t *object) {
    return put_text(object, "basis", advice->basis) || put(object, "by_order", json_boolean(advice->by_order)) ||
           put(object, "tested", json_boolean(advice->tested)) ||
           put_marked(advice, image_count, VW_ADVICE_REMOVABLE, "removable", object) ||
           put_marked(advice, image_count, VW_ADVICE_IRREPLACEABLE, "irreplaceable", object) ||
           put_marked(advice, image_count, VW_ADVICE_LOOK, "look", object) ||
           put_marked(advice, image_count, VW_ADVICE_LONE, "lone", object);
}

static enum vw_status put_advice(const struct vw_report_run *run, json_t *object) {
    struct vw_worth_summary worth;
    struct vw_advice advice = {0};
    struct vw_told *told = NULL;
    enum vw_status status = vw_told_advise(run, &worth, &advice);
    if (!status) status = vw_told_make(run, &advice, &told);
    json_t *marks = status ? NULL : put_child(object, "advice", json_object());
    if (!status && (!marks || put_marks(&advice, run->image_count, marks) || put_told(told, run->image_count, marks) ||
                    put(object, "accuracy", vw_html_accuracy(&worth))))
        status = out_of_memory();
    vw_advice_free(&advice);
    free(told);
    return status;
}

// ---- The matrix ----------------------------------------------------------------------------------------------------

// Returns its place in `images`; null for one that they lack.
static json_t *image_place(const struct vw_report_run *run, uint32_t image_id) {
    const struct vw_ledger_image *image = vw_ledger_find_image(run->images, run->image_count, image_id);
    return image ? json_integer(image - run->images) : json_null();
}

static int put_rows(const struct vw_matrix *matrix, const double *values, const char *key, json_t *object) {
    json_t *rows = put_child(object, key, json_array());
    int failed = !rows;
    for (uint32_t photo = 0; photo < matrix->photo_count; photo++) {
        json_t *row = append_child(rows, json_array());
        failed |= !row;
        for (uint32_t view = 0; view < matrix->view_count; view++)
            failed |= json_array_append_new(row, vw_json_real(values[(size_t)photo * matrix->view_count + view]));
    }
    return failed;
}

static int put_matrix(const struct vw_report_run *run, json_t *object) {
    const struct vw_matrix *matrix = run->matrix;
    if (!matrix || !matrix->view_count || !matrix->visit_count) return put(object, "matrix", json_null());
    json_t *columns = put_child(object, "matrix", json_object());
    int failed = !columns;
    failed |= put_rows(matrix, matrix->psnr, "psnr", columns) | put_rows(matrix, matrix->l1, "l1", columns);
    for (uint32_t i = 0; i < matrix->photo_count; i++) {
        failed |= add(columns, "photo", image_place(run, matrix->photos[i]));
        failed |= add(columns, "stderr", vw_json_real(run->standard_errors[i]));
    }
    for (uint32_t i = 0; i < matrix->view_count; i++) {
        const struct vw_view_evidence *view = &run->views[i];
        failed |= add(columns, "view", image_place(run, matrix->views[i]));
        failed |= add(columns, "end_psnr", vw_json_real(view->end_psnr));
        failed |= add(columns, "agreement", vw_json_real(view->agreement));
        failed |= add(columns, "without", vw_json_real(view->without));
        failed |= add(columns, "disagrees", json_boolean(view->disagrees));
        failed |= add(columns, "lone", json_boolean(view->lone));
        failed |= add(columns, "stays_low", json_boolean(view->stays_low));
    }
    return failed;
}

// ---- The page ------------------------------------------------------------------------------------------------------

static int put_row(const struct vw_report_run *run, json_t *object) {
    const struct vw_ledger_run *row = run->row;
    json_t *fields = put_child(object, "run", json_object());
    int failed = (fields ? 0 : -1) | put_text(object, "label", run->label);
    const struct {
        const char *key, *text;
    } texts[] = {
        {"run_id", row->run_id},
        {"scene", row->scene_path},
        {"scene_hash", row->scene_hash},
        {"subset_hash", row->subset_hash},
        {"device", row->device},
        {"driver", row->driver},
        {"shader_hash", row->shader_hash},
        {"version", row->version},
        {"started_utc", row->started_utc},
        {"status", row->status},
        {"finished_utc", row->finished_utc},
        {"head", run->head},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(texts); i++) failed |= put_text(fields, texts[i].key, texts[i].text);
    return failed | put(fields, "seed", json_integer(row->seed));
}

static enum vw_status put_parsed(const char *text, const char *label, const char *what, json_t *object,
                                 const char *key) {
    json_error_t error;
    json_t *value = vw_json_load(text ? text : "null", text ? strlen(text) : 4, JSON_DECODE_ANY, &error);
    if (!value) return vw_fail(VW_ERROR_INPUT, "%s: %s: line %d: %s", label, what, error.line, error.text);
    return put(object, key, value) ? out_of_memory() : VW_OK;
}

static enum vw_status add_run(const struct vw_report_page *page, uint32_t place, json_t *sets, json_t *runs) {
    const struct vw_report_run *run = &page->runs[place];
    json_t *object = append_child(runs, json_object());
    int failed = put_row(run, object) | put_images(run, object) | put_thumbnails(page, place, sets, object);
    failed |= put_steps(run, object) | put_matrix(run, object);
    failed |= put(object, "gate", vw_html_gate(run)) | put(object, "growth", vw_html_growth(run));
    failed |= put(object, "retrainings", vw_html_retrainings(run)) | put(object, "verdict", vw_html_verdict(run));
    enum vw_status status = failed ? out_of_memory() : put_scores(run, object);
    if (!status) status = put_repair(run, object);
    if (!status) status = put_credit(run, object);
    if (!status) status = put_advice(run, object);
    if (!status)
        status = put_parsed(run->row->config_json, run->label, "run.config_json of the ledger", object, "config");
    if (!status)
        status = put_parsed(run->row->effects_json, run->label, "run.effects_json of the ledger", object, "effects");
    if (!status) status = put_parsed(run->map_json, run->label, "map.json", object, "map");
    if (!status) status = put_parsed(run->residuals_json, run->label, "residuals.json", object, "residuals");
    if (!status && run->next_json) status = put_parsed(run->next_json, run->label, "next.json", object, "next");
    if (!status) status = put_parsed(run->row->plan_json, run->label, "run.plan_json of the ledger", object, "plan");
    if (!status)
        status = put_parsed(run->row->scene_options_json, run->label, "run.scene_options_json of the ledger", object,
                            "scene_options");
    return status;
}

static enum vw_status add_document(const struct vw_report_document *document, json_t *documents) {
    json_t *object = append_child(documents, json_object()), *pictures = put_child(object, "pictures", json_object());
    json_t *thumbnails = put_child(object, "thumbnails", json_object());
    int failed = put_text(object, "kind", document->kind) | put_text(object, "label", document->label);
    failed |= put_text(object, "file", document->file);
    for (uint32_t i = 0; i < document->picture_count; i++)
        failed |= put(pictures, document->picture_files[i], picture_to_json(&document->pictures[i], "image/png"));
    for (uint32_t i = 0; i < document->thumbnail_count; i++)
        failed |=
            put(thumbnails, document->thumbnail_names[i], picture_to_json(&document->thumbnails[i], "image/webp"));
    if (failed) return out_of_memory();
    return put_parsed(document->json, document->label, document->file, object, "content");
}

enum vw_status vw_html_data_make(const struct vw_report_page *page, json_t **data) {
    json_t *root = json_object(), *sets = json_array(), *runs = json_array(), *documents = json_array();
    int failed = put(root, "thumbnail_sets", sets) | put(root, "runs", runs) | put(root, "documents", documents);
    failed |= put_text(root, "version", page->version) | put_text(root, "default_method", page->default_method);
    enum vw_status status =
        failed ? out_of_memory() : put_parsed(page->methods_json, "report", "the methods", root, "methods");
    for (uint32_t i = 0; !status && i < page->run_count; i++) status = add_run(page, i, sets, runs);
    for (uint32_t i = 0; !status && i < page->document_count; i++)
        status = add_document(&page->documents[i], documents);
    if (status) json_decref(root);
    else *data = root;
    return status;
}

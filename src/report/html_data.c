#include "report/page.h"

#include <math.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "base/rows.h"
#include "ledger/find_image.h"
#include "report/tables.h"
#include "value/lasting_scores.h"
#include "value/series.h"
#include "viewworth/version.h"

enum { STEPS_SHOWN = 1000 };    // more than a screen has pixels for
enum { VISITS_SHOWN = 200000 }; // over all photos together: more epochs are summed in groups
#define CREDIT_UNIT_DB 1e-5     // credits are whole numbers of it, which take half the place

// Values are added to objects that become NULL when memory is short (base/json.h); what is made is checked at the end.

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

static json_t *thumbnails_to_json(const struct vw_results *run) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < run->input.image_count; i++)
        vw_json_append(&array, picture_to_json(&run->thumbnails[i], "image/webp"));
    return array;
}

// Adds the run's thumbnails unless an earlier run has them; `places` are those of the runs' sets. Returns the place.
static json_t *set_of(const struct vw_report_page *page, uint32_t run, size_t *places, json_t **sets) {
    if (!page->runs[run]->thumbnails) return json_null();
    places[run] = json_array_size(*sets);
    for (uint32_t i = 0; i < run; i++)
        if (page->runs[i]->thumbnails == page->runs[run]->thumbnails) places[run] = places[i];
    if (places[run] == json_array_size(*sets)) vw_json_append(sets, thumbnails_to_json(page->runs[run]));
    return json_integer((json_int_t)places[run]);
}

// ---- Images and scores ---------------------------------------------------------------------------------------------

// Returns its place in the run's images; null for one that they lack.
static json_t *place_of(const struct vw_results *run, uint32_t image_id) {
    const struct vw_ledger_image *image = vw_ledger_find_image(run->input.images, run->input.image_count, image_id);
    return image ? json_integer(image - run->input.images) : json_null();
}

static const struct vw_column image_columns[] = {
    VW_COLUMN(struct vw_ledger_image, TEXT, name),     VW_COLUMN(struct vw_ledger_image, TEXT, split),
    VW_COLUMN(struct vw_ledger_image, TEXT, provider), VW_COLUMN(struct vw_ledger_image, TEXT_OR_NULL, ground_truth),
    VW_COLUMN(struct vw_ledger_image, REAL, weight), // the last, which not all runs have
};

static json_t *images_to_json(const struct vw_results *run) {
    struct vw_rows images = VW_ROWS(image_columns, run->input.images, run->input.image_count);
    images.column_count -= !vw_images_have_weights(run->input.images, run->input.image_count);
    return vw_rows_to_arrays(&images);
}

static const struct vw_column score_columns[] = {
    VW_COLUMN(struct vw_ledger_score, REAL_OR_NULL, value),   VW_COLUMN(struct vw_ledger_score, REAL_OR_NULL, ci_low),
    VW_COLUMN(struct vw_ledger_score, REAL_OR_NULL, ci_high), VW_COLUMN(struct vw_ledger_score, COUNT, visits),
    VW_COLUMN(struct vw_ledger_score, RANK, rank_ci_low),     VW_COLUMN(struct vw_ledger_score, RANK, rank_ci_high),
};

static enum vw_status add_scores(const struct vw_results *run, json_t **object) {
    json_t *methods = json_object();
    const struct vw_ledger_image *image;
    enum vw_status status = VW_OK;
    for (uint32_t first = 0, next; first < run->score_count && !status; first = next) {
        json_t *images = json_array();
        const struct vw_ledger_score *scores = &run->scores[first];
        for (next = first; next < run->score_count && !status; next++) {
            if (strcmp(run->scores[next].method, scores->method) != 0) break;
            status =
                vw_ledger_require_image(run->input.images, run->input.image_count, run->scores[next].image_id, &image);
            vw_json_append(&images, place_of(run, run->scores[next].image_id));
        }
        const struct vw_rows rows = VW_ROWS(score_columns, scores, next - first);
        json_t *arrays = vw_rows_to_arrays(&rows);
        vw_json_set(&arrays, "image", images);
        vw_json_set(&arrays, "unit", vw_json_string(scores->unit));
        vw_json_set(&methods, scores->method, arrays);
    }
    vw_json_set(object, "scores", methods);
    return status ? vw_fail_context(status, "%s: scores", run->label) : VW_OK;
}

// ---- Steps ---------------------------------------------------------------------------------------------------------

static const struct vw_column step_columns[] = {
    VW_COLUMN(struct vw_step_record, COUNT64, step),
    VW_COLUMN(struct vw_step_record, COUNT, epoch),
    VW_COLUMN_AS("psnr", struct vw_step_record, REAL_OR_NULL, val_psnr),
    VW_COLUMN_AS("l1", struct vw_step_record, REAL_OR_NULL, val_l1),
};

struct totals {
    uint64_t stride, count, nonfinite, clamped, floored, epochs;
    double first_psnr, last_psnr;
};
static const struct vw_column total_columns[] = {
    VW_COLUMN(struct totals, COUNT64, stride),          VW_COLUMN(struct totals, COUNT64, count),
    VW_COLUMN(struct totals, COUNT64, nonfinite),       VW_COLUMN(struct totals, COUNT64, clamped),
    VW_COLUMN(struct totals, COUNT64, floored),         VW_COLUMN(struct totals, COUNT64, epochs),
    VW_COLUMN(struct totals, REAL_OR_NULL, first_psnr), VW_COLUMN(struct totals, REAL_OR_NULL, last_psnr),
};

static struct totals count(const struct vw_results *run) {
    uint64_t record_count = run->input.record_count;
    struct totals totals = {.stride = record_count / STEPS_SHOWN + 1, .first_psnr = NAN, .last_psnr = NAN};
    if (record_count) totals.count = run->input.records[record_count - 1].step;
    for (uint64_t i = 0; i < record_count; i++) {
        const struct vw_step_record *record = &run->input.records[i];
        totals.nonfinite += record->nonfinite;
        totals.clamped += record->clamped_count > 0;
        totals.floored += record->floored_views > 0;
        totals.epochs = record->view == VW_RECORD_UNTRAINED ? totals.epochs : record->epoch + UINT64_C(1);
        if (!isfinite(record->val_psnr)) continue;
        if (isnan(totals.first_psnr)) totals.first_psnr = record->val_psnr;
        totals.last_psnr = record->val_psnr;
    }
    return totals;
}

// Returns every n-th row and the last, in arrays: at most about a thousand.
static json_t *thinned_to_json(struct vw_rows rows, uint64_t row_count) {
    uint64_t stride = row_count / STEPS_SHOWN + 1;
    char *shown = vw_allocate(row_count / stride + 2, rows.row_bytes);
    if (!shown) return NULL;
    for (uint64_t i = 0; i < row_count; i++)
        if (i % stride == 0 || i + 1 == row_count)
            memcpy(shown + rows.row_bytes * rows.count++, (const char *)rows.rows + i * rows.row_bytes, rows.row_bytes);
    rows.rows = shown;
    json_t *arrays = vw_rows_to_arrays(&rows);
    free(shown);
    return arrays;
}

static json_t *steps_to_json(const struct vw_results *run) {
    struct totals totals = count(run);
    const struct vw_rows total = VW_ROWS(total_columns, &totals, 1);
    json_t *steps = thinned_to_json(VW_ROWS(step_columns, run->input.records, 0), run->input.record_count);
    json_t *of_all = vw_row_to_json(&total, 0);
    if (!of_all || json_object_update(steps, of_all)) {
        json_decref(steps);
        steps = NULL;
    }
    json_decref(of_all);
    return steps;
}

// ---- Credit by epoch -----------------------------------------------------------------------------------------------

static json_t *reals_to_json(const double *values, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) vw_json_append(&array, vw_json_real(values[i]));
    return array;
}

// Sums by photo and group of neighbouring epochs.
struct credits {
    double *sums;  // owned; image * group_count + group
    bool *counted; // owned; by image: it has a visit
    uint32_t group_count, group_epochs;
};

static enum vw_status sum_credits(const struct vw_results *run, struct credits *credits) {
    struct vw_series series = {0};
    enum vw_status status = vw_series_make(&run->input, VW_MEASURE_PSNR, VW_FORM_STEP, &series);
    uint64_t cells = (uint64_t)series.epoch_count * run->input.image_count;
    credits->group_epochs = (uint32_t)(cells / VISITS_SHOWN) + 1;
    credits->group_count = (series.epoch_count + credits->group_epochs - 1) / credits->group_epochs;
    credits->sums = vw_allocate((size_t)credits->group_count * run->input.image_count, sizeof *credits->sums);
    credits->counted = vw_allocate(run->input.image_count, sizeof *credits->counted);
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

static json_t *credits_to_json(const struct credits *credits, const struct vw_results *run) {
    json_t *credit = json_object(), *rows = json_array();
    for (uint32_t i = 0; i < run->input.image_count; i++) {
        json_t *row = credits->counted[i] ? json_array() : json_null();
        for (uint32_t g = 0; g < credits->group_count && credits->counted[i]; g++) {
            double sum_db = credits->sums[(size_t)i * credits->group_count + g];
            vw_json_append(&row, json_integer((json_int_t)llround(sum_db / CREDIT_UNIT_DB)));
        }
        vw_json_append(&rows, row);
    }
    vw_json_set(&credit, "unit", json_real(CREDIT_UNIT_DB));
    vw_json_set(&credit, "first_epoch", json_integer(run->input.burn_in_epochs));
    vw_json_set(&credit, "group_epochs", json_integer(credits->group_epochs));
    vw_json_set(&credit, "rows", rows);
    return credit;
}

static enum vw_status add_credit(const struct vw_results *run, json_t **object) {
    struct credits credits = {0};
    enum vw_status status = sum_credits(run, &credits);
    if (!status) vw_json_set(object, "credit", credits.group_count ? credits_to_json(&credits, run) : json_null());
    free(credits.sums);
    free(credits.counted);
    return status;
}

// ---- Advice --------------------------------------------------------------------------------------------------------

static json_t *marked_to_json(const struct vw_results *run, enum vw_advice_mark mark) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < run->advice.count; i++)
        if (run->advice.photos[i].marks & mark)
            vw_json_append(&list, json_integer(run->advice.photos[i].image - run->input.images));
    return list;
}

static json_t *advice_to_json(const struct vw_results *run) {
    static const struct {
        const char *key;
        enum vw_advice_mark mark;
    } marks[] = {{"removable", VW_MARK_REMOVABLE},
                 {"irreplaceable", VW_MARK_IRREPLACEABLE},
                 {"look", VW_MARK_LOOK},
                 {"lone", VW_MARK_LONE}};
    json_t *object = json_object(), *words = json_array(), *reasons = json_array(), *texts = json_array();
    const struct vw_photo_advice *next = run->advice.photos, *end = next + run->advice.count;
    for (uint32_t i = 0; i < run->input.image_count; i++) {
        bool advised = next < end && next->image == &run->input.images[i];
        vw_json_append(&words, vw_json_string(advised ? next->word : NULL));
        vw_json_append(&reasons, vw_json_string(advised ? next->reason : NULL));
        vw_json_append(&texts, vw_json_string(advised ? next->description : NULL));
        next += advised;
    }
    vw_json_set(&object, "basis", vw_json_string(run->advice.basis));
    vw_json_set(&object, "by_order", json_boolean(run->advice.by_order));
    vw_json_set(&object, "tested", json_boolean(run->advice.tested));
    for (size_t i = 0; i < VW_ARRAY_COUNT(marks); i++)
        vw_json_set(&object, marks[i].key, marked_to_json(run, marks[i].mark));
    vw_json_set(&object, "words", words);
    vw_json_set(&object, "reasons", reasons);
    vw_json_set(&object, "texts", texts);
    return object;
}

// ---- The matrix ----------------------------------------------------------------------------------------------------

static json_t *table_to_json(const struct vw_matrix *matrix, const double *values) {
    json_t *rows = json_array();
    for (uint32_t photo = 0; photo < matrix->photo_count; photo++)
        vw_json_append(&rows, reals_to_json(&values[(size_t)photo * matrix->view_count], matrix->view_count));
    return rows;
}

static json_t *places_to_json(const struct vw_results *run, const uint32_t *image_ids, uint32_t count) {
    json_t *places = json_array();
    for (uint32_t i = 0; i < count; i++) vw_json_append(&places, place_of(run, image_ids[i]));
    return places;
}

static const struct vw_column view_columns[] = {
    VW_COLUMN(struct vw_view_evidence, REAL_OR_NULL, end_psnr),
    VW_COLUMN(struct vw_view_evidence, REAL_OR_NULL, agreement),
    VW_COLUMN(struct vw_view_evidence, REAL_OR_NULL, without),
    VW_COLUMN(struct vw_view_evidence, FLAG, disagrees),
    VW_COLUMN(struct vw_view_evidence, FLAG, lone),
    VW_COLUMN(struct vw_view_evidence, FLAG, stays_low),
};

static json_t *matrix_to_json(const struct vw_results *run) {
    const struct vw_matrix *matrix = &run->matrix;
    if (!vw_results_have_matrix(run)) return json_null();
    const struct vw_rows views = VW_ROWS(view_columns, run->views, matrix->view_count);
    json_t *object = vw_rows_to_arrays(&views);
    vw_json_set(&object, "view", places_to_json(run, matrix->views, matrix->view_count));
    vw_json_set(&object, "photo", places_to_json(run, matrix->photos, matrix->photo_count));
    vw_json_set(&object, "stderr", reals_to_json(run->standard_errors, matrix->photo_count));
    vw_json_set(&object, "psnr", table_to_json(matrix, matrix->psnr));
    vw_json_set(&object, "l1", table_to_json(matrix, matrix->l1));
    return object;
}

// ---- Trust in lasting credit and worth -----------------------------------------------------------------------------

static const struct vw_column gate_columns[] = {
    VW_COLUMN_AS("predicted", struct vw_gate_check, REAL_OR_NULL, predicted_psnr),
    VW_COLUMN_AS("measured", struct vw_gate_check, REAL_OR_NULL, measured_psnr),
};

static json_t *gate_to_json(const struct vw_results *run) {
    const struct vw_lasting_pass *lasting = &run->input.lasting;
    if (!lasting->check_count) return json_null();
    const struct vw_rows checks = VW_ROWS(gate_columns, lasting->checks, lasting->check_count);
    json_t *gate = vw_rows_to_arrays(&checks), *images = json_array();
    for (uint32_t i = 0; i < lasting->check_count; i++)
        vw_json_append(&images, place_of(run, lasting->checks[i].image_id));
    vw_json_set(&gate, "image", images);
    vw_json_set(&gate, "correlation", vw_json_real(vw_lasting_gate(lasting, false)));
    vw_json_set(&gate, "least", json_real(vw_lasting_gate_least));
    return gate;
}

static const struct vw_column growth_columns[] = {
    VW_COLUMN(struct vw_lasting_step, COUNT64, step),
    VW_COLUMN_AS("size", struct vw_lasting_step, REAL_OR_NULL, size_psnr),
};

static json_t *growth_to_json(const struct vw_results *run) {
    const struct vw_lasting_pass *lasting = &run->input.lasting;
    if (!lasting->step_count) return json_null();
    return thinned_to_json(VW_ROWS(growth_columns, lasting->steps, 0), lasting->step_count);
}

// Returns the scores of a method by image, NaN if there is none; NULL if memory is short. `found`: some are known.
static double *values_of(const struct vw_results *run, const char *method, bool *found) {
    double *values = vw_allocate(run->input.image_count, sizeof *values);
    for (uint32_t i = 0; values && i < run->input.image_count; i++) values[i] = NAN;
    for (uint32_t i = 0; values && i < run->score_count; i++) {
        const struct vw_ledger_score *score = &run->scores[i];
        const struct vw_ledger_image *image =
            vw_ledger_find_image(run->input.images, run->input.image_count, score->image_id);
        if (!image || strcmp(score->method, method) != 0 || !score->visits) continue;
        values[image - run->input.images] = score->value;
        *found = true;
    }
    return values;
}

static json_t *means_of(const struct vw_results *run, const double *values) {
    json_t *means = json_array();
    for (uint32_t r = 0; r < run->retraining_count; r++) {
        double sum = 0;
        for (uint32_t i = 0; i < run->retrainings[r].image_count; i++) {
            const struct vw_ledger_image *image =
                vw_ledger_find_image(run->input.images, run->input.image_count, run->retrainings[r].image_ids[i]);
            sum += image ? values[image - run->input.images] : NAN;
        }
        vw_json_append(&means, vw_json_real(sum / run->retrainings[r].image_count));
    }
    return means;
}

static const struct vw_column retraining_columns[] = {
    VW_COLUMN_AS("measured", struct vw_ledger_retraining, REAL_OR_NULL, val_psnr),
    VW_COLUMN_AS("photos", struct vw_ledger_retraining, COUNT, image_count),
};

static json_t *retrainings_to_json(const struct vw_results *run) {
    static const char *const methods[] = {"dv_psnr", "lasting_psnr", "worth_psnr"};
    if (!run->retraining_count) return json_null();
    const struct vw_rows retrainings = VW_ROWS(retraining_columns, run->retrainings, run->retraining_count);
    json_t *object = vw_rows_to_arrays(&retrainings), *means = json_object();
    for (size_t m = 0; m < VW_ARRAY_COUNT(methods); m++) {
        bool found = false;
        double *values = values_of(run, methods[m], &found);
        if (found || !values) vw_json_set(&means, methods[m], values ? means_of(run, values) : NULL);
        free(values);
    }
    vw_json_set(&object, "means", means);
    return object;
}

static json_t *accuracy_to_json(const struct vw_worth_summary *worth) {
    if (!worth->claim_count) return json_null();
    const struct vw_rows claims = vw_claim_rows(worth);
    json_t *object = vw_rows_to_arrays(&claims);
    vw_json_set(&object, "retrainings", json_integer(worth->retraining_count));
    vw_json_set(&object, "noise_db", vw_json_real(worth->noise_db));
    vw_json_set(&object, "ceiling", vw_json_real(worth->ceiling));
    return object;
}

// ---- A run ---------------------------------------------------------------------------------------------------------

#define OF_RUN(name, member)                                                                                           \
    { VW_CELL(name, struct vw_ledger_run, TEXT_OR_NULL, member) }
static const struct vw_column run_columns[] = {
    OF_RUN("run_id", run_id),
    OF_RUN("scene", scene_path),
    OF_RUN("scene_hash", scene_hash),
    OF_RUN("subset_hash", subset_hash),
    OF_RUN("device", device),
    OF_RUN("driver", driver),
    OF_RUN("shader_hash", shader_hash),
    OF_RUN("version", version),
    OF_RUN("started_utc", started_utc),
    OF_RUN("status", status),
    OF_RUN("finished_utc", finished_utc),
    VW_COLUMN(struct vw_ledger_run, COUNT64, seed), // below 0 in JSON where it is so here
};

static json_t *row_to_json(const struct vw_results *run) {
    const struct vw_rows row = VW_ROWS(run_columns, &run->row, 1);
    json_t *fields = vw_row_to_json(&row, 0);
    vw_json_set(&fields, "head", vw_json_string(run->head));
    return fields;
}

// Adds the JSON texts of the run row.
static enum vw_status add_texts(const struct vw_results *run, json_t **object) {
    const struct {
        const char *key, *text;
    } texts[] = {{"config", run->row.config_json},
                 {"effects", run->row.effects_json},
                 {"plan", run->row.plan_json},
                 {"scene_options", run->row.scene_options_json}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(texts); i++) {
        json_error_t error;
        const char *text = texts[i].text ? texts[i].text : "null";
        json_t *value = vw_json_load(text, strlen(text), JSON_DECODE_ANY, &error);
        if (!value)
            return vw_fail(VW_ERROR_INPUT, "%s: run.%s_json of the ledger: line %d: %s", run->label, texts[i].key,
                           error.line, error.text);
        vw_json_set(object, texts[i].key, value);
    }
    return VW_OK;
}

static json_t *shared(json_t *value) { return value ? json_incref(value) : json_null(); }

static enum vw_status add_run(const struct vw_report_page *page, uint32_t place, size_t *places, json_t **sets,
                              json_t **runs) {
    const struct vw_results *run = page->runs[place];
    json_t *object = json_object();
    vw_json_set(&object, "run", row_to_json(run));
    vw_json_set(&object, "label", vw_json_string(run->label));
    vw_json_set(&object, "images", images_to_json(run));
    vw_json_set(&object, "thumbnails", set_of(page, place, places, sets));
    vw_json_set(&object, "steps", steps_to_json(run));
    vw_json_set(&object, "matrix", matrix_to_json(run));
    vw_json_set(&object, "gate", gate_to_json(run));
    vw_json_set(&object, "growth", growth_to_json(run));
    vw_json_set(&object, "retrainings", retrainings_to_json(run));
    vw_json_set(&object, "verdict", vw_verdict_to_json(&run->reconstruction, &run->agreement));
    vw_json_set(&object, "advice", advice_to_json(run));
    vw_json_set(&object, "accuracy", accuracy_to_json(&run->worth));
    vw_json_set(&object, "map", shared(run->map));
    vw_json_set(&object, "residuals", shared(run->residuals));
    if (run->next) vw_json_set(&object, "next", shared(run->next));
    enum vw_status status = add_scores(run, &object);
    if (!status) status = add_credit(run, &object);
    if (!status) status = add_texts(run, &object);
    vw_json_append(runs, object);
    return status;
}

// ---- The page ------------------------------------------------------------------------------------------------------

static json_t *document_to_json(const struct vw_report_document *document) {
    json_t *object = json_object(), *pictures = json_object(), *thumbnails = json_object();
    for (uint32_t i = 0; i < document->picture_count; i++)
        vw_json_set(&pictures, document->picture_files[i], picture_to_json(&document->pictures[i], "image/png"));
    for (uint32_t i = 0; i < document->thumbnail_count; i++)
        vw_json_set(&thumbnails, document->thumbnail_names[i], picture_to_json(&document->thumbnails[i], "image/webp"));
    vw_json_set(&object, "kind", vw_json_string(document->kind));
    vw_json_set(&object, "label", vw_json_string(document->label));
    vw_json_set(&object, "file", vw_json_string(document->file));
    vw_json_set(&object, "pictures", pictures);
    vw_json_set(&object, "thumbnails", thumbnails);
    vw_json_set(&object, "content", shared(document->content));
    return object;
}

static const struct vw_column method_columns[] = {
    VW_COLUMN(struct vw_value_method, TEXT, name),
    VW_COLUMN(struct vw_value_method, TEXT, unit),
    VW_COLUMN(struct vw_value_method, TEXT, formula),
    VW_COLUMN(struct vw_value_method, FLAG, has_zero),
};

static json_t *methods_to_json(void) {
    uint32_t count;
    const struct vw_value_method *methods = vw_value_methods(&count);
    const struct vw_rows rows = VW_ROWS(method_columns, methods, count);
    return vw_rows_to_json(&rows);
}

enum vw_status vw_html_data_make(const struct vw_report_page *page, json_t **data) {
    json_t *root = json_object(), *sets = json_array(), *runs = json_array(), *documents = json_array();
    size_t *places = vw_allocate(page->run_count, sizeof *places);
    enum vw_status status = places ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < page->run_count; i++) status = add_run(page, i, places, &sets, &runs);
    for (uint32_t i = 0; !status && i < page->document_count; i++)
        vw_json_append(&documents, document_to_json(&page->documents[i]));
    vw_json_set(&root, "version", vw_json_string(vw_version()));
    vw_json_set(&root, "default_method", vw_json_string(vw_value_default_method));
    vw_json_set(&root, "methods", methods_to_json());
    vw_json_set(&root, "thumbnail_sets", sets);
    vw_json_set(&root, "runs", runs);
    vw_json_set(&root, "documents", documents);
    free(places);
    if (!status && !root) status = vw_fail(VW_ERROR_MEMORY, "out of memory for the data of the report");
    if (status) json_decref(root);
    else *data = root;
    return status;
}

#include "run/verify/verify_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "report/page.h"
#include "report/tables.h"
#include "run/scoring.h"
#include "scene/builder.h"
#include "scene/name_index.h"
#include "value/matrix.h"
#include "value/providers.h"

// ---- Providers -----------------------------------------------------------------------------------------------------

// The ledger's images, with the providers of a file where one is given.
struct provided_images {
    struct vw_ledger_image *images; // owned
    struct vw_view *views;          // owned, with their providers
    uint32_t count;
    bool some; // a photo to train on has a provider
};

// Reads providers through views, since their reader does not know images.
static enum vw_status read_providers(const char *path, struct provided_images *provided) {
    provided->views = vw_allocate(provided->count, sizeof *provided->views);
    if (!provided->views) return VW_ERROR_MEMORY;
    static char format[] = "colmap"; // names may lack the folder of the photos
    struct vw_scene scene = {.format = format, .views = provided->views, .view_count = provided->count};
    for (uint32_t i = 0; i < provided->count; i++) {
        provided->views[i].name = (char *)provided->images[i].name; // it is not changed
        provided->views[i].provider = vw_copy_text("");
        if (!provided->views[i].provider) return VW_ERROR_MEMORY;
    }
    enum vw_status status = vw_scene_index_names(&scene);
    if (!status) status = vw_providers_read(path, &scene);
    if (scene.names) vw_name_index_clear(scene.names);
    free(scene.names);
    for (uint32_t i = 0; i < provided->count; i++) provided->images[i].provider = provided->views[i].provider;
    return status;
}

static enum vw_status provide(const struct vw_table_sources *sources, struct provided_images *provided) {
    const struct vw_value_input *input = sources->input;
    *provided = (struct provided_images){.count = input->image_count};
    provided->images = vw_allocate(input->image_count, sizeof *provided->images);
    if (!provided->images) return VW_ERROR_MEMORY;
    if (input->image_count) memcpy(provided->images, input->images, input->image_count * sizeof *provided->images);
    enum vw_status status = sources->providers ? read_providers(sources->providers, provided) : VW_OK;
    for (uint32_t i = 0; i < provided->count; i++) {
        const struct vw_ledger_image *image = &provided->images[i];
        if (image->provider && *image->provider && strcmp(image->split, vw_split_name(VW_SPLIT_TRAIN)) == 0)
            provided->some = true;
    }
    return status;
}

static void free_provided(struct provided_images *provided) {
    for (uint32_t i = 0; provided->views && i < provided->count; i++) free(provided->views[i].provider);
    free(provided->views);
    free(provided->images);
}

// ---- Tables, made again --------------------------------------------------------------------------------------------

// A table in memory. No text: the ledger gives no such table.
struct derived {
    struct vw_csv_text made;
    double scale; // numbers may differ by 1e-9 of it; 0: not at all
};

static enum vw_status make_scores(const struct vw_table_sources *sources, const char *path, struct derived *derived) {
    return vw_report_make_csv(path, sources->scores, sources->score_count, sources->input->images,
                              sources->input->image_count, &derived->made);
}

static double largest_of(const struct vw_matrix *matrix) {
    double largest = 0;
    for (size_t i = 0; i < (size_t)matrix->photo_count * matrix->view_count; i++)
        largest = fmax(largest, fmax(fabs(matrix->psnr[i]), matrix->lasting ? fabs(matrix->lasting[i]) : 0));
    return largest;
}

static enum vw_status make_matrix(const struct vw_table_sources *sources, const char *path, struct derived *derived) {
    struct vw_matrix matrix = {0};
    struct vw_view_evidence *views = NULL;
    double *standard_errors = NULL;
    enum vw_status status = vw_value_matrix(sources->ledger, sources->input, &matrix);
    bool has_rows = !status && matrix.view_count > 0 && matrix.visit_count > 0;
    if (has_rows) {
        views = vw_allocate(matrix.view_count, sizeof *views);
        standard_errors = vw_allocate(matrix.photo_count, sizeof *standard_errors);
        status = views && standard_errors ? vw_matrix_jackknife(&matrix, views, standard_errors) : VW_ERROR_MEMORY;
    }
    if (has_rows && !status)
        status = vw_table_make_matrix(path, &matrix, standard_errors, sources->input->images,
                                      sources->input->image_count, &derived->made);
    derived->scale = largest_of(&matrix);
    vw_matrix_clear(&matrix);
    free(views);
    free(standard_errors);
    return status;
}

// Reads the amount that the file states: the sum of its payments, in the last column of both tables of payouts.
static enum vw_status read_amount(const struct vw_table_sources *sources, const char *name, const char *path,
                                  uint64_t *cents) {
    enum { AMOUNT_FIELD = 6, FIELDS = 7, LIMIT_BYTES = 64 << 20 };
    struct vw_csv csv;
    bool found = false;
    uint64_t paid;
    void *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read_inside(sources->out, name, LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    status = vw_csv_take(path, text, size_bytes, &csv);
    if (!status) status = vw_csv_next(&csv, &found); // the header
    while (!status && !(status = vw_csv_next(&csv, &found)) && found) {
        bool pays = csv.field_count == FIELDS && strcmp(csv.fields[AMOUNT_FIELD], "0.00") != 0;
        if (pays && vw_payout_parse(csv.fields[AMOUNT_FIELD], &paid) && *cents <= VW_PAYOUT_CENTS_MAX) *cents += paid;
    }
    vw_csv_close(&csv);
    return status;
}

static enum vw_status take_worth(const struct vw_table_sources *sources, const struct provided_images *provided,
                                 struct vw_provider_score *groups, uint32_t group_count) {
    struct vw_ledger_retraining *retrainings = NULL;
    struct vw_worth_input worth = {.images = provided->images,
                                   .image_count = provided->count,
                                   .scores = sources->scores,
                                   .score_count = sources->score_count};
    bool replaced;
    enum vw_status status = vw_ledger_get_retrainings(sources->ledger, &retrainings, &worth.retraining_count);
    worth.retrainings = retrainings;
    if (!status) status = vw_worth_of_groups(&worth, groups, group_count, &replaced);
    free(retrainings);
    return status;
}

static const char payout_name[] = "payout.csv", photos_name[] = "payout_photos.csv";

static enum vw_status make_photos(const struct vw_table_sources *sources, const struct provided_images *provided,
                                  const struct vw_payout *payouts, uint32_t payout_count, const char *path,
                                  struct derived *derived) {
    const struct vw_payout_scores scores = {sources->scores, sources->score_count, provided->images, provided->count};
    struct vw_photo_payout *photos = NULL;
    uint32_t photo_count = 0;
    enum vw_status status = vw_payout_split(payouts, payout_count, &scores, &photos, &photo_count);
    if (!status && photo_count) status = vw_table_make_payout_photos(path, photos, photo_count, &derived->made);
    free(photos);
    return status;
}

// Makes a table by provider; `pays` names a table of payouts, NULL: providers.csv.
static enum vw_status make_by_provider(const struct vw_table_sources *sources, const char *path, const char *pays,
                                       struct derived *derived) {
    struct provided_images provided;
    struct vw_provider_score *groups = NULL;
    struct vw_payout *payouts = NULL;
    uint32_t group_count = 0, payout_count = 0;
    uint64_t cents = 0;
    bool none_positive = false;
    enum vw_status status = provide(sources, &provided);
    if (!status && provided.some)
        status = vw_providers_score(sources->scores, sources->score_count, provided.images, provided.count, &groups,
                                    &group_count);
    if (!status) status = take_worth(sources, &provided, groups, group_count);
    if (!status && pays) status = read_amount(sources, pays, path, &cents);
    if (!status && group_count > 0 && !pays)
        status = vw_table_make_providers(path, groups, group_count, &derived->made);
    if (!status && group_count > 0 && cents > 0 && cents <= VW_PAYOUT_CENTS_MAX) {
        const char *method = vw_scoring_payout_method(sources->scores, sources->score_count);
        status = vw_payout_divide(groups, group_count, method, cents, &payouts, &payout_count, &none_positive);
        if (!status && pays == payout_name) status = vw_table_make_payout(path, payouts, payout_count, &derived->made);
        else if (!status) status = make_photos(sources, &provided, payouts, payout_count, path, derived);
    }
    free(payouts);
    free(groups);
    free_provided(&provided);
    return status;
}

static enum vw_status make_providers(const struct vw_table_sources *sources, const char *path,
                                     struct derived *derived) {
    return make_by_provider(sources, path, NULL, derived);
}

static enum vw_status make_payout(const struct vw_table_sources *sources, const char *path, struct derived *derived) {
    return make_by_provider(sources, path, payout_name, derived);
}

static enum vw_status make_payout_photos(const struct vw_table_sources *sources, const char *path,
                                         struct derived *derived) {
    return make_by_provider(sources, path, photos_name, derived);
}

static const struct table {
    const char *name;
    enum vw_status (*make)(const struct vw_table_sources *sources, const char *path, struct derived *derived);
    bool by_provider;
} tables_of_out[VW_DERIVED_TABLE_COUNT] = {
    {"scores.csv", make_scores, false},      {"matrix.csv", make_matrix, false},
    {"providers.csv", make_providers, true}, {payout_name, make_payout, true},
    {photos_name, make_payout_photos, true},
};

// ---- Comparison ----------------------------------------------------------------------------------------------------

// Reads a number as vw_csv_write_real() writes it; `text` itself when there is none.
static const char *read_number(const char *text, double *number) {
    size_t length = strspn(text, "+-.0123456789e");
    char *end = NULL;
    *number = strtod(text, &end);
    bool ends = text[length] == ',' || text[length] == '\n';
    return length > 0 && end == text + length && ends ? end : text;
}

static bool same_table(const struct derived *derived, const char *file, size_t file_bytes) {
    if (!derived->made.text) return false;
    if (derived->made.size_bytes == file_bytes && memcmp(derived->made.text, file, file_bytes) == 0) return true;
    if (derived->scale <= 0 || strlen(file) != file_bytes) return false;
    const char *ours = derived->made.text, *field = ours, *its_field = file;
    while (*ours || *file) {
        if (*ours == *file) {
            bool ends = *ours == ',' || *ours == '\n';
            ours++, file++;
            if (ends) field = ours, its_field = file;
            continue;
        }
        double number, its_number;
        const char *end = read_number(field, &number), *its_end = read_number(its_field, &its_number);
        if (end == field || its_end == its_field) return false;
        if (!(fabs(number - its_number) <= 1e-9 * derived->scale)) return false;
        ours = end, file = its_end;
    }
    return true;
}

// Compares a table; does not read a file that is far larger than it.
static enum vw_status compare(const struct vw_table_sources *sources, const struct table *table, const char *path) {
    enum { SLACK_BYTES = 1 << 16 };
    struct derived derived = {0};
    void *file = NULL;
    size_t file_bytes = 0;
    enum vw_status status = table->make(sources, path, &derived);
    if (!status) {
        bool read = !vw_file_read_inside(sources->out, table->name, 2 * derived.made.size_bytes + SLACK_BYTES, &file,
                                         &file_bytes);
        if (!read || !same_table(&derived, file, file_bytes))
            status = vw_fail(VW_ERROR_MISMATCH,
                             "%s: is not what the ledger gives: the file was edited%s; restore it from a copy", path,
                             table->by_provider ? ", or made with other --providers: give verify the same" : "");
    }
    free(file);
    free(derived.made.text);
    return status;
}

static enum vw_status verify_table(const struct vw_table_sources *sources, const struct table *table, bool *present) {
    char *path = vw_path_join(sources->out, table->name);
    if (!path) return VW_ERROR_MEMORY;
    *present = vw_file_exists_inside(sources->out, table->name);
    enum vw_status status = vw_file_check_inside(sources->out, table->name);
    if (*present && !status) status = compare(sources, table, path);
    free(path);
    return status;
}

enum vw_status vw_verify_tables(const struct vw_table_sources *sources,
                                struct vw_verified_table tables[VW_DERIVED_TABLE_COUNT]) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_DERIVED_TABLE_COUNT && !status; i++) {
        tables[i] =
            (struct vw_verified_table){.name = tables_of_out[i].name, .by_provider = tables_of_out[i].by_provider};
        status = verify_table(sources, &tables_of_out[i], &tables[i].present);
    }
    return status;
}

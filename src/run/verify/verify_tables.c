#include "run/verify/verify_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "report/tables.h"
#include "run/outputs/attribution.h"
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
    double tolerance;                   // by which numbers may differ that a C library computes; 0: not at all
    uint32_t first_number, last_number; // columns that are compared with tolerance; all others are text
};
static const double SAME = 1e-9, CENT = 0.01 + 1e-6;
enum { FIRST_VIEW = 4, FIRST_END = 7 }; // columns: the means of the matrix; the ends of a payout's interval

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
    derived->tolerance = SAME * largest_of(&matrix);
    derived->first_number = FIRST_VIEW;
    derived->last_number = UINT32_MAX;
    vw_matrix_clear(&matrix);
    free(views);
    free(standard_errors);
    return status;
}

static const char payout_name[] = "payout.csv";

// Reads the amount that both tables of payouts divide: the sum of the payments to providers.
static enum vw_status read_amount(const struct vw_table_sources *sources, const char *path, uint64_t *cents) {
    enum { AMOUNT_FIELD = 6, LIMIT_BYTES = 64 << 20 };
    struct vw_csv csv;
    bool found = false;
    uint64_t paid;
    void *text = NULL;
    size_t size_bytes = 0;
    if (!vw_file_exists_inside(sources->out, payout_name))
        return vw_fail(VW_ERROR_MISMATCH, "%s: belongs to %s, which is missing; restore both from a copy", path,
                       payout_name);
    enum vw_status status = vw_file_read_inside(sources->out, payout_name, LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    status = vw_csv_take(path, text, size_bytes, &csv);
    if (!status) status = vw_csv_next(&csv, &found); // the header
    while (!status && !(status = vw_csv_next(&csv, &found)) && found) {
        bool pays = csv.field_count > AMOUNT_FIELD && strcmp(csv.fields[AMOUNT_FIELD], "0.00") != 0;
        if (pays && vw_payout_parse(csv.fields[AMOUNT_FIELD], &paid) && *cents <= VW_PAYOUT_CENTS_MAX) *cents += paid;
    }
    vw_csv_close(&csv);
    return status;
}

static enum vw_status open_worth(const struct vw_table_sources *sources, const struct provided_images *provided,
                                 struct vw_ledger_retraining **retrainings, struct vw_worth_input *worth) {
    *worth = (struct vw_worth_input){.images = provided->images,
                                     .image_count = provided->count,
                                     .scores = sources->scores,
                                     .score_count = sources->score_count};
    enum vw_status status = vw_ledger_get_retrainings(sources->ledger, retrainings, &worth->retraining_count);
    worth->retrainings = *retrainings;
    return status;
}

static enum vw_status make_groups(const struct vw_table_sources *sources, const struct vw_worth_input *worth,
                                  const char *path, struct derived *derived) {
    struct vw_provider_score *groups = NULL;
    uint32_t group_count = 0;
    enum vw_status status = vw_providers_score(sources->scores, sources->score_count, worth->images, worth->image_count,
                                               &groups, &group_count);
    if (!status) status = vw_worth_add_joint(worth, &groups, &group_count);
    const struct vw_rows rows = vw_provider_rows(groups, group_count);
    if (!status && group_count > 0) status = vw_rows_make_csv(path, &rows, &derived->made);
    free(groups);
    return status;
}

// Finds what the payout was asked with by the hash of it that the ledger recorded.
static enum vw_status find_request(const struct vw_table_sources *sources, const char *path,
                                   struct vw_payout_request *request) {
    char recorded[VW_HASH_HEX_BYTES], hash[VW_HASH_HEX_BYTES];
    *request = (struct vw_payout_request){0};
    enum vw_status status = read_amount(sources, path, &request->cents);
    if (!status) status = vw_ledger_get_kept(sources->ledger, VW_PAYOUT_RECORD, recorded);
    for (unsigned flags = 0; !status && flags < 4; flags++) {
        request->anyway = flags & 1, request->floor_equal = flags & 2;
        vw_payout_request_hash(request, hash);
        if (strcmp(hash, recorded) == 0) return VW_OK;
    }
    if (status) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: the ledger does not record that this amount was to be paid; remove it, and pay by "
                   "viewworth worth OUT --payout AMOUNT",
                   path);
}

static enum vw_status check_paid(const char *path, const struct vw_payout_input *input,
                                 const struct vw_payouts *payouts, const struct vw_payout_request *request) {
    if (vw_payout_decide(input->method, payouts, request) == VW_PAYOUT_PAID) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: the rules pay nobody by what the payout was asked with; remove it, and pay by viewworth worth "
                   "OUT --payout AMOUNT",
                   path);
}

// Divides the amount again by exactly what the payout was asked with.
static enum vw_status make_payouts(const struct vw_table_sources *sources, const struct vw_worth_input *worth,
                                   const char *path, bool of_photos, struct derived *derived) {
    struct vw_payouts payouts = {0};
    struct vw_payout_request request;
    enum vw_status status = find_request(sources, path, &request);
    if (status) return status;
    const struct vw_payout_input input = {.of = *worth,
                                          .method = vw_scoring_payout_method(sources->scores, sources->score_count),
                                          .amount_cents = request.cents,
                                          .floor_equal = request.floor_equal};
    status = vw_payouts_make(&input, &payouts);
    if (!status) status = check_paid(path, &input, &payouts, &request);
    const struct vw_rows rows = of_photos ? vw_photo_payout_rows(&payouts) : vw_payout_rows(&payouts);
    if (!status) status = vw_rows_make_csv(path, &rows, &derived->made);
    derived->tolerance = CENT + SAME * (double)input.amount_cents / 100;
    derived->first_number = FIRST_END;
    derived->last_number = FIRST_END + 1;
    vw_payouts_free(&payouts);
    return status;
}

enum by_provider { OF_GROUPS, OF_PAYOUTS, OF_PHOTOS };

static enum vw_status make_by_provider(const struct vw_table_sources *sources, const char *path, enum by_provider which,
                                       struct derived *derived) {
    struct provided_images provided;
    struct vw_ledger_retraining *retrainings = NULL;
    struct vw_worth_input worth;
    enum vw_status status = provide(sources, &provided);
    if (!status) status = open_worth(sources, &provided, &retrainings, &worth);
    if (!status && provided.some && sources->score_count)
        status = which == OF_GROUPS ? make_groups(sources, &worth, path, derived)
                                    : make_payouts(sources, &worth, path, which == OF_PHOTOS, derived);
    free(retrainings);
    free_provided(&provided);
    return status;
}

static enum vw_status make_providers(const struct vw_table_sources *sources, const char *path,
                                     struct derived *derived) {
    return make_by_provider(sources, path, OF_GROUPS, derived);
}

static enum vw_status make_payout(const struct vw_table_sources *sources, const char *path, struct derived *derived) {
    return make_by_provider(sources, path, OF_PAYOUTS, derived);
}

static enum vw_status make_payout_photos(const struct vw_table_sources *sources, const char *path,
                                         struct derived *derived) {
    return make_by_provider(sources, path, OF_PHOTOS, derived);
}

static const struct table {
    const char *name;
    enum vw_status (*make)(const struct vw_table_sources *sources, const char *path, struct derived *derived);
    bool by_provider;
} tables_of_out[VW_DERIVED_TABLE_COUNT] = {
    {"scores.csv", make_scores, false},
    {"matrix.csv", make_matrix, false},
    {"providers.csv", make_providers, true},
    {payout_name, make_payout, true},
    {"payout_photos.csv", make_payout_photos, true},
};

// ---- Comparison ----------------------------------------------------------------------------------------------------

// The raw text of a field, with its quotes.
struct field {
    const char *text;
    size_t length;
};

static struct field read_field(const char *text) {
    const char *end = text;
    for (bool quoted = false; *end && (quoted || (*end != ',' && *end != '\n')); end++) quoted ^= *end == '"';
    return (struct field){text, (size_t)(end - text)};
}

// Reads a number as vw_csv_write_real() writes it; false if the field is something else.
static bool read_number(struct field field, double *number) {
    char *end = NULL;
    if (!field.length || strspn(field.text, "+-.0123456789e") != field.length) return false;
    *number = strtod(field.text, &end);
    return end == field.text + field.length;
}

static bool same_field(const struct derived *derived, uint32_t row, uint32_t column, struct field ours,
                       struct field its) {
    double number, its_number;
    if (ours.length == its.length && memcmp(ours.text, its.text, ours.length) == 0) return true;
    bool of_numbers = row > 0 && column >= derived->first_number && column <= derived->last_number;
    return of_numbers && derived->tolerance > 0 && read_number(ours, &number) && read_number(its, &its_number) &&
           fabs(number - its_number) <= derived->tolerance;
}

static bool same_table(const struct derived *derived, const char *file, size_t file_bytes) {
    const char *ours = derived->made.text;
    if (!ours || strlen(file) != file_bytes) return false;
    for (uint32_t row = 0, column = 0; *ours || *file; ours++, file++) {
        struct field field = read_field(ours), its_field = read_field(file);
        if (!same_field(derived, row, column, field, its_field)) return false;
        ours += field.length, file += its_field.length;
        if (*ours != *file) return false;
        if (!*ours) break;
        row += *ours == '\n';
        column = *ours == '\n' ? 0 : column + 1;
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
        else status = vw_checksums_note(sources->read, table->name, file, file_bytes);
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
    if (!status)
        status = *present ? compare(sources, table, path) : vw_checksums_note(sources->read, table->name, NULL, 0);
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

#include "run/verify/verify_tables.h"

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
    const struct vw_value_input *input = &sources->scoring->input;
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

static enum vw_status make_scores(const struct vw_table_sources *sources, const char *path, struct vw_csv_text *made) {
    const struct vw_scoring *scoring = sources->scoring;
    return vw_report_make_csv(path, scoring->scores, scoring->score_count, scoring->input.images,
                              scoring->input.image_count, made);
}

static enum vw_status make_matrix(const struct vw_table_sources *sources, const char *path, struct vw_csv_text *made) {
    const struct vw_value_input *input = &sources->scoring->input;
    struct vw_matrix matrix = {0};
    struct vw_view_evidence *views = NULL;
    double *standard_errors = NULL;
    enum vw_status status = vw_value_matrix(sources->ledger, input, &matrix);
    bool has_rows = !status && matrix.view_count > 0 && matrix.visit_count > 0;
    if (has_rows) {
        views = vw_allocate(matrix.view_count, sizeof *views);
        standard_errors = vw_allocate(matrix.photo_count, sizeof *standard_errors);
        status = views && standard_errors ? vw_matrix_jackknife(&matrix, views, standard_errors) : VW_ERROR_MEMORY;
    }
    if (has_rows && !status)
        status = vw_table_make_matrix(path, &matrix, standard_errors, input->images, input->image_count, made);
    vw_matrix_clear(&matrix);
    free(views);
    free(standard_errors);
    return status;
}

static enum vw_status make_groups(const struct vw_worth_input *worth, const char *path, struct vw_csv_text *made) {
    struct vw_provider_score *groups = NULL;
    uint32_t group_count = 0;
    enum vw_status status =
        vw_providers_score(worth->scores, worth->score_count, worth->images, worth->image_count, &groups, &group_count);
    const struct vw_rows rows = vw_provider_rows(groups, group_count);
    if (!status && group_count > 0) status = vw_rows_make_csv(path, &rows, made);
    free(groups);
    return status;
}

// Divides the amount again that the payout was asked for.
static enum vw_status make_payouts(const struct vw_table_sources *sources, const struct vw_worth_input *worth,
                                   const char *path, bool of_photos, struct vw_csv_text *made) {
    struct vw_payouts payouts = {0};
    struct vw_payout_request request;
    enum vw_status status = vw_ledger_get_payout_request(sources->ledger, &request);
    if (!status && (!request.cents || request.cents > VW_PAYOUT_CENTS_MAX))
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: the ledger does not record that this amount was to be paid; remove it, and pay by "
                         "viewworth worth OUT --payout AMOUNT",
                         path);
    if (!status) status = vw_payouts_make(worth, request.cents, &payouts);
    if (!status && payouts.outcome != VW_PAYOUT_PAID)
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: the rules pay nobody by what the payout was asked with; remove it, and pay by viewworth "
                         "worth OUT --payout AMOUNT",
                         path);
    const struct vw_rows rows = of_photos ? vw_photo_payout_rows(&payouts) : vw_payout_rows(&payouts);
    if (!status) status = vw_rows_make_csv(path, &rows, made);
    vw_payouts_free(&payouts);
    return status;
}

enum by_provider { OF_GROUPS, OF_PAYOUTS, OF_PHOTOS };

static enum vw_status make_by_provider(const struct vw_table_sources *sources, const char *path, enum by_provider which,
                                       struct vw_csv_text *made) {
    struct provided_images provided;
    struct vw_worth_input worth = vw_scoring_worth_input(sources->scoring);
    enum vw_status status = provide(sources, &provided);
    worth.images = provided.images;
    if (!status && provided.some && worth.score_count)
        status = which == OF_GROUPS ? make_groups(&worth, path, made)
                                    : make_payouts(sources, &worth, path, which == OF_PHOTOS, made);
    free_provided(&provided);
    return status;
}

static enum vw_status make_providers(const struct vw_table_sources *sources, const char *path,
                                     struct vw_csv_text *made) {
    return make_by_provider(sources, path, OF_GROUPS, made);
}

static enum vw_status make_payout(const struct vw_table_sources *sources, const char *path, struct vw_csv_text *made) {
    return make_by_provider(sources, path, OF_PAYOUTS, made);
}

static enum vw_status make_payout_photos(const struct vw_table_sources *sources, const char *path,
                                         struct vw_csv_text *made) {
    return make_by_provider(sources, path, OF_PHOTOS, made);
}

static const struct table {
    const char *name;
    enum vw_status (*make)(const struct vw_table_sources *sources, const char *path, struct vw_csv_text *made);
    bool by_provider;
} tables_of_out[] = {
    {"scores.csv", make_scores, false},
    {"matrix.csv", make_matrix, false},
    {"providers.csv", make_providers, true},
    {"payout.csv", make_payout, true},
    {"payout_photos.csv", make_payout_photos, true},
};

// ---- Comparison ----------------------------------------------------------------------------------------------------

// Compares the bytes of a table; does not read a file that is larger.
static enum vw_status compare(const struct vw_table_sources *sources, const struct table *table, const char *path) {
    struct vw_csv_text made = {0};
    void *file = NULL;
    size_t file_bytes = 0;
    enum vw_status status = table->make(sources, path, &made);
    if (!status) {
        bool read = !vw_file_read_inside(sources->out, table->name, made.size_bytes + 1, &file, &file_bytes);
        bool same = read && made.text && file_bytes == made.size_bytes && !memcmp(file, made.text, file_bytes);
        if (!same)
            status = vw_fail(VW_ERROR_MISMATCH,
                             "%s: is not what the ledger gives: the file was edited%s; restore it from a copy", path,
                             table->by_provider ? ", or made with other --providers: give verify the same" : "");
        else status = vw_checksums_note(sources->read, table->name, file, file_bytes);
    }
    free(file);
    free(made.text);
    return status;
}

static enum vw_status verify_table(const struct vw_table_sources *sources, const struct table *table) {
    char *path = vw_path_join(sources->out, table->name);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_file_check_inside(sources->out, table->name);
    if (!status)
        status = vw_file_exists_inside(sources->out, table->name)
                     ? compare(sources, table, path)
                     : vw_checksums_note(sources->read, table->name, NULL, 0);
    free(path);
    return status;
}

enum vw_status vw_verify_tables(const struct vw_table_sources *sources) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables_of_out) && !status; i++)
        status = verify_table(sources, &tables_of_out[i]);
    return status;
}

bool vw_verify_covers(const char *name, bool *by_provider) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables_of_out); i++) {
        if (strcmp(tables_of_out[i].name, name) != 0) continue;
        *by_provider = tables_of_out[i].by_provider;
        return true;
    }
    return false;
}

#include "run/verify/verify_tables.h"

#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "report/results.h"
#include "report/tables.h"
#include "run/outputs/attribution.h"
#include "run/scoring.h"
#include "scene/builder.h"
#include "scene/name_index.h"

// ---- Providers -----------------------------------------------------------------------------------------------------

// Reads providers of the ledger's images from a file, through views, since its reader does not know images. The views
// own the names.
static enum vw_status read_providers(const char *path, struct vw_ledger_image *images, struct vw_view *views,
                                     uint32_t count) {
    static char format[] = "colmap"; // names may lack the folder of the photos
    struct vw_scene scene = {.format = format, .views = views, .view_count = count};
    for (uint32_t i = 0; i < count; i++) {
        views[i].name = (char *)images[i].name; // it is not changed
        views[i].provider = vw_copy_text("");
        if (!views[i].provider) return VW_ERROR_MEMORY;
    }
    enum vw_status status = vw_scene_index_names(&scene);
    if (!status) status = vw_providers_read(path, &scene);
    if (scene.names) vw_name_index_clear(scene.names);
    free(scene.names);
    for (uint32_t i = 0; i < count; i++) images[i].provider = views[i].provider;
    return status;
}

// ---- Tables, made again --------------------------------------------------------------------------------------------

// The findings that the tables show, made from the ledger alone.
struct findings {
    struct vw_results results;
    struct vw_attribution attribution;
    struct vw_view *views; // owned, with the providers of a file
};

// Returns the amount that the payout was asked for, if OUT has one; 0: there is none to divide.
static enum vw_status read_amount(const struct vw_table_sources *sources, uint64_t *cents) {
    struct vw_payout_request request = {0};
    bool paid = vw_file_exists_inside(sources->out, vw_attribution_names[VW_TABLE_PAYOUT]) ||
                vw_file_exists_inside(sources->out, vw_attribution_names[VW_TABLE_PAYOUT_PHOTOS]);
    enum vw_status status = paid ? vw_ledger_get_payout_request(sources->ledger, &request) : VW_OK;
    *cents = request.cents <= VW_PAYOUT_CENTS_MAX ? request.cents : 0;
    return status;
}

static enum vw_status find(const struct vw_table_sources *sources, struct findings *findings) {
    const struct vw_scoring *scoring = sources->scoring;
    uint32_t count = scoring->input.image_count;
    uint64_t cents = 0;
    struct vw_ledger_image *images = vw_allocate(count, sizeof *images);
    findings->attribution.images = images;
    findings->views = vw_allocate(count, sizeof *findings->views);
    findings->results =
        (struct vw_results){.input = scoring->input, .scores = scoring->scores, .score_count = scoring->score_count};
    if (!images || !findings->views) return VW_ERROR_MEMORY;
    if (count) memcpy(images, scoring->input.images, count * sizeof *images);
    enum vw_status status = vw_results_measure(sources->ledger, &findings->results);
    if (!status && sources->providers) status = read_providers(sources->providers, images, findings->views, count);
    if (!status) status = read_amount(sources, &cents);
    return status ? status : vw_attribution_of_providers(scoring, cents, &findings->attribution);
}

static void free_findings(struct findings *findings, uint32_t count) {
    for (uint32_t i = 0; findings->views && i < count; i++) free(findings->views[i].provider);
    free(findings->views);
    vw_attribution_free(&findings->attribution);
    vw_results_free(&findings->results);
}

enum { SCORES = VW_ATTRIBUTION_TABLES, MATRIX };
static const struct table {
    const char *name;
    int which; // enum vw_attribution_table, SCORES or MATRIX
    bool by_provider;
} tables[] = {
    {"scores.csv", SCORES, false},
    {"matrix.csv", MATRIX, false},
    {"providers.csv", VW_TABLE_PROVIDERS, true},
    {"payout.csv", VW_TABLE_PAYOUT, true},
    {"payout_photos.csv", VW_TABLE_PAYOUT_PHOTOS, true},
};

// Makes a table; one without rows has no text.
static enum vw_status make(const struct findings *findings, const struct table *table, const char *path,
                           struct vw_csv_text *made) {
    const struct vw_results *results = &findings->results;
    const struct vw_value_input *input = &results->input;
    if (table->which == SCORES)
        return vw_report_make_csv(path, results->scores, results->score_count, input->images, input->image_count, made);
    if (table->which == MATRIX)
        return vw_results_have_matrix(results) ? vw_table_make_matrix(path, &results->matrix, results->standard_errors,
                                                                      input->images, input->image_count, made)
                                               : VW_OK;
    const struct vw_rows rows = vw_attribution_rows(&findings->attribution, (enum vw_attribution_table)table->which);
    return rows.count ? vw_rows_make_csv(path, &rows, made) : VW_OK;
}

// ---- Comparison ----------------------------------------------------------------------------------------------------

// Compares the bytes of a table; does not read a file that is larger.
static enum vw_status compare(const struct vw_table_sources *sources, const struct findings *findings,
                              const struct table *table, const char *path) {
    struct vw_csv_text made = {0};
    void *file = NULL;
    size_t file_bytes = 0;
    enum vw_status status = make(findings, table, path, &made);
    bool read = !status && !vw_file_read_inside(sources->out, table->name, made.size_bytes + 1, &file, &file_bytes);
    bool same = read && made.text && file_bytes == made.size_bytes && !memcmp(file, made.text, file_bytes);
    if (!status && !same)
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: is not what the ledger gives: the file was edited%s; restore it from a copy", path,
                         table->by_provider ? ", or made with other --providers: give verify the same" : "");
    free(file);
    free(made.text);
    return status;
}

static enum vw_status verify_table(const struct vw_table_sources *sources, const struct findings *findings,
                                   const struct table *table) {
    enum vw_status status = vw_file_check_inside(sources->out, table->name);
    if (status || !vw_file_exists_inside(sources->out, table->name)) return status;
    char *path = vw_path_join(sources->out, table->name);
    if (!path) return VW_ERROR_MEMORY;
    status = compare(sources, findings, table, path);
    free(path);
    return status;
}

enum vw_status vw_verify_tables(const struct vw_table_sources *sources) {
    struct findings findings = {0};
    enum vw_status status = find(sources, &findings);
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables) && !status; i++)
        status = verify_table(sources, &findings, &tables[i]);
    free_findings(&findings, sources->scoring->input.image_count);
    return status;
}

bool vw_verify_covers(const char *name, bool *by_provider) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        if (strcmp(tables[i].name, name) != 0) continue;
        *by_provider = tables[i].by_provider;
        return true;
    }
    return false;
}

// The tables of a comparison as CSV files.
#include <inttypes.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "experiment/comparison_files.h"

static void print_measures(FILE *stream) {
    for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++)
        fprintf(stream, ",%s", vw_quality_name(quality));
    fputc('\n', stream);
}

static void print_outcomes(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    fputs("list,seed,photo_count,epochs", stream);
    print_measures(stream);
    for (uint32_t l = 0; l < comparison->sets.count; l++)
        for (uint32_t s = 0; s < comparison->training_count; s++) {
            const struct vw_photo_set *list = vw_comparison_list(comparison, l, s);
            vw_csv_write_text(stream, list->name);
            fprintf(stream, ",%" PRIu64 ",%u,%u", comparison->params->common.config->seed + s, list->count,
                    list->epochs);
            for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++) {
                fputc(',', stream);
                vw_csv_write_real(stream, vw_quality_of(&vw_comparison_results(comparison, l)[s], quality));
            }
            fputc('\n', stream);
        }
}

static void print_pair(FILE *stream, const struct vw_comparison *comparison, const struct vw_set_pair *pair,
                       enum vw_quality quality) {
    struct vw_paired_difference paired = vw_comparison_difference(comparison, pair, quality);
    const double values[] = {paired.difference, paired.standard_error, paired.ci_low, paired.ci_high};
    vw_csv_write_text(stream, comparison->sets.lists[pair->list].name);
    fputc(',', stream);
    vw_csv_write_text(stream, comparison->sets.lists[pair->against].name);
    fprintf(stream, ",%s", vw_quality_name(quality));
    for (int v = 0; v < 4; v++) {
        fputc(',', stream);
        vw_csv_write_real(stream, values[v]);
    }
    fprintf(stream, ",%s\n", paired.beyond_noise ? "true" : "false");
}

static void print_pairs(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    fputs("list,against,measure,difference,stderr,ci_low,ci_high,beyond_noise\n", stream);
    for (uint32_t p = 0; p < comparison->pair_count; p++)
        for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++)
            print_pair(stream, comparison, &comparison->pairs[p], quality);
}

static void print_one_sided(FILE *stream, const struct vw_comparison *comparison, const struct vw_photo_set *has,
                            const struct vw_photo_set *has_not) {
    for (uint32_t i = 0; i < has->count; i++) {
        if (vw_photo_set_has(has_not, has->views[i])) continue;
        vw_csv_write_text(stream, comparison->session.scene->views[has->views[i]].name);
        fputc(',', stream);
        vw_csv_write_text(stream, has->name);
        fputc(',', stream);
        vw_csv_write_text(stream, has_not->name);
        fputc('\n', stream);
    }
}

static void print_disagreements(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    const struct vw_photo_sets *sets = &comparison->sets;
    fputs("photo,in,not_in\n", stream);
    for (uint32_t a = 0; a < sets->count; a++)
        for (uint32_t b = 0; b < sets->count; b++)
            if (!vw_comparison_varies(comparison, a) && !vw_comparison_varies(comparison, b))
                print_one_sided(stream, comparison, &sets->lists[a], &sets->lists[b]);
}

static enum vw_status write_table(const struct vw_comparison *comparison, const char *name, vw_csv_printer *print) {
    char *path = vw_path_join(comparison->params->common.out, name);
    enum vw_status status = path ? vw_csv_write_file(path, print, comparison) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_comparison_write_csv(const struct vw_comparison *comparison) {
    enum vw_status status = write_table(comparison, "compare.csv", print_outcomes);
    if (!status) status = write_table(comparison, "pairs.csv", print_pairs);
    if (!status) status = write_table(comparison, "disagreements.csv", print_disagreements);
    return status;
}

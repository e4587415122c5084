// The tables of a comparison as CSV files.
#include <inttypes.h>
#include <stdlib.h>

#include "experiment/set_comparison.h"
#include "value/evaluation/paired_comparison.h"
#include "base/csv.h"
#include "base/file.h"

const struct vw_retrain_result *vw_set_comparison_outcomes(const struct vw_set_comparison *compared, uint32_t list) {
    return compared->outcomes + (size_t)list * compared->options->seeds;
}

static void print_measures(FILE *stream) {
    for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
        fprintf(stream, ",%s", vw_outcome_measure_name(measure));
    fputc('\n', stream);
}

static void print_outcomes(FILE *stream, const void *context) {
    const struct vw_set_comparison *compared = context;
    fputs("list,seed,photo_count,epochs", stream);
    print_measures(stream);
    for (uint32_t l = 0; l < compared->lists->count; l++)
        for (uint32_t s = 0; s < compared->options->seeds; s++) {
            const struct vw_photo_set *list = &compared->lists->lists[l];
            vw_csv_write_text(stream, list->name);
            fprintf(stream, ",%" PRIu64 ",%u,%u", compared->options->config.seed + s, list->count, list->epochs);
            for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++) {
                fputc(',', stream);
                vw_csv_write_real(stream, vw_outcome_of(&vw_set_comparison_outcomes(compared, l)[s], measure));
            }
            fputc('\n', stream);
        }
}

static void print_pair(FILE *stream, const struct vw_set_comparison *compared, const struct vw_set_pair *pair,
                       enum vw_outcome_measure measure) {
    struct vw_paired_difference paired =
        vw_outcomes_compare(vw_set_comparison_outcomes(compared, pair->list),
                            vw_set_comparison_outcomes(compared, pair->against), compared->options->seeds, measure);
    const double values[] = {paired.difference, paired.standard_error, paired.ci_low, paired.ci_high};
    vw_csv_write_text(stream, compared->lists->lists[pair->list].name);
    fputc(',', stream);
    vw_csv_write_text(stream, compared->lists->lists[pair->against].name);
    fprintf(stream, ",%s", vw_outcome_measure_name(measure));
    for (int v = 0; v < 4; v++) {
        fputc(',', stream);
        vw_csv_write_real(stream, values[v]);
    }
    fprintf(stream, ",%s\n", paired.beyond_noise ? "true" : "false");
}

static void print_pairs(FILE *stream, const void *context) {
    const struct vw_set_comparison *compared = context;
    fputs("list,against,measure,difference,stderr,ci_low,ci_high,beyond_noise\n", stream);
    for (uint32_t p = 0; p < compared->pair_count; p++)
        for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
            print_pair(stream, compared, &compared->pairs[p], measure);
}

static void print_one_sided(FILE *stream, const struct vw_set_comparison *compared, const struct vw_photo_set *has,
                            const struct vw_photo_set *has_not) {
    for (uint32_t i = 0; i < has->count; i++) {
        if (vw_photo_set_has(has_not, has->views[i])) continue;
        vw_csv_write_text(stream, compared->scene->views[has->views[i]].name);
        fputc(',', stream);
        vw_csv_write_text(stream, has->name);
        fputc(',', stream);
        vw_csv_write_text(stream, has_not->name);
        fputc('\n', stream);
    }
}

static void print_disagreements(FILE *stream, const void *context) {
    const struct vw_set_comparison *compared = context;
    const struct vw_photo_sets *lists = compared->lists;
    fputs("photo,in,not_in\n", stream);
    for (uint32_t a = 0; a < lists->count; a++)
        for (uint32_t b = 0; b < lists->count; b++)
            if (!lists->lists[a].random && !lists->lists[b].random)
                print_one_sided(stream, compared, &lists->lists[a], &lists->lists[b]);
}

static enum vw_status write_table(const struct vw_set_comparison *compared, const char *name, vw_csv_printer *print) {
    char *path = vw_path_join(compared->options->out, name);
    enum vw_status status = path ? vw_csv_write_file(path, print, compared) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_set_comparison_write_csv(const struct vw_set_comparison *compared) {
    enum vw_status status = write_table(compared, "compare.csv", print_outcomes);
    if (!status) status = write_table(compared, "pairs.csv", print_pairs);
    if (!status) status = write_table(compared, "disagreements.csv", print_disagreements);
    return status;
}

#include "lab/lasting_seeds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "value/lasting_scores.h"

static const char *const methods[VW_LASTING_METHODS] = {"lasting_psnr", "lasting_loss"};

static enum vw_status copy_names(const struct vw_score_tables *tables, const struct vw_value_input *run,
                                 struct vw_lasting_seeds *seeds) {
    seeds->names = vw_allocate(tables->photo_count, sizeof *seeds->names);
    if (!seeds->names) return VW_ERROR_MEMORY;
    seeds->photo_count = tables->photo_count;
    for (uint32_t i = 0; i < tables->photo_count; i++) {
        seeds->names[i] = vw_copy_text(run->images[tables->photos[i]].name);
        if (!seeds->names[i]) return VW_ERROR_MEMORY;
    }
    return VW_OK;
}

static enum vw_status make_means(const struct vw_score_tables *tables, uint32_t method,
                                 struct vw_lasting_seeds *seeds) {
    const struct vw_score_table *table = vw_score_tables_find(tables, methods[method]);
    if (!table)
        return vw_fail(VW_ERROR_INPUT,
                       "the runs have no %s at this number of epochs, because lasting credit covers a whole run; set "
                       "--epochs to theirs",
                       methods[method]);
    seeds->methods[method] = methods[method];
    seeds->units[method] = vw_value_method_find(methods[method])->unit;
    seeds->means[method] = vw_allocate(tables->photo_count, sizeof *seeds->means[method]);
    if (!seeds->means[method]) return VW_ERROR_MEMORY;
    return vw_seed_means_make(table->values, tables->run_count, tables->photo_count, seeds->means[method]);
}

static void print_rows(FILE *stream, const void *context) {
    const struct vw_lasting_seeds *seeds = context;
    fputs("name,method,unit,seeds,mean,stderr,ci_low,ci_high,rank,rank_ci_low,rank_ci_high,indistinguishable_from\n",
          stream);
    for (uint32_t method = 0; method < VW_LASTING_METHODS; method++)
        for (uint32_t i = 0; i < seeds->photo_count; i++) {
            const struct vw_seed_mean *mean = &seeds->means[method][i];
            const double values[] = {mean->mean, mean->standard_error, mean->ci_low, mean->ci_high};
            vw_csv_write_text(stream, seeds->names[i]);
            fprintf(stream, ",%s,%s,%u", seeds->methods[method], seeds->units[method], seeds->seed_count);
            for (size_t v = 0; v < VW_ARRAY_COUNT(values); v++) {
                fputc(',', stream);
                vw_csv_write_real(stream, values[v]);
            }
            fprintf(stream, ",%u,%u,%u,%u\n", mean->rank, mean->rank_ci_low, mean->rank_ci_high, mean->overlaps);
        }
}

enum vw_status vw_lasting_seeds_make(const char *out, const struct vw_score_tables *tables,
                                     const struct vw_value_input *runs, struct vw_lasting_seeds *seeds) {
    *seeds = (struct vw_lasting_seeds){.seed_count = tables->run_count,
                                       .gates = vw_allocate(tables->run_count, sizeof *seeds->gates),
                                       .path = vw_path_join(out, "lasting_seeds.csv")};
    enum vw_status status = seeds->gates && seeds->path ? copy_names(tables, runs, seeds) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < VW_LASTING_METHODS; i++) status = make_means(tables, i, seeds);
    if (status) return status;
    for (uint32_t i = 0; i < tables->run_count; i++) seeds->gates[i] = vw_lasting_gate(&runs[i].lasting, false);
    uint64_t overlaps = 0, photos = seeds->photo_count;
    for (uint32_t i = 0; i < photos; i++) overlaps += seeds->means[0][i].overlaps; // every pair twice
    seeds->pairs = photos ? photos * (photos - 1) / 2 : 0;
    seeds->told_apart = seeds->pairs - overlaps / 2;
    return vw_csv_write_file(seeds->path, print_rows, seeds);
}

void vw_lasting_seeds_free(struct vw_lasting_seeds *seeds) {
    for (uint32_t i = 0; seeds->names && i < seeds->photo_count; i++) free(seeds->names[i]);
    for (uint32_t i = 0; i < VW_LASTING_METHODS; i++) free(seeds->means[i]);
    free(seeds->names);
    free(seeds->gates);
    free(seeds->path);
    *seeds = (struct vw_lasting_seeds){0};
}

// Lasting credit of several seeds: its mean by photo, with an interval over seeds, and what cannot be told apart.
#ifndef VIEWWORTH_LAB_LASTING_SEEDS_H
#define VIEWWORTH_LAB_LASTING_SEEDS_H

#include <stdint.h>

#include "lab/evaluation/seed_means.h"
#include "value/evaluation/score_tables.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

enum { VW_LASTING_METHODS = 2 }; // lasting_psnr, lasting_loss

struct vw_lasting_seeds {
    uint32_t seed_count, photo_count;               // photo_count 0: no run was swept
    char **names;                                   // owned, and each of them; by photo
    struct vw_seed_mean *means[VW_LASTING_METHODS]; // owned; by photo
    const char *methods[VW_LASTING_METHODS], *units[VW_LASTING_METHODS];
    double *gates;              // owned; by seed: Pearson of predicted against measured PSNR; NaN: no gate
    uint64_t pairs, told_apart; // pairs of photos; those whose intervals of lasting_psnr do not overlap
    char *path;                 // owned; of the table
};

// Makes the means from the scores of all seeds (`tables`) and their backward passes. Writes OUT/lasting_seeds.csv:
// header name,method,unit,seeds,mean,stderr,ci_low,ci_high,rank,rank_ci_low,rank_ci_high,indistinguishable_from; a row
// per method and photo. indistinguishable_from: the number of photos whose intervals overlap. Free it also after a
// failure.
enum vw_status vw_lasting_seeds_make(const char *out, const struct vw_score_tables *tables,
                                     const struct vw_value_input *runs, struct vw_lasting_seeds *seeds);
void vw_lasting_seeds_free(struct vw_lasting_seeds *seeds);

#endif

#include "lab/reproduced_methods.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// Copies the scorers' photos: they belong to a retrainer, which ends earlier.
static enum vw_status keep_photos(struct vw_reproduced_methods *methods) {
    struct vw_evaluation *evaluation = &methods->scorers->evaluation;
    methods->photos = vw_allocate(evaluation->photo_count, sizeof *methods->photos);
    if (!methods->photos) return VW_ERROR_MEMORY;
    memcpy(methods->photos, evaluation->photos, evaluation->photo_count * sizeof *methods->photos);
    evaluation->photos = methods->photos;
    return VW_OK;
}

enum vw_status vw_reproduced_methods_make(const struct vw_experiment_params *params,
                                          const struct vw_method_params *evaluated, struct vw_session *session,
                                          struct vw_reproduced_methods *methods) {
    struct vw_retrainer retrainer = {0};
    if (!evaluated->methods) return VW_OK;
    methods->scorers = vw_allocate(1, sizeof *methods->scorers);
    enum vw_status status = methods->scorers ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_scorers_open_retrainer(params, session, VW_EQUAL_STEPS, &retrainer);
    if (!status) status = vw_scorers_make(params, &retrainer, params->seeds, methods->scorers);
    if (!status) retrainer.planned = vw_method_scorers_count(evaluated, params->seeds, &retrainer);
    if (!status) status = vw_method_scorers_add(evaluated, &retrainer, methods->scorers, &methods->names);
    if (!status) status = keep_photos(methods);
    vw_retrainer_close(&retrainer);
    return status;
}

static bool differs_between_runs(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer) {
    size_t photos = evaluation->photo_count, values = photos * evaluation->seed_count;
    bool differs = false;
    for (size_t i = photos; i < values; i++) differs |= scorer->scores[i] != scorer->scores[i % photos];
    return differs;
}

static enum vw_status add_table(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                const struct vw_ledger_image *images, struct vw_score_tables *tables) {
    const struct vw_score_table described = {scorer->name, .unit = "", .has_zero = scorer->has_sign};
    struct vw_score_table *table = vw_score_tables_add(tables, &described);
    if (!table) return VW_ERROR_MEMORY;
    for (uint32_t photo = 0; photo < tables->photo_count; photo++) {
        uint32_t place = 0;
        while (place < evaluation->photo_count && evaluation->photos[place] != images[tables->photos[photo]].image_id)
            place++;
        for (uint32_t run = 0; place < evaluation->photo_count && run < tables->run_count; run++)
            table->values[(size_t)run * tables->photo_count + photo] =
                scorer->scores[(size_t)run * evaluation->photo_count + place];
    }
    return VW_OK;
}

enum vw_status vw_reproduced_methods_add(const struct vw_reproduced_methods *methods,
                                         const struct vw_ledger_image *images, struct vw_score_tables *tables) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; methods->scorers && !status && i < methods->scorers->evaluation.scorer_count; i++) {
        const struct vw_evaluation *evaluation = &methods->scorers->evaluation;
        const struct vw_scorer *scorer = &evaluation->scorers[i];
        if (!vw_score_tables_find(tables, scorer->name) && differs_between_runs(evaluation, scorer))
            status = add_table(evaluation, scorer, images, tables);
    }
    return status;
}

const struct vw_scorer_cost *vw_reproduced_methods_cost(const struct vw_reproduced_methods *methods,
                                                        const char *method) {
    for (uint32_t i = 0; methods->scorers && i < methods->scorers->evaluation.scorer_count; i++)
        if (!strcmp(methods->scorers->list[i].name, method)) return &methods->scorers->costs[i];
    return NULL;
}

void vw_reproduced_methods_free(struct vw_reproduced_methods *methods) {
    if (methods->scorers) vw_scorers_free(methods->scorers);
    free(methods->scorers);
    free(methods->names);
    free(methods->photos);
}

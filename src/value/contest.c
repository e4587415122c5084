#include "value/contest.h"

#include <stdio.h>
#include <string.h>

#include "viewworth/memory.h"

const char vw_contest_reference[] = "dv_psnr";

enum vw_status vw_judgements_add(struct vw_judgements *judgements, const char *group, const char *name, struct vw_judgement row) {
    enum vw_status status = vw_grow((void **)&judgements->rows, &judgements->capacity, judgements->count + 1, sizeof *judgements->rows);
    if (status) return status;
    snprintf(row.judgement, sizeof row.judgement, "%s/%s", group, name);
    judgements->rows[judgements->count++] = row;
    return VW_OK;
}

const struct vw_judgement *vw_judgements_find(const struct vw_judgements *judgements, const char *group, const char *name,
                                              const char *method) {
    char judgement[VW_JUDGEMENT_BYTES];
    snprintf(judgement, sizeof judgement, "%s/%s", group, name);
    for (size_t i = 0; i < judgements->count; i++)
        if (!strcmp(judgements->rows[i].judgement, judgement) && !strcmp(judgements->rows[i].method, method)) return &judgements->rows[i];
    return NULL;
}

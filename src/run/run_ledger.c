#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "run/run_private.h"
#include "run/run_row.h"

static enum vw_status list_images(const struct vw_scene *scene, struct vw_ledger_image **images,
                                  char (**hashes)[VW_HASH_HEX_BYTES]) {
    *images = vw_allocate(scene->view_count, sizeof **images);
    *hashes = vw_allocate(scene->view_count, sizeof **hashes);
    if (!*images || !*hashes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_view *view = &scene->views[i];
        vw_hash_to_hex(view->sha256, (*hashes)[i]);
        (*images)[i] = (struct vw_ledger_image){
            .image_id = i,
            .name = view->name,
            .split = vw_split_name(view->split),
            .provider = view->provider,
            .sha256 = (*hashes)[i],
            .ground_truth = view->ground_truth,
        };
    }
    return VW_OK;
}

static enum vw_status write_first_rows(struct vw_run *run, const struct vw_ledger_image *images) {
    struct vw_run_row first;
    char started_utc[VW_UTC_BYTES];
    enum vw_status status = vw_run_row_make(run->trainer, run->gpu, run->scene, &run->config, &first);
    vw_utc_now(started_utc);
    first.row.started_utc = started_utc;
    first.row.scene_options_json = run->scene_options_json;
    first.row.plan_json = run->results.plan.json;
    if (!status)
        status = vw_ledger_create(run->results.ledger_path, &first.row, images, run->scene->view_count, &run->ledger);
    vw_run_row_free(&first);
    return status;
}

enum vw_status vw_run_create_ledger(struct vw_run *run) {
    struct vw_ledger_image *images = NULL;
    char(*hashes)[VW_HASH_HEX_BYTES] = NULL;
    enum vw_status status = list_images(run->scene, &images, &hashes);
    if (!status) status = write_first_rows(run, images);
    free(images);
    free(hashes);
    return status;
}

void vw_run_end_early(struct vw_run *run, enum vw_status status) {
    struct vw_ledger_run row;
    struct vw_saved_error why = vw_error_save();
    if (!vw_ledger_get_run(run->ledger, &row) && strcmp(row.status, "running") == 0 && status != VW_ERROR_MISMATCH) {
        const char *outcome = status == VW_ERROR_INTERRUPTED ? "interrupted" : "failed";
        vw_scoring_end_early(run->ledger, &run->config, outcome);
    }
    vw_error_restore(&why);
}

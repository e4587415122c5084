// Photos ranked by a method's scores, as text and as JSON from the same rows.
#ifndef VIEWWORTH_CLI_OUTPUT_RANKING_H
#define VIEWWORTH_CLI_OUTPUT_RANKING_H

#include <jansson.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/scene.h"

// Borrows everything.
struct vw_ranking {
    const struct vw_ledger_score *scores; // the scores of one method, best first
    uint32_t count;
    const struct vw_scene *scene;         // names the photos; NULL: `images` do
    const struct vw_ledger_image *images; // sorted by image_id
    uint32_t image_count;
    const struct vw_ledger_score *qualities; // scores, `quality` among them; NULL: quality is not shown
    uint32_t quality_count;
    uint32_t judge_count; // validation photos; 0: those of the scene, or of `images`
    double gain_db;       // gain of the training: credit in dB is shown as a share of it if it is above 0
};

enum vw_ranking_rows { VW_RANKING_ALL, VW_RANKING_HIGHEST, VW_RANKING_LOWEST };

// Prints at most three photos at each end, each only once unless it is the only one, under the two headings,
// by names without the folder that all photos share. With fewer than 4 validation photos no rank is told, and why is
// said.
void vw_ranking_print(const struct vw_ranking *ranking, const char *highest, const char *lowest);
// Returns an array of the rows, the lowest first for VW_RANKING_LOWEST; NULL when memory is short.
json_t *vw_ranking_to_json(const struct vw_ranking *ranking, enum vw_ranking_rows rows);

#endif

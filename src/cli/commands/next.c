#include "run/next/next.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"

static json_t *place_to_json(const struct vw_candidate *candidate, double gain) {
    const double(*pose)[4] = candidate->pose.camera_to_world;
    return json_pack("{s:o, s:o, s:[fff]}", "name", vw_json_string(candidate->name), "gain", vw_json_real(gain),
                     "position", pose[0][3], pose[1][3], pose[2][3]);
}

static json_t *to_json(const struct vw_next *next) {
    json_t *root = json_object(), *proposals = json_array(), *alone = json_array();
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        const struct vw_proposal *proposal = &next->proposals[k];
        vw_json_append(&proposals, place_to_json(&next->candidates[proposal->candidate], proposal->gain));
    }
    for (uint32_t i = 0; i < next->candidate_count; i++)
        vw_json_append(&alone, place_to_json(&next->candidates[i], next->first_gains[i]));
    vw_json_set(&root, "method", json_string(next->method));
    vw_json_set(&root, "proposals", proposals);
    vw_json_set(&root, "candidates", alone);
    return root;
}

static void print_text(const struct vw_next *next) {
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        const struct vw_candidate *candidate = &next->candidates[next->proposals[k].candidate];
        const double(*pose)[4] = candidate->pose.camera_to_world;
        vw_print("%2u  %10.3g  %9.3g %9.3g %9.3g  %s\n", k + 1, next->proposals[k].gain, pose[0][3], pose[1][3],
                 pose[2][3], candidate->name ? candidate->name : "");
    }
}

enum vw_status vw_command_next(const struct vw_options *options) {
    const struct vw_next_params params = {.out = options->operand,
                                          .among = options->among,
                                          .method = options->method,
                                          .device = options->device,
                                          .count = options->proposals};
    struct vw_next next;
    enum vw_status status = vw_next_make(&params, &next);
    if (!status && options->json) status = vw_json_print(to_json(&next));
    else if (!status) print_text(&next);
    vw_next_free(&next);
    return status;
}

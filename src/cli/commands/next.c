#include "run/next/next.h"

#include <stdio.h>

#include "base/json.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"

static json_t *to_json(const struct vw_options *options, const struct vw_next *next) {
    json_t *root = vw_proposals_to_json(next);
    vw_json_set(&root, "to", vw_json_string(options->to));
    return root;
}

static void print_row(const struct vw_next *next, uint32_t place) {
    const struct vw_proposal *proposal = &next->proposals[place];
    const char *name = proposal->pose->name;
    char seen_by[64];
    snprintf(seen_by, sizeof seen_by, "%.0f of %u photos", proposal->seen_by, next->photo_count);
    vw_print("%2u  %8.1f  %-16s  %-25s  %s%s%s\n", place + 1, proposal->apart, seen_by, proposal->reason,
             proposal->move, name ? "  " : "", name ? name : "");
}

static void print_text(const struct vw_options *options, const struct vw_next *next) {
    vw_print("%u of %u places, the farthest from photos first, weighted by the error there\n", next->proposal_count,
             next->candidates.count);
    vw_print(" n  distance  seen by           why                        from the nearest photo\n");
    for (uint32_t k = 0; k < next->proposal_count; k++) print_row(next, k);
    vw_print("renders  %s/" VW_NEXT_RENDER_NAME " ...; viewworth report %s shows the places on its map\n",
             options->operand, 1u, options->operand);
    if (options->to) vw_print("poses    %s\n", options->to);
}

enum vw_status vw_command_next(const struct vw_options *options) {
    const struct vw_next_params params = {.out = options->operand,
                                          .among = options->among,
                                          .to = options->to,
                                          .device = options->device,
                                          .count = options->proposals};
    struct vw_next next;
    enum vw_status status = vw_next_make(&params, &next);
    if (!status && options->json) status = vw_json_print(to_json(options, &next));
    else if (!status) print_text(options, &next);
    vw_next_free(&next);
    return status;
}

// The files of proposals: renders and next.json in OUT, and poses for other programs.
#ifndef VIEWWORTH_RUN_NEXT_PROPOSAL_FILES_H
#define VIEWWORTH_RUN_NEXT_PROPOSAL_FILES_H

#include "run/next/proposals.h"

struct vw_trainer;

enum { VW_NEXT_RENDER_WIDTH_MOST_PX = 480 };

struct vw_proposal_files { // all borrowed
    const char *out;
    const char
        *to; // .json: a transforms.json; .ply: cameras as pyramids, the first yellow, the last violet; NULL: none
    const struct vw_scene *scene;
    struct vw_trainer *trainer; // holds the field
    const struct vw_next *next;
};

// Replaces those of an earlier call: takes next.json away, writes what each pose would see, and next.json last. So a
// killed call leaves none that is of other renders. An effect that sees photos sees a pose by its nearest photo.
enum vw_status vw_proposal_files_write(const struct vw_proposal_files *files);

#endif

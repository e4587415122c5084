// The files of proposals: renders and next.json in OUT, and poses for other programs.
#ifndef VIEWWORTH_RUN_NEXT_PROPOSAL_FILES_H
#define VIEWWORTH_RUN_NEXT_PROPOSAL_FILES_H

#include "run/next/proposals.h"

struct vw_trainer;

enum { VW_NEXT_RENDER_SIDE_MOST_PX = 480 }; // a WebP file of noise, too, is then below VW_WEBP_TEXT_LIMIT_BYTES

struct vw_proposal_files { // all borrowed
    const char *out;
    // .json: a transforms.json of poses, its file_path the name of the render in OUT, its sizes those of the run's
    // photos; .ply: cameras as pyramids, the first yellow, the last violet; NULL: none
    const char *to;
    const struct vw_scene *scene;
    struct vw_trainer *trainer; // has the field
    const struct vw_next *next;
};

// Writes `to`, then replaces what an earlier call left in OUT: removes next.json, writes what each pose would see,
// removes further renders, and writes next.json last, with pictures. So a killed call leaves none that is of other
// renders. After a failure there is no `to`. An effect that sees photos sees a pose by its nearest photo.
enum vw_status vw_proposal_files_write(const struct vw_proposal_files *files);

#endif

// The results of a check as rows: for CSV, JSON and text.
#ifndef VIEWWORTH_CHECK_TABLE_H
#define VIEWWORTH_CHECK_TABLE_H

#include "base/rows.h"
#include "check/check.h"

enum { VW_CHECK_DEFECTS_BYTES = 128 };

// A photo with its defects and the evidence. Names are the scene's.
struct vw_check_row {
    const char *name, *split;
    const char *defect;                     // the word of the first one; NULL: none was found
    char defects[VW_CHECK_DEFECTS_BYTES];   // all words, with semicolons between
    char description[VW_DEFECT_TEXT_BYTES]; // the first defect
    const char *remedy;
    const char *shows, *copy_of; // names; NULL: none
    const struct vw_photo_evidence *evidence;
};

// Makes a row for each photo that is not excluded, in scene order; owned by the caller (free), it borrows from the
// scene and the check. VW_ERROR_MEMORY.
enum vw_status vw_check_make_rows(const struct vw_scene *scene, const struct vw_check *check,
                                  struct vw_check_row **rows, uint32_t *count);
// Checks a scene, and finds a finding for each of its views, in their order; owned by the caller (free).
enum vw_status vw_photo_findings_make(const struct vw_scene *scene, struct vw_photo_finding **findings);
// Tells the photos with defects, a line each (no newline), a few at most, and then how many more there are.
void vw_photo_findings_tell(const struct vw_scene *scene, const struct vw_photo_finding *findings,
                            void (*tell)(const char *line));
// Returns the columns: name,split,defects,description,remedy, then the evidence.
struct vw_rows vw_check_rows(const struct vw_check_row *rows, uint32_t count);
// Returns the columns of the photos that have defects, for people.
struct vw_rows vw_check_text_rows(const struct vw_check_row *rows, uint32_t count);

#endif

#include "check/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static const char *name_of(const struct vw_scene *scene, uint32_t view) {
    return view == UINT32_MAX ? NULL : scene->views[view].name;
}

static void add_defect(const struct vw_scene *scene, const struct vw_defect *defect, struct vw_check_row *row) {
    size_t length = strlen(row->defects);
    const char *word = vw_defect_words[defect->kind];
    snprintf(row->defects + length, sizeof row->defects - length, "%s%s", length ? "; " : "", word);
    if (row->defect) return;
    row->defect = word;
    row->remedy = vw_defect_remedy(defect);
    (void)vw_defect_describe(defect, name_of(scene, defect->other), row->description);
}

enum vw_status vw_check_make_rows(const struct vw_scene *scene, const struct vw_check *check,
                                  struct vw_check_row **rows, uint32_t *count) {
    struct vw_check_row *made = vw_allocate(scene->view_count, sizeof *made);
    uint32_t made_count = 0;
    if (!made) return VW_ERROR_MEMORY;
    for (uint32_t v = 0, d = 0; v < scene->view_count; v++) {
        const struct vw_photo_evidence *evidence = &check->evidence[v];
        if (scene->views[v].split == VW_SPLIT_EXCLUDED) continue; // it has no defect
        struct vw_check_row *row = &made[made_count++];
        *row = (struct vw_check_row){.name = scene->views[v].name,
                                     .split = vw_split_name(scene->views[v].split),
                                     .shows = name_of(scene, evidence->shows),
                                     .copy_of = name_of(scene, evidence->copy_of),
                                     .evidence = evidence};
        for (; d < check->defect_count && check->defects[d].view == v; d++) add_defect(scene, &check->defects[d], row);
    }
    *rows = made;
    *count = made_count;
    return VW_OK;
}

enum vw_status vw_photo_findings_make(const struct vw_scene *scene, struct vw_photo_finding **findings) {
    struct vw_check check;
    struct vw_photo_finding *made = vw_allocate(scene->view_count, sizeof *made);
    enum vw_status status = made ? vw_check_scene(scene, &check) : VW_ERROR_MEMORY;
    if (status) {
        free(made);
        return status;
    }
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_photo_evidence *evidence = &check.evidence[v];
        made[v] = (struct vw_photo_finding){.in_place = evidence->in_place,
                                            .hidden = evidence->hidden,
                                            .turned_deg = evidence->turned_deg,
                                            .stops = evidence->stops,
                                            .sharpness = evidence->sharpness,
                                            .noise = evidence->noise,
                                            .covered = NAN};
    }
    for (uint32_t i = check.defect_count; i-- > 0;) { // the first of a photo stays
        const struct vw_defect *defect = &check.defects[i];
        made[defect->view].word = vw_defect_words[defect->kind];
        (void)vw_defect_describe(defect, name_of(scene, defect->other), made[defect->view].description);
    }
    vw_check_free(&check);
    *findings = made;
    return VW_OK;
}

void vw_photo_findings_tell(const struct vw_scene *scene, const struct vw_photo_finding *findings,
                            void (*tell)(const char *line)) {
    enum { SHOWN = 8 };
    uint32_t count = 0;
    char line[2 * VW_DEFECT_TEXT_BYTES];
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!findings[v].word || count++ >= SHOWN) continue;
        snprintf(line, sizeof line, "look at  %.200s: %s, %s", scene->views[v].name, findings[v].word,
                 findings[v].description);
        vw_text_make_line(line); // a name may have been cut within a character
        tell(line);
    }
    if (count <= SHOWN) return;
    snprintf(line, sizeof line, "         and %u more: viewworth check has all photos", count - SHOWN);
    tell(line);
}

#define OF_ROW(name, kind, member)                                                                                     \
    { VW_CELL(name, struct vw_check_row, kind, member) }
#define OF_EVIDENCE(name, kind, member)                                                                                \
    { VW_CELL_VIA(name, struct vw_check_row, evidence, kind, struct vw_photo_evidence, member) }
static const struct vw_column columns[] = {
    OF_ROW("name", TEXT, name),
    OF_ROW("split", TEXT, split),
    OF_ROW("defects", CHARS, defects),
    OF_ROW("description", CHARS, description),
    OF_ROW("remedy", TEXT_OR_NULL, remedy),
    OF_EVIDENCE("expected_points", COUNT, expected_count),
    OF_EVIDENCE("in_place", REAL_OR_NULL, in_place),
    OF_EVIDENCE("hidden_share", REAL_OR_NULL, hidden),
    OF_EVIDENCE("contrast", REAL_OR_NULL, contrast),
    OF_EVIDENCE("stops", REAL_OR_NULL, stops),
    OF_EVIDENCE("stops_spread", REAL_OR_NULL, stops_spread),
    OF_EVIDENCE("sharpness", REAL_OR_NULL, sharpness),
    OF_EVIDENCE("sharpness_high", REAL_OR_NULL, sharpness_high),
    OF_EVIDENCE("evenness", REAL_OR_NULL, evenness),
    OF_EVIDENCE("motion_deg", REAL_OR_NULL, motion_deg),
    OF_EVIDENCE("noise", REAL_OR_NULL, noise),
    OF_EVIDENCE("turned_deg", REAL_OR_NULL, turned_deg),
    OF_EVIDENCE("moved_px", REAL_OR_NULL, moved_px),
    OF_EVIDENCE("found_in_place", REAL_OR_NULL, found_in_place),
    OF_EVIDENCE("zoom", REAL_OR_NULL, zoom),
    OF_EVIDENCE("zoomed_in_place", REAL_OR_NULL, zoomed_in_place),
    OF_ROW("shows", TEXT_OR_NULL, shows),
    OF_EVIDENCE("shows_in_place", REAL_OR_NULL, shows_in_place),
    OF_EVIDENCE("turned_over_in_place", REAL_OR_NULL, turned_over_in_place),
    OF_EVIDENCE("exif_orientation", COUNT, orientation),
    OF_ROW("copy_of", TEXT_OR_NULL, copy_of),
    OF_EVIDENCE("similarity", REAL_OR_NULL, similarity),
    OF_EVIDENCE("tracks", COUNT, tracks),
    OF_EVIDENCE("track_px", REAL_OR_NULL, track_px),
    OF_EVIDENCE("behind_share", REAL_OR_NULL, behind),
};
static const struct vw_column text_columns[] = {
    {VW_CELL("name", struct vw_check_row, TEXT, name), .title = "photo"},
    {VW_CELL("defects", struct vw_check_row, CHARS, defects), .title = "defect"},
    {VW_CELL("description", struct vw_check_row, CHARS, description), .title = "which is"},
    {VW_CELL("remedy", struct vw_check_row, TEXT_OR_NULL, remedy), .title = "to do"},
};

struct vw_rows vw_check_rows(const struct vw_check_row *rows, uint32_t count) {
    return VW_ROWS(columns, rows, count);
}

struct vw_rows vw_check_text_rows(const struct vw_check_row *rows, uint32_t count) {
    return VW_ROWS(text_columns, rows, count);
}

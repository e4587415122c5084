// The split files of NeRF-W: tab-separated, with a header that has at least the columns filename and split, in any
// order. Photos are identified by their file names. The column id is not used for that: it may be a whole number,
// "1091.0" or empty, and does not match the COLMAP models.
#ifndef VIEWWORTH_SCENE_FORMATS_NERFW_TSV_H
#define VIEWWORTH_SCENE_FORMATS_NERFW_TSV_H

#include <stdbool.h>
#include <stddef.h>

#include "viewworth/status.h"

struct vw_tsv_row {
    const char *name; // name of the photo; relative and safe (see vw_path_leaves_folder), unique in the file
    bool test;        // split is test; else train
    bool has_id;      // programs that look photos up by id ignore rows without one
    int line;
};

// Column indices; -1: none.
struct vw_tsv_columns {
    int filename, split, id, count;
};

struct vw_tsv {
    char *text;              // owned; all names and fields point into it
    struct vw_tsv_row *rows; // owned; in file order
    size_t row_count, test_count;
    struct vw_tsv_columns columns;
    char **fields; // owned: the header's, then those of each row, by column
};

// Reads a TSV. `folder` is the scene's, in which the file must lie; NULL for a file that the user named. VW_ERROR_INPUT
// with one line that names the file and the line. The caller frees it with vw_tsv_clear().
enum vw_status vw_tsv_read(const char *folder, const char *path, struct vw_tsv *tsv);
void vw_tsv_clear(struct vw_tsv *tsv); // accepts an empty one
char *const *vw_tsv_fields(const struct vw_tsv *tsv, size_t row);

// Returns whether a file begins with such a header.
bool vw_tsv_has_header(const char *folder, const char *path);

// Reads the one TSV of a scene folder (phototourism.c).
enum vw_status vw_phototourism_read_tsv(const char *folder, struct vw_tsv *tsv);

#endif

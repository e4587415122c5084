#include "scene/formats/photo_list.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/colmap.h"
#include "scene/formats/nerfw_tsv.h"
#include "scene/formats/transforms.h"

bool vw_photo_list_keeps(const struct vw_listed_photo *photo) {
    return photo->chosen || photo->split == VW_SPLIT_VAL || photo->split == VW_SPLIT_TEST;
}

enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo) {
    return vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that was valued: it lacks %s; restore it", list->scene_path,
                   photo->name);
}

static enum vw_status check_new(const struct vw_photo_list *list) {
    struct stat info;
    if (lstat(list->to, &info) != 0) return VW_OK; // writing reports any other problem with the path
    return vw_fail(VW_ERROR_USAGE, "--to %s: exists; name a new file, or remove that one", list->to);
}

// ---- A name a line --------------------------------------------------------------------------------------------------

// Returns whether a reader that trims lines reads the name back.
static bool fits_a_line(const char *name) {
    size_t length = strlen(name);
    return length > 0 && vw_text_is_clean(name) && !isspace((unsigned char)name[0]) &&
           !isspace((unsigned char)name[length - 1]);
}

static void print_names(FILE *stream, const void *context) {
    const struct vw_photo_list *list = context;
    for (uint32_t i = 0; i < list->photo_count; i++)
        if (list->photos[i].chosen) fprintf(stream, "%s\n", list->photos[i].name);
}

static enum vw_status write_names(const struct vw_photo_list *list) {
    for (uint32_t i = 0; i < list->photo_count; i++)
        if (list->photos[i].chosen && !fits_a_line(list->photos[i].name))
            return vw_fail(
                VW_ERROR_INPUT,
                "photo %u (%s): the name has a line end, or a space at its start or end, and cannot be in a list; "
                "rename it",
                i, list->photos[i].name);
    enum vw_status status = check_new(list);
    return status || list->check_only ? status : vw_csv_write_file(list->to, print_names, list);
}

// ---- NeRF-W's TSV ---------------------------------------------------------------------------------------------------

static const char photo_folder[] = "dense/images/"; // names of views begin with it, names in the TSV do not

struct tsv_list {
    const struct vw_photo_list *list;
    struct vw_tsv tsv;
    struct vw_colmap_model model;
    const struct vw_listed_photo **photos; // owned; per row; NULL: the photo was not valued
    bool *has_row;                         // owned: of each photo
};

// Returns the photo's name in the TSV and in the model; NULL if it is not in this folder.
static const char *name_of(const struct vw_listed_photo *photo) {
    size_t length = strlen(photo_folder);
    return strncmp(photo->name, photo_folder, length) == 0 ? vw_view_name_of(photo->name + length) : NULL;
}

static enum vw_status match_rows(struct tsv_list *made, const struct vw_name_index *rows) {
    const struct vw_photo_list *list = made->list;
    made->photos = vw_allocate(made->tsv.row_count, sizeof *made->photos);
    made->has_row = vw_allocate(list->photo_count, sizeof *made->has_row);
    if (!made->photos || !made->has_row) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < list->photo_count; i++) {
        const char *name = name_of(&list->photos[i]);
        if (!name || vw_colmap_find_image(&made->model, name) < 0)
            return vw_photo_list_refuse_missing(list, &list->photos[i]);
        size_t row = 0;
        made->has_row[i] = vw_name_index_find(rows, name, &row);
        if (made->has_row[i]) made->photos[row] = &list->photos[i];
    }
    return VW_OK;
}

static enum vw_status read_scene(const char *folder, struct tsv_list *made) {
    struct vw_name_index rows = {0};
    char *dense = vw_path_join(folder, "dense"), *model_folder = dense ? vw_colmap_find(dense) : NULL;
    enum vw_status status = dense ? vw_phototourism_read_tsv(folder, &made->tsv) : VW_ERROR_MEMORY;
    if (!status && !model_folder) status = vw_fail(VW_ERROR_INPUT, "%s/sparse: no COLMAP model; restore it", dense);
    if (!status) status = vw_colmap_read(model_folder, folder, &made->model);
    if (!status)
        status = vw_name_index_make(made->tsv.rows, sizeof *made->tsv.rows, offsetof(struct vw_tsv_row, name),
                                    made->tsv.row_count, &rows);
    if (!status) status = match_rows(made, &rows);
    vw_name_index_clear(&rows);
    free(model_folder);
    free(dense);
    return status;
}

// Refuses a second TSV in the scene's folder, which would make the scene ambiguous.
static enum vw_status check_target(const struct vw_photo_list *list) {
    struct stat scene, place;
    char *parent = vw_path_folder(list->to);
    enum vw_status status = parent ? check_new(list) : VW_ERROR_MEMORY;
    bool same = !status && !stat(parent, &place) && !stat(list->scene_path, &scene) && scene.st_dev == place.st_dev &&
                scene.st_ino == place.st_ino;
    if (same)
        status = vw_fail(VW_ERROR_USAGE,
                         "--to %s: a scene folder may have only one TSV, and it has %s; write the list elsewhere",
                         list->to, list->scene_path);
    free(parent);
    return status;
}

// Returns the row to write; NULL: it is left out. Rows of photos that were not valued stay if they are test rows.
static const char *split_of(const struct vw_tsv_row *row, const struct vw_listed_photo *photo) {
    if (photo && photo->chosen) return "train";
    if (photo && photo->split == VW_SPLIT_TRAIN) return NULL;
    return row->test || (photo && vw_photo_list_keeps(photo)) ? "test" : NULL;
}

static void print_id(FILE *stream, const struct tsv_list *made, const char *name) {
    ptrdiff_t image = vw_colmap_find_image(&made->model, name);
    if (image >= 0) fprintf(stream, "%u", made->model.images[image].id);
}

static void print_row(FILE *stream, const struct tsv_list *made, size_t row, const char *split) {
    const struct vw_tsv_columns *columns = &made->tsv.columns;
    const struct vw_tsv_row *of = &made->tsv.rows[row];
    char *const *fields = vw_tsv_fields(&made->tsv, row);
    for (int c = 0; c < columns->count; c++) {
        if (c > 0) fputc('\t', stream);
        if (c == columns->id && !of->has_id && made->photos[row] && made->photos[row]->chosen)
            print_id(stream, made, of->name);
        else fputs(c == columns->split ? split : fields[c], stream);
    }
    fputc('\n', stream);
}

// Makes a row for a photo that is not in the TSV; its dataset is that of the other rows.
static void print_added(FILE *stream, const struct tsv_list *made, const char *name) {
    const struct vw_tsv_columns *columns = &made->tsv.columns;
    char *const *header = made->tsv.fields, *const *first = vw_tsv_fields(&made->tsv, 0);
    for (int c = 0; c < columns->count; c++) {
        if (c > 0) fputc('\t', stream);
        if (c == columns->filename) fputs(name, stream);
        else if (c == columns->split) fputs("train", stream);
        else if (c == columns->id) print_id(stream, made, name);
        else if (strcmp(header[c], "dataset") == 0) fputs(first[c], stream);
    }
    fputc('\n', stream);
}

static void print_tsv(FILE *stream, const void *context) {
    const struct tsv_list *made = context;
    for (int c = 0; c < made->tsv.columns.count; c++) fprintf(stream, "%s%s", c > 0 ? "\t" : "", made->tsv.fields[c]);
    fputc('\n', stream);
    for (size_t row = 0; row < made->tsv.row_count; row++) {
        const char *split = split_of(&made->tsv.rows[row], made->photos[row]);
        if (split) print_row(stream, made, row, split);
    }
    for (uint32_t i = 0; i < made->list->photo_count; i++)
        if (made->list->photos[i].chosen && !made->has_row[i])
            print_added(stream, made, name_of(&made->list->photos[i]));
}

static enum vw_status write_tsv(const struct vw_photo_list *list) {
    struct tsv_list made = {.list = list};
    enum vw_status status = check_target(list);
    if (!status) status = read_scene(list->scene_path, &made);
    if (!status && !list->check_only) status = vw_csv_write_file(list->to, print_tsv, &made);
    vw_tsv_clear(&made.tsv);
    vw_colmap_clear(&made.model);
    free(made.photos);
    free(made.has_row);
    return status;
}

// ---- All lists ------------------------------------------------------------------------------------------------------

const char *vw_photo_list_format(const char *to) { return vw_path_ends_with(to, ".tsv") ? "phototourism" : "text"; }

enum vw_status vw_photo_list_write(const struct vw_photo_list *list) {
    if (vw_path_ends_with(list->to, ".txt")) return write_names(list);
    if (!vw_path_ends_with(list->to, ".tsv"))
        return vw_fail(VW_ERROR_USAGE,
                       "--to %s: takes a file of names (.txt) or, of a PhotoTourism scene, a NeRF-W TSV (.tsv); for "
                       "other trainers --copy DIR makes a scene",
                       list->to);
    if (!list->scene_path || !vw_phototourism_probe(list->scene_path))
        return vw_fail(VW_ERROR_USAGE, "--to %s: only a PhotoTourism scene has a TSV; name a .txt file", list->to);
    return write_tsv(list);
}

struct reading {
    const struct vw_scene *scene;
    const char *path;
    bool *chosen;          // per view
    uint32_t *passed_over; // photos that are not train photos
    double least;          // the lowest score of a chosen photo
};

// Chooses a photo if it is a train photo.
static void add_photo(const struct reading *reading, const struct vw_view *view) {
    if (view->split == VW_SPLIT_TRAIN) reading->chosen[view - reading->scene->views] = true;
    else ++*reading->passed_over;
}

// ---- Names, one a line ----

static enum vw_status add_name(void *context, int line, const char *name) {
    const struct reading *reading = context;
    const struct vw_view *view = vw_scene_find_named(reading->scene, name);
    if (!view) return vw_scene_refuse_name(reading->path, (uint32_t)line, name);
    if (view->split != VW_SPLIT_TRAIN)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: %s is not a train photo, its split is %s; remove the line",
                       reading->path, line, name, vw_split_name(view->split));
    add_photo(reading, view);
    return VW_OK;
}

static enum vw_status read_names(struct reading *reading) {
    uint32_t count;
    return vw_names_read(reading->path, add_name, reading, &count);
}

// ---- A NeRF-W TSV ----

static enum vw_status read_tsv(const struct reading *reading) {
    struct vw_tsv tsv = {0};
    enum vw_status status = vw_tsv_read(NULL, reading->path, &tsv);
    for (size_t i = 0; !status && i < tsv.row_count; i++) {
        if (tsv.rows[i].test || !tsv.rows[i].has_id) continue;
        const struct vw_view *view = vw_scene_find_named(reading->scene, tsv.rows[i].name);
        if (view) add_photo(reading, view);
        else ++*reading->passed_over;
    }
    vw_tsv_clear(&tsv);
    return status;
}

// ---- A transforms file ----

static const struct vw_view *find_framed(const struct vw_scene *scene, const char *file_path) {
    const struct vw_view *view = NULL;
    for (const char *name = file_path; name && !view; name = strchr(name, '/') ? strchr(name, '/') + 1 : NULL)
        view = vw_scene_find_named(scene, name);
    return view;
}

static enum vw_status add_frame(const struct reading *reading, size_t place, const json_t *frame) {
    const char *name = json_string_value(json_object_get(frame, "file_path"));
    if (!name)
        return vw_fail(VW_ERROR_INPUT, "%s: frame %zu: field file_path is missing or not a text", reading->path, place);
    const struct vw_view *view = find_framed(reading->scene, name);
    if (!view)
        return vw_fail(VW_ERROR_INPUT, "%s: frame %zu (%s) is not in the scene; give a file that was written for it",
                       reading->path, place, vw_text_is_clean(name) ? name : "its name has control characters");
    add_photo(reading, view);
    return VW_OK;
}

static enum vw_status read_transforms(const struct reading *reading) {
    json_t *file = NULL;
    enum vw_status status = vw_transforms_parse(NULL, reading->path, &file);
    if (status) return status;
    const json_t *frames = json_object_get(file, "frames");
    if (!json_is_array(frames))
        status = vw_fail(VW_ERROR_INPUT, "%s: field frames is missing; give a transforms file", reading->path);
    for (size_t i = 0; !status && i < json_array_size(frames); i++)
        status = add_frame(reading, i, json_array_get(frames, i));
    json_decref(file);
    return status;
}

// ---- Scores ----

static enum vw_status add_score(void *context, const struct vw_csv *csv, struct vw_view *view) {
    const struct reading *reading = context;
    char *end = NULL;
    double score = strtod(csv->fields[1], &end);
    if (end == csv->fields[1] || *end || !isfinite(score))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: field score: \"%s\" is not a number; correct it", csv->path, csv->line,
                       csv->fields[1]);
    if (score >= reading->least) add_photo(reading, view);
    else ++*reading->passed_over;
    return VW_OK;
}

enum vw_status vw_train_list_read(const struct vw_scene *scene, const char *path, const double *least, bool *chosen,
                                  uint32_t *passed_over) {
    struct reading reading = {scene, path, chosen, passed_over, least ? *least : 0};
    const char *extension = strrchr(path, '.');
    bool any = false;
    *passed_over = 0;
    enum vw_status status;
    if (least) status = vw_scene_table_read(scene, path, "score", add_score, &reading);
    else if (vw_tsv_has_header(NULL, path)) status = read_tsv(&reading);
    else if (extension && !strcasecmp(extension, ".json")) status = read_transforms(&reading);
    else status = read_names(&reading);
    for (uint32_t v = 0; v < scene->view_count; v++) any |= chosen[v];
    if (status || any) return status;
    if (least)
        return vw_fail(VW_ERROR_INPUT, "%s: no train photo has a score of %g or more; use a lower threshold", path,
                       *least);
    return vw_fail(VW_ERROR_INPUT, "%s: names no train photo; give another list", path);
}

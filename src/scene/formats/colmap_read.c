// Finds a COLMAP model and reads its three files.
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"

static const char *const folders[] = {"sparse/0", "sparse", "dense/sparse/0", "dense/sparse"};
static const char *const files[COLMAP_FILES] = {"cameras", "images", "points3D"};
static const struct colmap_file_reader *const readers[] = {&colmap_binary_reader,
                                                           &colmap_text_reader}; // in the order in which they are tried

static bool has_file(const char *folder, const char *name, const char *extension) {
    char *path = vw_format_text("%s/%s.%s", folder, name, extension);
    bool exists = path && vw_file_exists(path);
    free(path);
    return exists;
}

static bool has_all_files(const char *folder, const char *extension) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(files); i++)
        if (!has_file(folder, files[i], extension)) return false;
    return true;
}

static bool looks_like_model(const char *folder) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(readers); i++)
        if (has_file(folder, files[0], readers[i]->extension)) return true;
    return false;
}

char *vw_colmap_find(const char *scene_folder) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(folders); i++) {
        char *folder = vw_path_join(scene_folder, folders[i]);
        if (!folder || looks_like_model(folder)) return folder;
        free(folder);
    }
    return NULL;
}

static enum vw_status read_file(const char *model_folder, const struct colmap_file_reader *reader,
                                enum colmap_file file, struct colmap_builder *builder) {
    char *path = vw_format_text("%s/%s.%s", model_folder, files[file], reader->extension);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = reader->read(path, file, builder);
    free(path);
    return status;
}

enum vw_status vw_colmap_read(const char *model_folder, const char *scene_folder, struct vw_colmap_model *model) {
    const struct colmap_file_reader *reader = NULL;
    for (size_t i = 0; !reader && i < VW_ARRAY_COUNT(readers); i++)
        if (has_all_files(model_folder, readers[i]->extension)) reader = readers[i];
    if (!reader)
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: the COLMAP model is not complete; put cameras, images and points3D there, all .bin or all .txt",
            model_folder);
    struct vw_colmap_model read = {0};
    struct colmap_builder builder = {.model = &read, .scene_folder = scene_folder};
    enum vw_status status = VW_OK;
    for (enum colmap_file file = 0; !status && file < COLMAP_FILES; file++)
        status = read_file(model_folder, reader, file, &builder);
    colmap_builder_clear(&builder);
    if (status) vw_colmap_clear(&read);
    else *model = read;
    return status;
}

void vw_colmap_clear(struct vw_colmap_model *model) {
    for (size_t i = 0; i < model->image_count; i++) free(model->images[i].name);
    vw_name_index_clear(&model->names);
    free(model->cameras);
    free(model->images);
    free(model->features);
    free(model->points);
    free(model->tracks);
    *model = (struct vw_colmap_model){0};
}

ptrdiff_t vw_colmap_find_image(const struct vw_colmap_model *model, const char *name) {
    size_t place = 0;
    return vw_name_index_find(&model->names, name, &place) ? (ptrdiff_t)place : -1;
}

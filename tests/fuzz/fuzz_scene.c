// Scene files, and the files that name photos of a scene.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "fuzz/fuzz.h"
#include "image/feature_file.h"
#include "scene/builder.h"
#include "scene/formats/nerfw_tsv.h"
#include "scene/formats/photo_list.h"
#include "scene/splits_file.h"

void fuzz_transforms(const uint8_t *data, size_t size_bytes) {
    fuzz_open(fuzz_write("transforms.json", data, size_bytes), "transforms");
}

void fuzz_colmap_binary(const uint8_t *data, size_t size_bytes) {
    fuzz_write_model("sparse/0", "bin", data, size_bytes);
    fuzz_open(fuzz_folder(), "colmap");
}

void fuzz_colmap_text(const uint8_t *data, size_t size_bytes) {
    fuzz_write_model("sparse/0", "txt", data, size_bytes);
    fuzz_open(fuzz_folder(), "colmap");
}

void fuzz_recipe(const uint8_t *data, size_t size_bytes) {
    fuzz_open(fuzz_write("recipe.json", data, size_bytes), "recipe");
}

void fuzz_tsv(const uint8_t *data, size_t size_bytes) {
    const char *path = fuzz_write("split.tsv", data, size_bytes);
    struct vw_tsv tsv = {0};
    fuzz_forget_message();
    enum vw_status status = vw_tsv_read(NULL, path, &tsv);
    fuzz_check_message(status);
    bool has_header = vw_tsv_has_header(NULL, path);
    // A file that can be read is one that is found, as long as its header fits into what is looked at.
    if (!status && memchr(data, '\n', size_bytes < 512 ? size_bytes : 512) && !has_header) abort();
    for (size_t i = 0; i < tsv.row_count; i++)
        if (!*tsv.rows[i].name || strpbrk(tsv.rows[i].name, "\t\r\n") || tsv.rows[i].name[0] == '/') abort();
    vw_tsv_clear(&tsv);
}

void fuzz_features(const uint8_t *data, size_t size_bytes) {
    struct vw_feature_file file;
    fuzz_forget_message();
    enum vw_status status = vw_feature_file_read("features.npy", data, size_bytes, &file);
    fuzz_check_message(status);
    if (status) return;
    size_t count = (size_t)file.width * file.height * file.channels;
    fuzz_check(count > 0, "sizes are sound");
    for (size_t i = 0; i < count; i++)
        fuzz_check(fabsf(vw_feature_file_number(&file, i)) <= 1e30f, "every number is finite");
}

// Clears the providers of the scene, which all inputs share.
static void forget_providers(struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        free(scene->views[v].provider);
        scene->views[v].provider = vw_copy_text("");
        fuzz_check(scene->views[v].provider, "there is memory");
    }
}

void fuzz_providers(const uint8_t *data, size_t size_bytes) {
    struct vw_scene *scene = fuzz_scene();
    const char *path = fuzz_write("providers.csv", data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_providers_read(path, scene);
    fuzz_check_message(status);
    for (uint32_t v = 0; v < scene->view_count; v++)
        fuzz_check(vw_text_is_clean(scene->views[v].provider), "a provider is clean text");
    forget_providers(scene);
}

enum { VIEWS_MAX = 8 };

static void try_splits(struct vw_scene *scene, const char *path) {
    uint8_t claims[VIEWS_MAX] = {0};
    uint32_t absent = 0, claimed = 0;
    fuzz_forget_message();
    enum vw_status status = vw_splits_file_read(scene, path, claims, &absent);
    fuzz_check_message(status);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        claimed += claims[v] > 0;
        fuzz_check(claims[v] <= 1 + VW_SPLIT_EXCLUDED, "splits are those that there are");
    }
    fuzz_check(status || claimed, "splits that are taken name a photo");
}

// Tries a list of photos; the first byte says what kind of file the rest is.
void fuzz_lists(const uint8_t *data, size_t size_bytes) {
    static const double least = 0.5;
    struct vw_scene *scene = fuzz_scene();
    bool chosen[VIEWS_MAX] = {0}, any = false;
    uint32_t passed_over = 0;
    char kind = size_bytes ? (char)data[0] : 0;
    const char *name = kind == 'j' ? "list.json" : "list.txt";
    const char *path = fuzz_write(name, data + (size_bytes > 0), size_bytes - (size_bytes > 0));
    if (kind == 'p') {
        try_splits(scene, path);
        return;
    }
    fuzz_forget_message();
    enum vw_status status = vw_train_list_read(scene, path, kind == 's' ? &least : NULL, chosen, &passed_over);
    fuzz_check_message(status);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        any |= chosen[v];
        fuzz_check(!chosen[v] || scene->views[v].split == VW_SPLIT_TRAIN, "only train photos are chosen");
    }
    fuzz_check(status || any, "a list that is taken chooses a photo");
}

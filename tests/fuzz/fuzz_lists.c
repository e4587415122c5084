#include "fuzz/fuzz.h"

#include "scene/formats/train_list.h"
#include "scene/splits_file.h"

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

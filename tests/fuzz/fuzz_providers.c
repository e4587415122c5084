#include "fuzz/fuzz.h"

#include <stdlib.h>

#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"

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

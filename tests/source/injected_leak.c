// injected_leak gpu|validation|photo [leak]: opens and closes a device, opens and closes one under the validation
// layer, or loads OpenImageIO. With `leak` it leaks 4242 bytes before that and 4243 bytes after it.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/image.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"

static void leak(size_t bytes) {
    void *volatile lost = malloc(bytes);
    lost = NULL;
    (void)lost;
}

static enum vw_status use_gpu(bool validation) {
    struct vw_gpu *gpu = NULL;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.validation = validation}, &gpu);
    enum vw_status closed = vw_gpu_close(&gpu);
    return status ? status : closed;
}

// Saves a photo in a folder that is missing, as OpenImageIO notices.
static enum vw_status use_photo(void) {
    const float pixels[12] = {0};
    return vw_image_save("no/such/folder/photo.png", 2, 2, 3, pixels) == VW_ERROR_IO ? VW_OK : VW_ERROR_IO;
}

int main(int argument_count, char **arguments) {
    if (argument_count < 2) return 2;
    bool leaks = argument_count > 2;
    if (leaks) leak(4242);
    enum vw_status status = !strcmp(arguments[1], "photo") ? use_photo() : use_gpu(!strcmp(arguments[1], "validation"));
    if (leaks) leak(4243);
    if (status) fprintf(stderr, "%s\n", vw_error_message());
    return status ? 2 : 0;
}

#include "scene/features.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "image/feature_file.h"
#include "image/image.h"
#include "scene/builder.h"
#include "scene/photo_source.h"
#include "viewworth/log.h"

static const size_t FILE_BYTES_MOST = (size_t)1 << 30;

// The map of a view, as it is interpolated; without numbers where the view has none.
struct map {
    uint32_t width, height;
    float *numbers; // owned; [row][column][channel]
};

struct vw_features {
    uint32_t view_count;
    uint32_t channels, file_channels; // 0: there are no maps; kept, and in the files
    uint32_t *signs;                  // owned; of each channel, if there are too many: bit k is its sign in number k
    struct map *maps;                 // owned; of each view
};

// ---- Files ----------------------------------------------------------------------------------------------------------

enum vw_status vw_features_find(struct vw_scene_builder *builder) {
    static const char *const endings[] = {".npy", ".exr"}; // the latter is refused when it is read, not overlooked
    enum vw_status status = VW_OK;
    uint32_t found = 0;
    for (uint32_t v = 0; v < builder->scene->view_count && !status; v++) {
        struct vw_scene_builder_photo *photo = &builder->photos[v];
        if (builder->scene->views[v].split == VW_SPLIT_EXCLUDED) continue;
        for (int i = 0; i < 2 && !status && !photo->features_path; i++)
            status = vw_scene_find_beside(builder->folder, photo->image_path, "features", endings[i], false,
                                          &photo->features_path);
        if (status || !photo->features_path) continue;
        if (!builder->params->headers_only)
            status = vw_scene_file_hash(builder->folder, photo->features_path, photo->features_sha256);
        found++;
    }
    if (status || !found) return status;
    return vw_scene_note(builder->scene, "%u photo%s with a file in features/, which the effect uncertainty reads",
                         found, vw_plural(found));
}

static enum vw_status draw_signs(struct vw_features *features) {
    features->signs = vw_allocate(features->file_channels, sizeof *features->signs);
    for (uint32_t channel = 0; channel < features->file_channels && features->signs; channel++) {
        uint32_t words[4];
        vw_random_words(0, VW_RANDOM_PROJECTION, 0, channel, 0, words);
        features->signs[channel] = words[0];
    }
    return features->signs ? VW_OK : VW_ERROR_MEMORY;
}

// Projects a cell of many channels to VW_FEATURES numbers: sums with random signs.
static void project(const struct vw_feature_file *file, const uint32_t *signs, size_t cell,
                    float numbers[VW_FEATURES]) {
    double sums[VW_FEATURES] = {0.0};
    for (uint32_t channel = 0; channel < file->channels; channel++) {
        double number = vw_feature_file_number(file, cell * file->channels + channel);
        for (uint32_t i = 0; i < VW_FEATURES; i++) sums[i] += signs[channel] >> i & 1 ? number : -number;
    }
    for (uint32_t i = 0; i < VW_FEATURES; i++) numbers[i] = (float)sums[i];
}

static enum vw_status take_map(const struct vw_feature_file *file, struct vw_features *features, struct map *map) {
    size_t cells = (size_t)file->width * file->height;
    features->file_channels = file->channels;
    features->channels = file->channels < VW_FEATURES ? file->channels : VW_FEATURES;
    if (file->channels > VW_FEATURES && !features->signs && draw_signs(features)) return VW_ERROR_MEMORY;
    map->width = file->width;
    map->height = file->height;
    map->numbers = vw_allocate(cells * features->channels, sizeof *map->numbers);
    if (!map->numbers) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < cells; i++) {
        float *numbers = map->numbers + i * features->channels;
        if (file->channels > VW_FEATURES) project(file, features->signs, i, numbers);
        for (uint32_t c = 0; c < file->channels && file->channels <= VW_FEATURES; c++)
            numbers[c] = vw_feature_file_number(file, i * file->channels + c);
    }
    return VW_OK;
}

static enum vw_status read_map(const struct vw_photo_source *source, uint32_t view, struct vw_features *features) {
    const struct vw_scene_builder_photo *photo = &source->photos[view];
    struct vw_feature_file file;
    uint8_t sha256[VW_HASH_BYTES];
    void *data = NULL;
    size_t size_bytes = 0;
    if (!photo->features_path)
        return vw_fail(VW_ERROR_INPUT, "%s: has no file in features/, but other photos do; add it, or remove theirs",
                       photo->image_path);
    enum vw_status status =
        vw_scene_file_read(source->folder, photo->features_path, FILE_BYTES_MOST, &data, &size_bytes);
    if (!status) vw_sha256(data, size_bytes, sha256);
    if (!status && memcmp(sha256, photo->features_sha256, sizeof sha256) != 0)
        status = vw_fail(VW_ERROR_IO, "%s: changed since the scene was opened; restore it, or run the command again",
                         photo->features_path);
    if (!status) status = vw_feature_file_read(photo->features_path, data, size_bytes, &file);
    if (!status && features->file_channels && features->file_channels != file.channels)
        status = vw_fail(VW_ERROR_INPUT, "%s: has %u numbers a cell, but other files %u; make all of them alike",
                         photo->features_path, file.channels, features->file_channels);
    if (!status) status = take_map(&file, features, &features->maps[view]);
    free(data);
    return status;
}

// Shifts and scales a channel to a mean of 0 and a deviation of 1; one that is the same everywhere becomes 0.
static void standardise(struct vw_features *features, uint32_t channel) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (int pass = 0; pass < 3; pass++) {
        double mean = count > 0.0 ? sum / count : 0.0, deviation = count > 0.0 ? sqrt(squares / count) : 0.0;
        for (uint32_t v = 0; v < features->view_count; v++) {
            const struct map *map = &features->maps[v];
            for (size_t i = 0; map->numbers && i < (size_t)map->width * map->height; i++) {
                float *number = &map->numbers[i * features->channels + channel];
                double off = *number - mean;
                if (pass == 0) sum += *number, count++;
                else if (pass == 1) squares += off * off;
                else *number = deviation > 1e-6 * fabs(mean) ? (float)(off / deviation) : 0.0f;
            }
        }
    }
}

static enum vw_status create(const struct vw_scene *scene, struct vw_features **out) {
    struct vw_features *features = vw_allocate(1, sizeof *features);
    uint32_t with_maps = 0;
    if (!features) return VW_ERROR_MEMORY;
    *features = (struct vw_features){.view_count = scene->view_count,
                                     .maps = vw_allocate(scene->view_count, sizeof *features->maps)};
    enum vw_status status = features->maps ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        with_maps += scene->views[v].split == VW_SPLIT_TRAIN && scene->source->photos[v].features_path;
    for (uint32_t v = 0; v < scene->view_count && with_maps && !status; v++)
        if (scene->views[v].split == VW_SPLIT_TRAIN) status = read_map(scene->source, v, features);
    for (uint32_t channel = 0; channel < features->channels && !status; channel++) standardise(features, channel);
    if (!status && with_maps)
        vw_log_info("uncertainty: by maps of %" PRIu32 " photo%s", with_maps, vw_plural(with_maps));
    else if (!status) vw_log_info("uncertainty: by the photos, which have no maps in features/");
    if (status) vw_features_close(&features);
    else *out = features;
    return status;
}

enum vw_status vw_features_open(const struct vw_scene *scene) {
    enum vw_status status = VW_OK;
    if (!scene->source) return VW_OK;
    (void)pthread_mutex_lock(&scene->source->lock);
    if (!scene->source->features) status = create(scene, &scene->source->features);
    (void)pthread_mutex_unlock(&scene->source->lock);
    return status;
}

void vw_features_close(struct vw_features **pointer) {
    struct vw_features *features = *pointer;
    if (!features) return;
    for (uint32_t v = 0; features->maps && v < features->view_count; v++) free(features->maps[v].numbers);
    free(features->maps);
    free(features->signs);
    free(features);
    *pointer = NULL;
}

// ---- Of pixels ------------------------------------------------------------------------------------------------------

static float clamped(float value, uint32_t count) { return fminf(fmaxf(value, 0.0f), (float)(count - 1)); }

static void interpolate(const struct map *map, uint32_t channels, float x, float y, float *numbers) {
    float from_left = clamped(x * (float)map->width - 0.5f, map->width),
          from_top = clamped(y * (float)map->height - 0.5f, map->height);
    uint32_t left = (uint32_t)from_left, top = (uint32_t)from_top, right = left + (left + 1 < map->width),
             bottom = top + (top + 1 < map->height);
    float across = from_left - (float)left, down = from_top - (float)top;
    for (uint32_t c = 0; c < channels; c++) {
        const float *n = map->numbers + c;
        float above = n[((size_t)top * map->width + left) * channels] * (1.0f - across) +
                      n[((size_t)top * map->width + right) * channels] * across,
              below = n[((size_t)bottom * map->width + left) * channels] * (1.0f - across) +
                      n[((size_t)bottom * map->width + right) * channels] * across;
        numbers[c] = above * (1.0f - down) + below * down;
    }
}

// A pixel over the background: rgb, and its luminance.
struct seen {
    float rgb[3], luminance;
};

static struct seen look(const struct vw_scene *scene, const struct vw_image *image, int64_t x_px, int64_t y_px) {
    const int64_t right = image->width_px - 1, bottom = image->height_px - 1;
    struct seen seen;
    float rgba[4];
    x_px = x_px < 0 ? 0 : x_px > right ? right : x_px;
    y_px = y_px < 0 ? 0 : y_px > bottom ? bottom : y_px;
    vw_image_pixel(image, (uint32_t)x_px, (uint32_t)y_px, rgba);
    for (int c = 0; c < 3; c++) seen.rgb[c] = rgba[3] * rgba[c] + (1.0f - rgba[3]) * scene->background[c];
    seen.luminance = (float)vw_luminance_of(seen.rgb);
    return seen;
}

// Looks at 3 x 3 pixels, `apart_px` from each other. Writes their mean colour, and the deviation of their luminance.
static void look_around(const struct vw_scene *scene, const struct vw_image *image, int64_t x_px, int64_t y_px,
                        int64_t apart_px, struct seen seen[9], float numbers[4]) {
    float sums[3] = {0.0f}, luminance = 0.0f, squares = 0.0f;
    for (int i = 0; i < 9; i++) {
        seen[i] = look(scene, image, x_px + (i % 3 - 1) * apart_px, y_px + (i / 3 - 1) * apart_px);
        for (int c = 0; c < 3; c++) sums[c] += seen[i].rgb[c];
        luminance += seen[i].luminance;
        squares += seen[i].luminance * seen[i].luminance;
    }
    for (int c = 0; c < 3; c++) numbers[c] = 4.0f * sums[c] / 9.0f - 2.0f;
    numbers[3] = 10.0f * sqrtf(fmaxf(squares / 9.0f - luminance * luminance / 81.0f, 0.0f));
}

// Factors bring photos' usual values to about unit size.
static void look_at_photo(const struct vw_scene *scene, const struct vw_image *image, int64_t x_px, int64_t y_px,
                          float numbers[VW_FEATURES]) {
    struct seen near[9], far[9];
    look_around(scene, image, x_px, y_px, 1, near, numbers + 4);
    look_around(scene, image, x_px, y_px, image->width_px < 40 ? 2 : (image->width_px + 10) / 20, far, numbers + 8);
    for (int c = 0; c < 3; c++) numbers[c] = 4.0f * near[4].rgb[c] - 2.0f;
    numbers[3] = 5.0f * hypotf(near[5].luminance - near[3].luminance, near[7].luminance - near[1].luminance);
}

void vw_features_at(const struct vw_scene *scene, uint32_t view, float x_px, float y_px, float numbers[VW_FEATURES]) {
    const struct vw_image *image = &scene->views[view].image;
    const struct vw_features *features = scene->source ? scene->source->features : NULL;
    memset(numbers, 0, VW_FEATURES * sizeof *numbers);
    if (!features || !features->channels)
        look_at_photo(scene, image, (int64_t)clamped(x_px, image->width_px), (int64_t)clamped(y_px, image->height_px),
                      numbers);
    else
        interpolate(&features->maps[view], features->channels, x_px / (float)image->width_px,
                    y_px / (float)image->height_px, numbers);
}

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "check/table.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "detect/effects_text.h"

// A camera and how many views share it.
struct shared_camera {
    struct vw_camera camera;
    const char *lens; // static
    uint32_t view_count;
};

struct description {
    const struct vw_scene_info *info;
    const struct vw_scene *scene;
    struct shared_camera *cameras; // owned; the distinct ones, in order of first use
    uint32_t camera_count;
    uint32_t ranged_count;               // views with near and far
    double near_world, far_world;        // over all of them
    const struct vw_exposure *exposures; // the scene's
};

static const char *lens_name(const struct vw_camera *camera) {
    if (!vw_camera_is_distorted(camera)) return "pinhole";
    return camera->lens == VW_LENS_FISHEYE ? "fisheye" : "polynomial distortion";
}

// Finds the smallest near and largest far over the views that have them.
static void measure_range(struct description *description) {
    for (uint32_t v = 0; v < description->scene->view_count; v++) {
        const struct vw_view *view = &description->scene->views[v];
        if (view->far_world <= 0) continue;
        bool first = !description->ranged_count++;
        if (first || view->near_world < description->near_world) description->near_world = view->near_world;
        if (first || view->far_world > description->far_world) description->far_world = view->far_world;
    }
}

static void count_cameras(struct description *description) {
    for (uint32_t v = 0; v < description->scene->view_count; v++) {
        const struct vw_camera *camera = &description->scene->views[v].camera;
        uint32_t i = 0;
        while (i < description->camera_count && !vw_camera_same(&description->cameras[i].camera, camera)) i++;
        if (i == description->camera_count)
            description->cameras[description->camera_count++] = (struct shared_camera){*camera, lens_name(camera), 0};
        description->cameras[i].view_count++;
    }
}

static enum vw_status describe(const struct vw_scene_info *info, struct description *description) {
    *description = (struct description){.info = info, .scene = info->scene};
    description->cameras = vw_allocate(info->scene->view_count, sizeof *description->cameras);
    if (!description->cameras) return VW_ERROR_MEMORY;
    enum vw_status status = vw_scene_estimate_exposures(info->scene, &description->exposures);
    if (status) return status;
    count_cameras(description);
    measure_range(description);
    return VW_OK;
}

// ---- For people ----------------------------------------------------------------------------------------------------

static void print_cameras(const struct description *description) {
    enum { SHOWN = 8 };
    vw_print("cameras  %u distinct\n", description->camera_count);
    for (uint32_t i = 0; i < description->camera_count && i < SHOWN; i++) {
        const struct vw_camera *camera = &description->cameras[i].camera;
        vw_print("         %ux%u px, focal %.2f %.2f px, centre %.2f %.2f px, %s: %u photo%s\n", camera->width_px,
                 camera->height_px, camera->focal_x_px, camera->focal_y_px, camera->centre_x_px, camera->centre_y_px,
                 description->cameras[i].lens, description->cameras[i].view_count,
                 vw_plural(description->cameras[i].view_count));
    }
    if (description->camera_count > SHOWN)
        vw_print("         and %u more (--json has all)\n", description->camera_count - SHOWN);
}

static void print_points(const struct description *description) {
    const struct vw_scene *scene = description->scene;
    if (scene->point_count) vw_print("points   %u, seen %u times\n", scene->point_count, scene->track_count);
    if (description->ranged_count)
        vw_print("depths   %.2f to %.2f world units, from the points that %u photo%s see\n", description->near_world,
                 description->far_world, description->ranged_count, vw_plural(description->ranged_count));
}

// Prints how photos differ in exposure, with the darkest and the brightest.
static void print_exposures(const struct description *description) {
    const struct vw_scene *scene = description->scene;
    uint32_t count = 0, darkest = 0, brightest = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!isfinite(description->exposures[v].error_with)) continue;
        double brightness = vw_exposure_brightness(&description->exposures[v]);
        if (!count || brightness < vw_exposure_brightness(&description->exposures[darkest])) darkest = v;
        if (!count || brightness > vw_exposure_brightness(&description->exposures[brightest])) brightest = v;
        count++;
    }
    if (count)
        vw_print("exposure photos are %.2f (%s) to %.2f (%s) times as bright as the median photo, by the points that "
                 "%u of %u share\n",
                 vw_exposure_brightness(&description->exposures[darkest]), scene->views[darkest].name,
                 vw_exposure_brightness(&description->exposures[brightest]), scene->views[brightest].name, count,
                 scene->split_count[VW_SPLIT_TRAIN]);
}

static void print_line(const char *line) { vw_print("%s\n", line); }

static void print_estimate(const struct vw_estimate *estimate) {
    vw_print("memory   %.1f MiB on the host for photos, masks and points\n", (double)estimate->host_bytes / 0x1p20);
    if (*estimate->missing) {
        vw_print("estimate unknown: %s\n", estimate->missing);
        return;
    }
    vw_print("         %.1f MiB on the device for %" PRIu64 " params\n", (double)estimate->device_bytes / 0x1p20,
             estimate->param_count);
}

// Prints the line of effects and the table of those that anything was measured of.
static void print_effects(const struct vw_scene_info *info) {
    char line[VW_EFFECT_LINE_BYTES];
    vw_effects_to_line(info->effects, info->effect_count, line);
    vw_print("effects  %s\n\n%s\n", line, vw_effects_heading);
    for (uint32_t i = 0; i < info->effect_count; i++) {
        if (!info->effects[i].on && isnan(info->effects[i].evidence)) continue;
        vw_effect_to_line(&info->effects[i], line);
        vw_print("%s\n", line);
    }
    vw_print("unknown, and off:");
    for (uint32_t i = 0; i < info->effect_count; i++)
        if (!info->effects[i].on && isnan(info->effects[i].evidence)) vw_print(" %s", info->effects[i].name);
    vw_print("\n");
}

// A command with what it takes at each accuracy level, in text and in seconds.
struct price {
    const struct vw_priced_command *command;
    char times[VW_PRICED_LEVELS][VW_DURATION_BYTES];
};

// Prints what the commands take on this device at every accuracy level.
static void print_prices(const struct vw_scene_info *info) {
    struct vw_column columns[2 + VW_PRICED_LEVELS] = {
        {VW_CELL_VIA("command", struct price, command, TEXT, struct vw_priced_command, words),
         .title = "about, with --accuracy"},
        {VW_CELL_VIA("trainings", struct price, command, COUNT, struct vw_priced_command, trainings),
         .title = "trainings"}};
    struct price prices[VW_PRICED_COMMANDS];
    for (uint32_t l = 0; l < VW_PRICED_LEVELS; l++)
        columns[2 + l] = (struct vw_column){.kind = VW_COLUMN_CHARS,
                                            .offset = offsetof(struct price, times) + l * VW_DURATION_BYTES,
                                            .title = info->prices[l].level};
    for (uint32_t c = 0; c < VW_PRICED_COMMANDS; c++) {
        prices[c] = (struct price){.command = &vw_priced_commands[c]};
        for (uint32_t l = 0; l < VW_PRICED_LEVELS; l++)
            if (isnan(info->prices[l].seconds[c])) strcpy(prices[c].times[l], "-");
            else vw_text_duration(info->prices[l].seconds[c], prices[c].times[l]);
    }
    const struct vw_rows rows = VW_ROWS(columns, prices, VW_PRICED_COMMANDS);
    vw_print("\n");
    vw_print_rows(&rows);
}

static void print_text(const struct description *description) {
    const struct vw_scene *scene = description->scene;
    const struct vw_box *box = &scene->box;
    vw_print("scene    %s (%s)\nphotos   %u:", scene->path, scene->format, scene->view_count);
    for (int split = VW_SPLIT_TRAIN; split <= VW_SPLIT_EXCLUDED; split++)
        vw_print(" %u %s%s", scene->split_count[split], vw_split_name(split), split < VW_SPLIT_EXCLUDED ? "," : "");
    vw_print("\n");
    if (scene->has_alpha) vw_print("alpha    some photos have transparent pixels\n");
    if (scene->masked_view_count)
        vw_print("masks    %u photo%s; white keeps\n", scene->masked_view_count, vw_plural(scene->masked_view_count));
    print_cameras(description);
    vw_print("bounds   centre %.2f %.2f %.2f, half extent %.2f world units (%s)\n", box->centre_world[0],
             box->centre_world[1], box->centre_world[2], box->half_extent_world, scene->box_source);
    if (scene->track_count)
        vw_print("         %u of %u observations of points lie outside\n", vw_scene_count_outside(scene, box),
                 scene->track_count);
    print_points(description);
    print_exposures(description);
    vw_photo_findings_tell(description->info->scene, description->info->findings, print_line);
    for (uint32_t i = 0; i < scene->note_count; i++) vw_print("note     %s\n", scene->notes[i]);
    print_estimate(&description->info->estimate);
    if (!*description->info->estimate.missing) print_prices(description->info);
    print_effects(description->info);
}

// ---- As JSON: NULL when memory is short ----------------------------------------------------------------------------

#define OF_CAMERA(kind, member)                                                                                        \
    { VW_CELL(#member, struct shared_camera, kind, camera.member) }
static const struct vw_column camera_columns[] = {
    OF_CAMERA(COUNT, width_px),
    OF_CAMERA(COUNT, height_px),
    OF_CAMERA(REAL, focal_x_px),
    OF_CAMERA(REAL, focal_y_px),
    OF_CAMERA(REAL, centre_x_px),
    OF_CAMERA(REAL, centre_y_px),
    {VW_CELL("lens", struct shared_camera, TEXT, lens)},
    OF_CAMERA(REAL, k1),
    OF_CAMERA(REAL, k2),
    OF_CAMERA(REAL, k3),
    OF_CAMERA(REAL, k4),
    OF_CAMERA(REAL, k5),
    OF_CAMERA(REAL, k6),
    OF_CAMERA(REAL, p1),
    OF_CAMERA(REAL, p2),
    {VW_CELL("views", struct shared_camera, COUNT, view_count)},
};

static json_t *splits_to_json(const struct vw_scene *scene) {
    const uint32_t *count = scene->split_count;
    return json_pack("{s:I, s:I, s:I, s:I}", "train", (json_int_t)count[VW_SPLIT_TRAIN], "val",
                     (json_int_t)count[VW_SPLIT_VAL], "test", (json_int_t)count[VW_SPLIT_TEST], "excluded",
                     (json_int_t)count[VW_SPLIT_EXCLUDED]);
}

static json_t *bounds_to_json(const struct vw_scene *scene) {
    const struct vw_box *box = &scene->box;
    return json_pack("{s:[f,f,f], s:f, s:s, s:I}", "centre_world", box->centre_world[0], box->centre_world[1],
                     box->centre_world[2], "half_extent_world", box->half_extent_world, "source", scene->box_source,
                     "observations_outside", (json_int_t)vw_scene_count_outside(scene, box));
}

static json_t *notes_to_json(const struct vw_scene *scene) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < scene->note_count; i++) vw_json_append(&array, json_string(scene->notes[i]));
    return array;
}

static json_t *exposures_to_json(const struct description *description) {
    const struct vw_scene *scene = description->scene;
    json_t *array = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_exposure *e = &description->exposures[v];
        if (scene->views[v].split != VW_SPLIT_TRAIN) continue;
        vw_json_append(&array,
                       json_pack("{s:s, s:f, s:[f,f,f], s:[f,f,f], s:I, s:o, s:o}", "name", scene->views[v].name,
                                 "brightness", vw_exposure_brightness(e), "gain", 1.0 + e->gain[0], 1.0 + e->gain[1],
                                 1.0 + e->gain[2], "bias", e->bias[0], e->bias[1], e->bias[2], "observations",
                                 (json_int_t)e->observation_count, "mse_without", vw_json_real(e->error_without),
                                 "mse_with", vw_json_real(e->error_with)));
    }
    return array;
}

static json_t *findings_to_json(const struct vw_scene_info *info) {
    json_t *array = json_array();
    for (uint32_t v = 0; v < info->scene->view_count; v++)
        if (info->findings[v].word)
            vw_json_append(&array, json_pack("{s:s, s:s, s:o}", "name", info->scene->views[v].name, "defect",
                                             info->findings[v].word, "description",
                                             vw_json_string(info->findings[v].description)));
    return array;
}

// Returns null if no view sees points.
static json_t *depths_to_json(const struct description *description) {
    if (!description->ranged_count) return json_null();
    return json_pack("{s:f, s:f, s:I}", "near_world", description->near_world, "far_world", description->far_world,
                     "views", (json_int_t)description->ranged_count);
}

static json_t *estimate_to_json(const struct vw_estimate *estimate) {
    if (*estimate->missing)
        return json_pack("{s:I, s:s}", "host_bytes", (json_int_t)estimate->host_bytes, "missing", estimate->missing);
    return json_pack("{s:I, s:I, s:I, s:I, s:s}", "host_bytes", (json_int_t)estimate->host_bytes, "device_bytes",
                     (json_int_t)estimate->device_bytes, "params", (json_int_t)estimate->param_count, "steps",
                     (json_int_t)estimate->steps, "device", estimate->device);
}

// Returns null without an estimate.
static json_t *prices_to_json(const struct vw_scene_info *info) {
    json_t *levels = *info->estimate.missing ? json_null() : json_object();
    for (uint32_t l = 0; l < VW_PRICED_LEVELS && json_is_object(levels); l++) {
        json_t *commands = json_object();
        for (uint32_t c = 0; c < VW_PRICED_COMMANDS; c++)
            vw_json_set(&commands, vw_priced_commands[c].name,
                        json_pack("{s:s, s:I, s:o}", "command", vw_priced_commands[c].words, "trainings",
                                  (json_int_t)vw_priced_commands[c].trainings, "seconds",
                                  vw_json_real(info->prices[l].seconds[c])));
        vw_json_set(&levels, info->prices[l].level, commands);
    }
    return levels;
}

static json_t *to_json(const struct description *description) {
    const struct vw_scene *scene = description->scene;
    const struct vw_rows cameras = VW_ROWS(camera_columns, description->cameras, description->camera_count);
    return json_pack("{s:s, s:s, s:I, s:o, s:o, s:o, s:b, s:I, s:I, s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "scene",
                     scene->path, "format", scene->format, "views", (json_int_t)scene->view_count, "splits",
                     splits_to_json(scene), "cameras", vw_rows_to_json(&cameras), "bounds", bounds_to_json(scene),
                     "has_alpha", scene->has_alpha, "masks", (json_int_t)scene->masked_view_count, "points",
                     (json_int_t)scene->point_count, "tracks", (json_int_t)scene->track_count, "depths",
                     depths_to_json(description), "exposures", exposures_to_json(description), "notes",
                     notes_to_json(scene), "defects", findings_to_json(description->info), "estimate",
                     estimate_to_json(&description->info->estimate), "prices", prices_to_json(description->info),
                     "effects", vw_effects_to_json(description->info->effects, description->info->effect_count));
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_scene_info_print(const struct vw_scene_info *info, bool json) {
    struct description description;
    enum vw_status status = describe(info, &description);
    if (!status && json) status = vw_json_print(to_json(&description));
    else if (!status) print_text(&description);
    free(description.cameras);
    return status;
}

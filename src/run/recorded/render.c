#include "run/recorded/render.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "run/out_folder.h"
#include "run/recorded/recorded_run.h"
#include "scene/camera_path.h"
#include "train/trainer.h"
#include "viewworth/log.h"

// The beginning of every render: a run and its field, opened, and the view that is named.
struct vw_rendering {
    struct vw_recorded_run run;
    struct vw_trainer *trainer;
    uint32_t view;
};

// Refuses an image that is neither .png nor .exr. NULL is fine.
static enum vw_status check_image(const char *to) {
    if (!to || vw_path_ends_with(to, ".png") || vw_path_ends_with(to, ".exr")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--to %s: the name must end in .png or .exr", to);
}

// ---- Choosing the view ---------------------------------------------------------------------------------------------

static bool find_by_name(const struct vw_scene *scene, const char *name, uint32_t *view) {
    for (*view = 0; *view < scene->view_count; ++*view)
        if (strcmp(scene->views[*view].name, name) == 0) return true;
    return false;
}

// Returns whether a view has this name without its folder, its extension or both.
static bool has_short_name(const struct vw_view *view, const char *wanted) {
    const char *name = view->name;
    size_t length = strlen(name), wanted_length = strlen(wanted);
    const char *slash = strrchr(name, '/'), *point = strrchr(slash ? slash : name, '.');
    size_t ends[] = {length, point ? (size_t)(point - name) : length};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ends); i++) {
        if (!wanted_length || ends[i] < wanted_length) continue;
        const char *begin = name + ends[i] - wanted_length;
        if ((begin == name || begin[-1] == '/') && !strncmp(begin, wanted, wanted_length)) return true;
    }
    return false;
}

// Finds the only view with this short name. VW_ERROR_USAGE lists the first three if there are more; without one, `view`
// stays.
static enum vw_status find_by_short_name(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    uint32_t places[3] = {0}, count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (has_short_name(&scene->views[v], wanted) && count++ < VW_ARRAY_COUNT(places)) places[count - 1] = v;
    if (count == 1) *view = places[0];
    if (count < 2) return VW_OK;
    bool third = count >= VW_ARRAY_COUNT(places);
    return vw_fail(VW_ERROR_USAGE, "--view %s: is short for %u photos: %s, %s%s%s%s; write the name out", wanted, count,
                   scene->views[places[0]].name, scene->views[places[1]].name, third ? ", " : "",
                   third ? scene->views[places[2]].name : "", count > VW_ARRAY_COUNT(places) ? ", ..." : "");
}

static bool find_by_place(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    char *end;
    unsigned long long place = strtoull(wanted, &end, 10);
    if (!isdigit((unsigned char)wanted[0]) || *end) return false;
    for (*view = 0; *view < scene->view_count; ++*view)
        if (scene->views[*view].split == VW_SPLIT_VAL && place-- == 0) return true;
    return false;
}

static enum vw_status choose_view(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    uint32_t named = UINT32_MAX, placed = 0;
    if (find_by_name(scene, wanted, view)) return VW_OK;
    bool is_place = find_by_place(scene, wanted, &placed);
    bool padded = wanted[0] == '0' && wanted[1]; // "0094" is a name before it is a place
    enum vw_status status = is_place && !padded ? VW_OK : find_by_short_name(scene, wanted, &named);
    if (!status && !is_place && named == UINT32_MAX)
        status = vw_fail(VW_ERROR_USAGE,
                         "--view %s: no photo of this name, nor a place among the %u validation photos (from 0)",
                         wanted, scene->split_count[VW_SPLIT_VAL]);
    *view = named == UINT32_MAX ? placed : named;
    return status;
}

// ---- Opening -------------------------------------------------------------------------------------------------------

// Locks OUT if `to` lies in it, or is NULL. `*lock` is NULL otherwise.
static enum vw_status take_lock(const char *out, const char *to, struct vw_out_lock **lock) {
    if (to) return vw_out_lock_take_for(to, &out, 1, lock);
    return vw_folder_exists(out) ? vw_out_lock_take(out, lock) : VW_OK; // opening says what is missing
}

// Opens the run. The caller closes it, also after a failure.
static enum vw_status open_rendering(const struct vw_render_params *params, struct vw_rendering *rendering) {
    *rendering = (struct vw_rendering){0};
    enum vw_status status = vw_recorded_open(params->out, &rendering->run);
    if (!status) status = vw_recorded_open_scene(&rendering->run, params->device);
    if (!status) status = choose_view(rendering->run.scene, params->view ? params->view : "0", &rendering->view);
    return status ? status : vw_recorded_load_field(&rendering->run, &rendering->trainer);
}

static void close_rendering(struct vw_rendering *rendering) {
    vw_trainer_destroy(&rendering->trainer);
    vw_recorded_close(&rendering->run);
}

// ---- Depths --------------------------------------------------------------------------------------------------------

// Returns NAME_depth.exr of NAME.png or NAME.exr, owned by the caller.
static char *name_depth(const char *image) {
    const char *point = strrchr(image, '.');
    return vw_format_text("%.*s_depth.exr", (int)(point - image), image);
}

// Writes the expected depth along the axis of a camera in units of the scene, 0 where nothing is seen; one channel of
// floats.
static enum vw_status write_depth(const struct vw_rendering *rendering, const struct vw_view *posed,
                                  const char *image) {
    struct vw_image_encoding encoding = {
        .width_px = posed->camera.width_px, .height_px = posed->camera.height_px, .channels = 1};
    float *depth = NULL;
    void *file = NULL;
    size_t file_bytes = 0;
    char *name = name_depth(image);
    enum vw_status status = name ? VW_OK : VW_ERROR_MEMORY;
    if (!status && !vw_photo_format_of_name(name, &encoding.format))
        status = vw_fail(VW_ERROR_IO, "EXR is not a format that is written");
    if (!status) status = vw_trainer_render_posed(rendering->trainer, rendering->view, posed, true, &depth);
    if (!status) status = vw_image_encode(&encoding, depth, &file, &file_bytes);
    if (!status) status = vw_file_write(name, file, file_bytes);
    free(depth);
    free(file);
    free(name);
    return status;
}

// ---- A view beside its photo ---------------------------------------------------------------------------------------

struct comparing {
    const struct vw_scene *scene;
    bool on_background; // transparent pixels show the background
    bool masked;        // mask files are obeyed
};

// Returns --to, or OUT/render_<view>.png without the view's folder and extension, unless another view has that name
// too: then with '_' for its slashes. Owned by the caller.
static char *name_target(const struct vw_render_params *params, const struct vw_scene *scene, uint32_t view) {
    if (params->to) return vw_copy_text(params->to);
    const char *whole = scene->views[view].name, *slash = strrchr(whole, '/');
    char *bare = vw_copy_text(slash ? slash + 1 : whole), *point = bare ? strrchr(bare, '.') : NULL;
    if (point && point != bare) *point = 0;
    bool taken = false;
    for (uint32_t v = 0; bare && v < scene->view_count; v++)
        taken |= v != view && (!strcmp(scene->views[v].name, bare) || has_short_name(&scene->views[v], bare));
    char *name = bare ? vw_format_text("render_%s.png", taken ? whole : bare) : NULL;
    free(bare);
    for (char *next = name; next && *next; next++)
        if (*next == '/') *next = '_';
    char *path = name ? vw_path_join(params->out, name) : NULL;
    free(name);
    return path;
}

// Computes the photo's colour as training sees it.
static void photo_colour(const struct comparing *comparing, const struct vw_image *photo, uint32_t x_px, uint32_t y_px,
                         float rgb[3]) {
    float rgba[4];
    vw_image_pixel(photo, x_px, y_px, rgba);
    float alpha = comparing->on_background ? rgba[3] : 1.0f;
    for (int c = 0; c < 3; c++) rgb[c] = alpha * rgba[c] + (1.0f - alpha) * comparing->scene->background[c];
}

// Fills `pair`, twice as wide as the view, if there is one, and takes the PSNR over the whole view.
static double compare(const struct comparing *comparing, const struct vw_view *view, const float *render, float *pair) {
    const struct vw_image *photo = &view->image;
    double squared_error = 0;
    uint64_t value_count = 0;
    for (uint32_t y = 0; y < photo->height_px; y++)
        for (uint32_t x = 0; x < photo->width_px; x++) {
            const float *rendered = render + 3 * ((size_t)y * photo->width_px + x);
            float colour[3];
            bool counts = comparing->masked ? vw_view_keeps(view, x, y) : vw_view_can_use(view, x, y);
            photo_colour(comparing, photo, x, y, colour);
            for (int c = 0; c < 3 && counts; c++) squared_error += pow((double)rendered[c] - colour[c], 2);
            if (counts) value_count += 3;
            float *left = pair + 3 * ((size_t)y * 2 * photo->width_px + x);
            memcpy(left, colour, sizeof colour);
            memcpy(left + 3 * (size_t)photo->width_px, rendered, sizeof colour);
        }
    double mse = squared_error / (double)value_count;
    return vw_psnr_db(mse); // NaN when no pixel counts
}

static enum vw_status render_beside(const struct vw_rendering *rendering, const char *target, double *psnr_db) {
    const struct vw_view *view = &rendering->run.scene->views[rendering->view];
    const struct vw_recorded_run *run = &rendering->run;
    const struct comparing comparing = {run->scene, vw_effects_is_on(run->effects, run->effect_count, "background"),
                                        vw_effects_is_on(run->effects, run->effect_count, "masks")};
    uint32_t width_px = view->image.width_px, height_px = view->image.height_px;
    float *render = NULL;
    float *pair = vw_allocate(2 * (size_t)width_px * height_px, 3 * sizeof *pair);
    if (!pair) return VW_ERROR_MEMORY;
    enum vw_status status = vw_trainer_render(rendering->trainer, rendering->view, &render);
    if (!status) *psnr_db = compare(&comparing, view, render, pair);
    if (!status) status = vw_image_save(target, 2 * width_px, height_px, 3, pair);
    free(render);
    free(pair);
    return status;
}

static enum vw_status fill_result(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                  struct vw_rendered_view *rendered) {
    const struct vw_view *view = &rendering->run.scene->views[rendering->view];
    rendered->view = vw_copy_text(view->name);
    rendered->image_path = name_target(params, rendering->run.scene, rendering->view);
    rendered->split = view->split;
    rendered->fitted = vw_effects_fit_views(rendering->run.effects, rendering->run.effect_count);
    return rendered->view && rendered->image_path ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_render_view(const struct vw_render_params *params, struct vw_rendered_view *rendered) {
    struct vw_rendering rendering = {0};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = check_image(params->to);
    if (!status) status = take_lock(params->out, params->to, &lock);
    if (!status) status = open_rendering(params, &rendering);
    if (!status) status = fill_result(params, &rendering, rendered);
    if (!status) status = render_beside(&rendering, rendered->image_path, &rendered->psnr_db);
    if (!status && params->depth)
        status = write_depth(&rendering, &rendering.run.scene->views[rendering.view], rendered->image_path);
    close_rendering(&rendering);
    vw_out_lock_release(&lock);
    return status;
}

void vw_rendered_view_free(struct vw_rendered_view *rendered) {
    free(rendered->view);
    free(rendered->image_path);
    *rendered = (struct vw_rendered_view){0};
}

// ---- Video ---------------------------------------------------------------------------------------------------------

#define FRAMES_PER_SECOND "30"
#define FRAME_NAME "frame_%04u.png"
#define PATTERN "frame_%04d.png" // FRAME_NAME, for ffmpeg
enum { OUTPUT = 3 };
static const size_t VIDEO_LIMIT_BYTES = (size_t)1 << 32;

static bool has_ffmpeg(void) {
    char *paths = vw_copy_text(getenv("PATH") ? getenv("PATH") : ""), *rest = paths;
    bool found = false;
    for (const char *folder; !found && (folder = strsep(&rest, ":"));) {
        char *program = vw_path_join(*folder ? folder : ".", "ffmpeg");
        found = program && vw_file_exists(program) && !access(program, X_OK);
        free(program);
    }
    free(paths);
    return found;
}

static enum vw_status check_video(const char *to) {
    if (!to) return VW_OK;
    if (!vw_path_ends_with(to, ".mp4") && !vw_path_ends_with(to, ".gif"))
        return vw_fail(VW_ERROR_USAGE, "--video %s: the name must end in .mp4 or .gif", to);
    if (has_ffmpeg()) return VW_OK;
    return vw_fail(
        VW_ERROR_USAGE,
        "--video: ffmpeg is not installed; install it (Debian: apt-get install ffmpeg), or leave --video out");
}

static int spawn(const char *folder, const char *const *arguments, int output, pid_t *process) {
    posix_spawn_file_actions_t files;
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawn_file_actions_addchdir_np(&files, folder);
    if (!error) error = posix_spawn_file_actions_adddup2(&files, output, OUTPUT);
    if (!error) error = posix_spawnp(process, arguments[0], &files, NULL, (char *const *)arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

// Runs ffmpeg in the folder, since a name with % would be a pattern; its output is a file without a name, so that a
// killed program leaves nothing. Returns the error of the start.
static int start(const char *folder, bool gif, int output, pid_t *process) {
    static const char mp4_filter[] = "crop=trunc(iw/2)*2:trunc(ih/2)*2"; // which yuv420p needs
    static const char gif_filter[] = "split[a][b];[a]palettegen[p];[b][p]paletteuse";
    const char *const arguments[] = {"ffmpeg",
                                     "-nostdin",
                                     "-loglevel",
                                     "error",
                                     "-y",
                                     "-framerate",
                                     FRAMES_PER_SECOND,
                                     "-i",
                                     PATTERN,
                                     "-filter_complex",
                                     gif ? gif_filter : mp4_filter,
                                     "-pix_fmt",
                                     gif ? "pal8" : "yuv420p",
                                     "-f",
                                     gif ? "gif" : "mp4",
                                     "/dev/fd/3",
                                     NULL};
    return spawn(folder, arguments, output, process);
}

static enum vw_status wait_for(pid_t process) {
    int result;
    while (waitpid(process, &result, 0) < 0)
        if (errno != EINTR) return vw_fail(VW_ERROR_IO, "ffmpeg: cannot wait for it: %s", strerror(errno));
    if (WIFEXITED(result) && WEXITSTATUS(result) == 0) return VW_OK;
    return vw_fail(VW_ERROR_IO, "ffmpeg failed (see above); the frames are kept");
}

static enum vw_status encode(const char *folder, const char *to, int output) {
    pid_t process;
    void *video = NULL;
    size_t video_bytes = 0;
    int error = start(folder, vw_path_ends_with(to, ".gif"), output, &process);
    if (error) return vw_fail(VW_ERROR_IO, "ffmpeg: cannot start it: %s; the frames are kept", strerror(error));
    enum vw_status status = wait_for(process);
    if (!status) status = vw_descriptor_read(output, to, VIDEO_LIMIT_BYTES, &video, &video_bytes);
    if (!status) status = vw_file_write(to, video, video_bytes);
    free(video);
    return status;
}

// Makes a video of frame_0001.png and so on in a folder: whole or not at all.
static enum vw_status make_video(const char *folder, const char *to) {
    int output = vw_file_open_unnamed(folder);
    if (output < 0)
        return vw_fail(VW_ERROR_IO, "%s: cannot write the video: %s; the frames are kept", folder, strerror(errno));
    enum vw_status status = encode(folder, to, output);
    close(output);
    return status;
}

// ---- A path --------------------------------------------------------------------------------------------------------

static enum vw_status check_path(const struct vw_render_params *params) {
    if (params->pose && params->path) return vw_fail(VW_ERROR_USAGE, "--pose and --path: give one of them");
    enum vw_status status = check_video(params->video);
    return !status && params->pose ? check_image(params->to) : status;
}

static enum vw_status make_path(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                struct vw_camera_path *path) {
    const struct vw_scene *scene = rendering->run.scene;
    if (params->pose) return vw_camera_path_parse(scene, "--pose", params->pose, rendering->view, path);
    if (!vw_camera_path_is(params->path)) return vw_camera_path_read(scene, params->path, rendering->view, path);
    return vw_camera_path_make(scene, params->path, rendering->view, params->frames, path);
}

// Returns the name of a frame, owned by the caller; the first is 1.
static char *name_frame(const struct vw_render_params *params, const char *to, uint32_t number) {
    return params->pose ? vw_copy_text(to) : vw_format_text("%s/" FRAME_NAME, to, number);
}

// Refuses a user's folder with frames of a longer path, which a video would go on with.
static enum vw_status check_folder(const struct vw_render_params *params, uint32_t frame_count) {
    char *next = name_frame(params, params->to, frame_count + 1);
    if (!next) return VW_ERROR_MEMORY;
    enum vw_status status =
        vw_file_exists(next)
            ? vw_fail(VW_ERROR_USAGE, "%s: is of a longer path; remove its frames, or name another folder by --to",
                      next)
            : VW_OK;
    free(next);
    return status ? status : vw_folder_create(params->to);
}

static enum vw_status prepare_target(const struct vw_render_params *params, uint32_t frame_count,
                                     struct vw_rendered_path *rendered) {
    rendered->to =
        params->to ? vw_copy_text(params->to) : vw_path_join(params->out, params->pose ? "render_pose.png" : "frames");
    if (!rendered->to) return VW_ERROR_MEMORY;
    if (params->pose) return VW_OK;
    return params->to ? check_folder(params, frame_count) : vw_folder_create_inside(params->out, "frames");
}

static enum vw_status render_frame(const struct vw_rendering *rendering, const struct vw_view *frame,
                                   const char *name) {
    float *rgb = NULL;
    if (!name) return VW_ERROR_MEMORY;
    enum vw_status status = vw_trainer_render_posed(rendering->trainer, rendering->view, frame, false, &rgb);
    if (!status) status = vw_image_save(name, frame->camera.width_px, frame->camera.height_px, 3, rgb);
    free(rgb);
    return status;
}

static void remove_depth(const char *frame) {
    char *depth = name_depth(frame);
    if (depth) (void)unlink(depth);
    free(depth);
}

// Removes the frames of a longer path from OUT.
static enum vw_status remove_rest(const struct vw_render_params *params, const struct vw_rendered_path *rendered) {
    bool removed = !params->pose && !params->to;
    for (uint32_t number = rendered->frame_count + 1; removed; number++) {
        char *name = name_frame(params, rendered->to, number);
        if (!name) return VW_ERROR_MEMORY;
        removed = unlink(name) == 0;
        remove_depth(name);
        free(name);
    }
    return VW_OK;
}

static enum vw_status render_frames(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                    const struct vw_camera_path *path, struct vw_rendered_path *rendered) {
    enum vw_status status = prepare_target(params, path->count, rendered);
    if (!status && params->path) vw_log_info("rendering %u frames to %s", path->count, rendered->to);
    for (uint32_t f = 0; f < path->count && !status; f++) {
        char *name = name_frame(params, rendered->to, f + 1);
        status = render_frame(rendering, &path->frames[f], name);
        if (!status && params->depth) status = write_depth(rendering, &path->frames[f], name);
        else if (!status && params->path) remove_depth(name);
        free(name);
    }
    rendered->frame_count = path->count;
    return status ? status : remove_rest(params, rendered);
}

enum vw_status vw_render_path(const struct vw_render_params *params, struct vw_rendered_path *rendered) {
    struct vw_rendering rendering = {0};
    struct vw_camera_path path = {0};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = check_path(params);
    if (!status) status = take_lock(params->out, params->to, &lock);
    if (!status && params->video && !lock) status = take_lock(params->out, params->video, &lock);
    if (!status) status = open_rendering(params, &rendering);
    if (!status) status = make_path(params, &rendering, &path);
    if (!status) status = render_frames(params, &rendering, &path, rendered);
    if (!status && params->video) status = make_video(rendered->to, params->video);
    if (!status) rendered->video = params->video;
    vw_camera_path_free(&path);
    close_rendering(&rendering);
    vw_out_lock_release(&lock);
    return status;
}

void vw_rendered_path_free(struct vw_rendered_path *rendered) {
    free(rendered->to);
    *rendered = (struct vw_rendered_path){0};
}

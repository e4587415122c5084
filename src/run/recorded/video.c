#include "run/recorded/video.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "viewworth/log.h"

#define PATTERN "frame_%04d.png" // VW_VIDEO_FRAME_NAME, for ffmpeg
enum { OUTPUT = 3 };
static const size_t VIDEO_LIMIT_BYTES = (size_t)1 << 32;

enum vw_status vw_video_check(const char *to) {
    if (!to || vw_path_ends_with(to, ".mp4") || vw_path_ends_with(to, ".gif")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--video %s: the name must end in .mp4 or .gif", to);
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
                                     VW_VIDEO_FRAMES_PER_SECOND,
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

static enum vw_status encode(const char *folder, const char *to, int output, bool *made) {
    pid_t process;
    void *video = NULL;
    size_t video_bytes = 0;
    int error = start(folder, vw_path_ends_with(to, ".gif"), output, &process);
    if (error == ENOENT) {
        vw_log_warning(
            "--video: ffmpeg is not installed (Debian: apt-get install ffmpeg); then: ffmpeg -framerate %s -i "
            "%s/%s -pix_fmt yuv420p %s",
            VW_VIDEO_FRAMES_PER_SECOND, folder, PATTERN, to);
        return VW_OK;
    }
    if (error) return vw_fail(VW_ERROR_IO, "ffmpeg: cannot start it: %s; the frames are kept", strerror(error));
    enum vw_status status = wait_for(process);
    if (!status) status = vw_descriptor_read(output, to, VIDEO_LIMIT_BYTES, &video, &video_bytes);
    if (!status) status = vw_file_write(to, video, video_bytes);
    free(video);
    *made = !status;
    return status;
}

enum vw_status vw_video_make(const char *folder, const char *to, bool *made) {
    *made = false;
    int output = vw_file_open_unnamed(folder);
    if (output < 0)
        return vw_fail(VW_ERROR_IO, "%s: cannot write the video: %s; the frames are kept", folder, strerror(errno));
    enum vw_status status = encode(folder, to, output, made);
    close(output);
    return status;
}

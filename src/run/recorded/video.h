// Numbered images as a video, by the program ffmpeg.
#ifndef VIEWWORTH_RUN_RECORDED_VIDEO_H
#define VIEWWORTH_RUN_RECORDED_VIDEO_H

#include <stdbool.h>

#include "viewworth/status.h"

#define VW_VIDEO_FRAMES_PER_SECOND "30"
#define VW_VIDEO_FRAME_NAME "frame_%04u.png"

// Refuses a name that ends neither in .mp4 nor in .gif.
enum vw_status vw_video_check(const char *to);
// Makes a video of frame_0001.png and so on in a folder: whole or not at all. *made is false, and a warning says what
// to do, if there is no ffmpeg.
enum vw_status vw_video_make(const char *folder, const char *to, bool *made);

#endif

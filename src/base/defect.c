#include "base/defect.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "viewworth/status.h"

const char *const vw_defect_words[VW_DEFECT_COUNT] = {
    [VW_DEFECT_EMPTY] = "empty",       [VW_DEFECT_ORIENTATION] = "orientation",
    [VW_DEFECT_SWAPPED] = "swapped",   [VW_DEFECT_POSE] = "pose",
    [VW_DEFECT_ZOOM] = "zoom",         [VW_DEFECT_MISMATCH] = "mismatch",
    [VW_DEFECT_COPY] = "copy",         [VW_DEFECT_OCCLUDER] = "occluder",
    [VW_DEFECT_BLUR] = "blur",         [VW_DEFECT_MOTION_BLUR] = "motion blur",
    [VW_DEFECT_EXPOSURE] = "exposure", [VW_DEFECT_NOISE] = "noise",
    [VW_DEFECT_TRACKS] = "tracks",     [VW_DEFECT_FEW_TRACKS] = "few tracks"};

const struct vw_photo_finding vw_photo_finding_unknown = {
    .in_place = NAN, .hidden = NAN, .turned_deg = NAN, .stops = NAN, .sharpness = NAN, .noise = NAN, .covered = NAN};

const char *vw_defect_find_word(const char *word) {
    for (int kind = 0; word && kind < VW_DEFECT_COUNT; kind++)
        if (strcmp(vw_defect_words[kind], word) == 0) return vw_defect_words[kind];
    return NULL;
}

char *vw_defect_describe(const struct vw_defect *defect, const char *other, char text[VW_DEFECT_TEXT_BYTES]) {
    const size_t bytes = VW_DEFECT_TEXT_BYTES;
    double amount = defect->amount, percent = 100 * amount;
    switch (defect->kind) {
    case VW_DEFECT_EMPTY: snprintf(text, bytes, "shows nothing"); break;
    case VW_DEFECT_ORIENTATION:
        snprintf(text, bytes, "its pixels must be turned by %.0f degrees clockwise%s", amount,
                 defect->detail > 0 ? ", as its EXIF data says" : "");
        break;
    case VW_DEFECT_SWAPPED: snprintf(text, bytes, "shows what %.200s should show", other); break;
    case VW_DEFECT_POSE:
        snprintf(text, bytes, "taken %.1f degrees (%.0f px) off its pose", amount, defect->detail);
        break;
    case VW_DEFECT_ZOOM: snprintf(text, bytes, "taken with %.2f times the focal length of its camera", amount); break;
    case VW_DEFECT_MISMATCH: snprintf(text, bytes, "shows %.0f %% of what its pose sees", percent); break;
    case VW_DEFECT_COPY: snprintf(text, bytes, "shows the same as %.200s", other); break;
    case VW_DEFECT_OCCLUDER: snprintf(text, bytes, "%.0f %% of it show something that others do not", percent); break;
    case VW_DEFECT_BLUR: snprintf(text, bytes, "%.0f %% as sharp as others", percent); break;
    case VW_DEFECT_MOTION_BLUR:
        snprintf(text, bytes, "%.0f %% as sharp as others at %.0f degrees", percent, defect->detail);
        break;
    case VW_DEFECT_EXPOSURE:
        snprintf(text, bytes, "%.1f stops %s than others", fabs(amount), amount > 0 ? "brighter" : "darker");
        break;
    case VW_DEFECT_NOISE: snprintf(text, bytes, "%.1f times as noisy as others", amount); break;
    case VW_DEFECT_FEW_TRACKS:
        snprintf(text, bytes, "tracks %.0f points, others track about %.0f", amount, defect->detail);
        break;
    default:
        if (defect->detail > 0) snprintf(text, bytes, "it faces away from %.0f %% of its points", 100 * defect->detail);
        else snprintf(text, bytes, "its tracks are %.1f px from its points", amount);
    }
    vw_text_make_line(text); // a name may have been cut within a character
    return text;
}

const char *vw_defect_remedy(const struct vw_defect *defect) {
    static const char *const remedies[VW_DEFECT_COUNT] = {
        [VW_DEFECT_EMPTY] = "leave it out",
        [VW_DEFECT_ORIENTATION] = "turn its pixels back (mogrify -rotate), or leave it out",
        [VW_DEFECT_SWAPPED] = "give the files their own names",
        [VW_DEFECT_POSE] = "correct its pose (--copy), or leave it out",
        [VW_DEFECT_ZOOM] = "give it a camera of its own, or leave it out",
        [VW_DEFECT_MISMATCH] = "find its pose again, or leave it out",
        [VW_DEFECT_COPY] = "keep one of them",
        [VW_DEFECT_OCCLUDER] = "mask it (masks/NAME.png), or leave it out",
        [VW_DEFECT_BLUR] = "leave it out if others show the same",
        [VW_DEFECT_MOTION_BLUR] = "leave it out if others show the same",
        [VW_DEFECT_EXPOSURE] = "train with --effects +appearance",
        [VW_DEFECT_NOISE] = "leave it out if others show the same",
        [VW_DEFECT_TRACKS] = "reconstruct its pose and points together",
        [VW_DEFECT_FEW_TRACKS] = "add photos beside it, or leave it out",
    };
    if (defect->kind == VW_DEFECT_ORIENTATION && defect->detail > 0)
        return "turn its pixels back (mogrify -auto-orient), or leave it out";
    return remedies[defect->kind];
}

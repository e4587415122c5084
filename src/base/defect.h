// A defect of a photo: check/ finds it by the photos alone, run/ by the trained field; report/ advises by it.
#ifndef VIEWWORTH_BASE_DEFECT_H
#define VIEWWORTH_BASE_DEFECT_H

#include <stdint.h>

// In the order in which they matter: the first of a photo is its reason.
enum vw_defect_kind {
    VW_DEFECT_EMPTY,       // amount: contrast, [0,1]
    VW_DEFECT_ORIENTATION, // degrees clockwise that turn its pixels back; `detail`: 1 if EXIF says so
    VW_DEFECT_SWAPPED,     // share of points in place at the pose of `other`
    VW_DEFECT_POSE,        // degrees; `detail`: pixels
    VW_DEFECT_ZOOM,        // times the focal length of its camera
    VW_DEFECT_MISMATCH,    // share of points in place
    VW_DEFECT_COPY,        // similarity to the first of its near-duplicates, of which `other` is to be kept
    VW_DEFECT_OCCLUDER,    // share of the photo
    VW_DEFECT_BLUR,        // sharpness beside other photos
    VW_DEFECT_MOTION_BLUR, // the same, in the direction `detail`, degrees
    VW_DEFECT_EXPOSURE,    // stops
    VW_DEFECT_NOISE,       // times that of other photos
    VW_DEFECT_TRACKS,      // pixels between tracks and points; `detail`: share of points it faces away from
    VW_DEFECT_FEW_TRACKS,  // points that it tracks; `detail`: those of others
    VW_DEFECT_COUNT
};

// The words of kinds: "empty", "orientation", "swapped", "pose", "zoom", "mismatch", "copy", "occluder", "blur",
// "motion blur", "exposure", "noise", "tracks", "few tracks".
extern const char *const vw_defect_words[VW_DEFECT_COUNT];
// Returns the static word that equals `word`; NULL for other words and NULL.
const char *vw_defect_find_word(const char *word);

enum { VW_DEFECT_TEXT_BYTES = 320 };
#define VW_DEFECT_NO_OTHER UINT32_MAX

struct vw_defect {
    uint32_t view; // index in vw_scene.views
    enum vw_defect_kind kind;
    double amount, detail; // in the unit of the kind
    uint32_t other;        // the photo that it shows or repeats, likewise; VW_DEFECT_NO_OTHER: none
};

// The findings on a photo. Numbers as in check/check.h; NaN: unknown.
struct vw_photo_finding {
    const char *word;                       // static, of the first defect; NULL: none was found
    char description[VW_DEFECT_TEXT_BYTES]; // the first defect's
    double in_place, hidden, turned_deg, stops, sharpness, noise;
    double covered; // share of the photo that the trained field does not explain (run/outputs/cover_masks.h)
};
extern const struct vw_photo_finding vw_photo_finding_unknown;

// Describes a defect in a few words, and says what to do; `other`: the name of that photo, if it has one. Returns the
// text.
char *vw_defect_describe(const struct vw_defect *defect, const char *other, char text[VW_DEFECT_TEXT_BYTES]);
const char *vw_defect_remedy(const struct vw_defect *defect);

#endif

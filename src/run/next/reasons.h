// Why a place is proposed, in words for people.
#ifndef VIEWWORTH_RUN_NEXT_REASONS_H
#define VIEWWORTH_RUN_NEXT_REASONS_H

#include "run/next/known_photos.h"
#include "run/next/proposals.h"

enum vw_next_reason {
    VW_SEEN_BY_FEW,
    VW_HIGH_ERROR,
    VW_EXTRAPOLATES,
    VW_BETWEEN_PHOTOS,
    VW_SEES_NOTHING,
    VW_NEXT_REASON_COUNT
};

// Returns "seen by few" and so on.
const char *vw_next_reason_word(enum vw_next_reason reason);
// Prints the words of a set of reasons, bits by enum vw_next_reason, with commas between.
void vw_next_print_reasons(uint32_t reasons, char *text, size_t size_bytes);
// Returns whether a text is one of the words. NULL is none.
bool vw_next_reason_is_known(const char *word);

// Fills in all fields of the proposals but their gains. A place
//   seen by few     has points that at most half as many known photos see, in the median, as see those of the median
//                   known photo,
//   high error      has a validation photo at most two usual distances away, the nearest of three or more, whose error
//                   is above their median,
//   extrapolates    is more than two usual distances away from the nearest known photo,
//   between photos  has none of these reasons, and is less than a usual distance away from the nearest known photo,
//   sees nothing    sees no matter; it is not said to be seen by few.
// Other places have no reason.
enum vw_status vw_next_find_reasons(const struct vw_known_photos *known, struct vw_next *next);

#endif

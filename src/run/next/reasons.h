// Why a place is proposed, in words for people.
#ifndef VIEWWORTH_RUN_NEXT_REASONS_H
#define VIEWWORTH_RUN_NEXT_REASONS_H

#include "run/next/candidate_scores.h"
#include "run/next/depth_maps.h"
#include "run/next/proposals.h"

enum vw_next_reason { VW_SEEN_BY_FEW, VW_HIGH_ERROR, VW_EXTRAPOLATES, VW_BETWEEN_PHOTOS, VW_NEXT_REASON_COUNT };

// Returns "seen by few" and so on.
const char *vw_next_reason_word(enum vw_next_reason reason);
// Prints the words of a set of reasons, bits by enum vw_next_reason, with commas between.
void vw_next_print_reasons(uint32_t reasons, char *text, size_t size_bytes);
// Returns whether a text is one of the words. NULL is none.
bool vw_next_reason_is_known(const char *word);

// Fills in what is said of the proposals beside their gains. A place is
//   seen by few     where at most half as many known photos see its points as see those of the median known photo,
//   high error      where the field's error at the nearest validation photo is above their median,
//   extrapolates    where the nearest known photo is more than two usual distances between neighbours away,
//   between photos  in all other cases.
// `maps` are those of the known photos.
enum vw_status vw_next_explain(const struct vw_known_views *known, const struct vw_depth_map *maps,
                               const struct vw_depth_source *depths, struct vw_next *next);

#endif

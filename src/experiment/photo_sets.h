// The lists of photos that are compared: what --list says, as views of the scene.
#ifndef VIEWWORTH_COMPARED_LISTS_H
#define VIEWWORTH_COMPARED_LISTS_H

#include <stdbool.h>
#include <stdint.h>

#include "cli/options.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_photo_set {
    char *name;      // owned; the word, or the file's name without folder and extension; unique
    bool random;     // drawn anew for each seed
    uint32_t *views; // owned; scene indices, ascending; of a random one those drawn last
    uint32_t count;  // of photos, at least 2
    uint32_t epochs; // that it trains
};

struct vw_photo_sets {
    struct vw_photo_set lists[VW_TEXTS_MOST];
    uint32_t count;
    bool by_scores;                     // some are chosen by those of --scores, and so by validation photos
    uint32_t *train_views, train_count; // owned; all photos that may be trained on
};

// Whether every --list is a word or a file that is there, and all that they need is given; before anything is opened.
enum vw_status vw_photo_sets_check(const struct vw_options *options);
// Makes the lists. VW_ERROR_USAGE and VW_ERROR_INPUT name the list that cannot be made. Free them also after a failure.
enum vw_status vw_photo_sets_make(const struct vw_options *options, const struct vw_scene *scene,
                                  struct vw_photo_sets *lists);
void vw_photo_sets_free(struct vw_photo_sets *lists);

// The photos of a list in trainings with a seed: of a random one, draws them (Philox, by the seed and the list's place
// among the lists).
const uint32_t *vw_photo_sets_draw(struct vw_photo_sets *lists, uint32_t list, uint64_t seed);
// Whether a list that is not random has a view.
bool vw_photo_set_has(const struct vw_photo_set *list, uint32_t view);

#endif

// The lists of photos that a comparison trains on, as views of the scene.
#ifndef VIEWWORTH_EXPERIMENT_PHOTO_SETS_H
#define VIEWWORTH_EXPERIMENT_PHOTO_SETS_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_experiment_params;

enum { VW_PHOTO_SETS_MAX = 32 };

struct vw_photo_sets_params {
    // 1 to VW_PHOTO_SETS_MAX lists: all, without-outliers, positive, significant, not-harmful, top:K, top:P%,
    // drop:K, drop:P%, random (as many photos as the list before it, drawn for each seed), SCORES.csv@LEAST, or a file
    // of names
    const char *const *lists;
    uint32_t list_count;
    const char *scores; // folder of the valued run that positive, significant, not-harmful, top and drop select by
    const char *method; // method of the scores; NULL: as vw_selection_params.method says
    enum vw_equal equal;
};

struct vw_photo_set {
    char *name;      // owned: the word, or the file's name without folder and extension; unique
    bool random;     // drawn for each seed
    uint32_t *views; // owned: scene indices, ascending; of a random list those drawn last
    uint32_t count;  // photos, at least 2
    uint32_t epochs; // that it trains
};

struct vw_photo_sets {
    struct vw_photo_set lists[VW_PHOTO_SETS_MAX];
    uint32_t count;
    bool by_scores;                     // some were selected by scores, and so by validation photos
    uint32_t *train_views, train_count; // owned: all photos that may be trained on
};

// Checks that every list is a word or a file that exists and has what it needs, before anything is opened.
enum vw_status vw_photo_sets_check(const struct vw_photo_sets_params *params);
// Makes the lists. VW_ERROR_USAGE and VW_ERROR_INPUT name the list that cannot be made. Warns about scores that do not
// suit the scene or the seeds. Free them also after a failure.
enum vw_status vw_photo_sets_make(const struct vw_photo_sets_params *params, const struct vw_experiment_params *common,
                                  const struct vw_scene *scene, struct vw_photo_sets *sets);
void vw_photo_sets_free(struct vw_photo_sets *sets);

// Returns the photos of a list in trainings with a seed. Draws those of a random list (Philox, by the seed and the
// place of the list).
const uint32_t *vw_photo_sets_draw(struct vw_photo_sets *sets, uint32_t list, uint64_t seed);
// Returns whether a list that is not random has a view.
bool vw_photo_set_has(const struct vw_photo_set *list, uint32_t view);

#endif

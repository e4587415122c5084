// The effects that a scene calls for.
//
// Facts come first: lenses, transparent pixels and mask files are read from the scene. Points of structure from motion
// tell whether photos differ in exposure and whether anything can lie beyond the box.
// Everything else is measured. The search begins with what is on by then. It makes paired pilots (pilots.h) with each
// further effect that is possible beside these, adds the one whose gain has the highest lower bound if that bound lies
// above the price of PRICE_DB, and begins again; with longer pilots for those in doubt, if none does. Where points do
// not tell of exposures, photos held out of the last pilot do.
#ifndef VIEWWORTH_DETECT_DECIDE_H
#define VIEWWORTH_DETECT_DECIDE_H

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// The differences between photos in the points that they share: the mean reduction of their squared errors by exposures
// (vw_scene_estimate_exposures), as a gain in PSNR at the level of a default run, PHOTOMETRIC_LEVEL_DB. The photos are
// all there are, so the standard error is that of their observations.
struct vw_photometric_evidence {
    double gain_db, stderr_db, low_db; // low: end of a one-sided 95 % interval; NaN where no photo tells
    uint32_t photo_count;              // train photos that tell
    uint64_t observation_count;        // theirs
};
enum { PHOTOMETRIC_LEVEL_DB = 22 };
enum vw_status vw_photometric_measure(const struct vw_scene *scene, struct vw_photometric_evidence *evidence);

// The extent of a scene as points show it.
struct vw_point_evidence {
    double outside_share; // observations of points outside the scene's box, of all
    double bare_share;    // area of train photos without a point near (sky, or nothing to match), of all
    double inner_share;   // extent of the inner region of the effect unbounded, of the box's extent
    bool known;           // there are points
};
enum vw_status vw_point_evidence_find(const struct vw_scene *scene, struct vw_point_evidence *evidence);

// Decides for a run of the scene with the config `planned`, whose `effects` leave the choice or make it. Without a
// device (NULL), with planned->pilot_steps = 0, on fewer than 8 train photos, or where `effects` leaves nothing open,
// there are no pilots: what only they could tell is NaN, and off. The same scene, config and device give the same
// decisions, whatever the seed of the run.
enum vw_status vw_effects_decide(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned,
                                 struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count);
// Finds only what files and points tell, with `effects` applied to it. May decode the train photos.
enum vw_status vw_effects_find_facts(const struct vw_scene *scene, const char *effects,
                                     struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count);

// Decides in the same way, with what pilots measured before on the same scene, device and version, kept in the user's
// cache folder (decision_cache.c). Facts are always found anew.
enum vw_status vw_effects_decide_cached(struct vw_gpu *gpu, const struct vw_scene *scene,
                                        const struct vw_config *planned,
                                        struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count);

// Returns whether the decision needs pilots.
bool vw_effects_need_pilots(const struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned);

// Returns how many steps a pilot takes for a run of the scene with the config `planned`.
uint32_t vw_pilot_steps(const struct vw_scene *scene, const struct vw_config *planned);
// Returns how many it takes where effects seem to gain, but not surely: twice as many, where the run has as many and
// planned->pilot_steps names none.
uint32_t vw_pilot_steps_in_doubt(const struct vw_scene *scene, const struct vw_config *planned);

#endif

// The registry of effects: optional parts of image formation, each with its specialization constant (decision 7). What
// a scene shows of an effect is measured in src/detect. A new effect is a row of the table here; with params or passes
// also a file with its struct vw_effect_kind and its row in the second table (kind.h); and, when it is detected, a
// row of the table in src/detect/decide.c.
#ifndef VIEWWORTH_TRAIN_EFFECTS_REGISTRY_H
#define VIEWWORTH_TRAIN_EFFECTS_REGISTRY_H

#include "interface.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

enum { VW_EFFECT_CONFLICTS_MAX = 2 };

// An effect beside which another one is never called for; before it in the table.
struct vw_effect_conflict {
    const char *name;
    const char *refusal;  // the message where --effects names both: a named effect switches off an unnamed one.
                          // NULL: --effects may name both
    bool refused_unnamed; // refused also where --effects does not name this one
};

struct vw_effect {
    const char *name, *meaning; // meaning: what its evidence is, with the unit
    size_t constant;            // offset of its switch in struct vw_specialization; SIZE_MAX: the host does all
    const char *requires;       // NULL, or the effect without which this one does nothing; before it in the table
    struct vw_effect_conflict conflicts[VW_EFFECT_CONFLICTS_MAX]; // the first without a name ends them
    const char *hides;  // NULL, or the effect that changes nothing beside this one
    uint32_t renderers; // the set of those that it works with (renderers/registry.h)
    bool on_request;    // nothing calls for it: it is on where --effects names it
};

// Returns all effects, in the order of decisions.
const struct vw_effect *vw_effects_get(uint32_t *count);

bool vw_effect_works_with(const struct vw_effect *effect, enum vw_field field);

// Returns whether --effects leaves a choice to what is measured: false for "none" and for a list that names all that is
// on.
bool vw_effects_leave_to_evidence(const char *choice);
// Returns whether a field can have all effects that --effects switches on by name.
bool vw_effects_suit(const char *choice, enum vw_field field);
// Returns whether --effects names the effect, with any sign.
bool vw_effects_names(const char *choice, const char *name);

// Returns whether a training leaves out the pixels that mask files hide; true also for a scene without mask files.
bool vw_effects_obey_masks(const struct vw_scene *scene, const struct vw_effect_decision *decisions, uint32_t count);

// The kinds of all effects that have params, buffers or passes of their own, in the order in which their params are
// laid out and their passes recorded; the end is NULL.
extern const struct vw_effect_kind *const vw_effect_kinds[];

// Sets the specialization constants of the effects that are on. `decisions` has one entry per effect.
void vw_effects_specialise(const struct vw_effect_decision *decisions, const struct vw_scene *scene,
                           struct vw_specialization *specialization);

#endif

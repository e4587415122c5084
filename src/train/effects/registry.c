#include "train/effects/registry.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "train/effects/kind.h"
#include "train/renderers/registry.h"

#define CONSTANT VW_EFFECT_CONSTANT
#define HOST_ONLY SIZE_MAX // no specialization constant: the host does all

static const char measured_gain[] = "gain in a short training over one without, dB, +- standard error";
static const char appearance_gain[] =
    "gain by exposures of photos, by points or in a short training without them, dB, +- standard error";
static const char on_request[] = "nothing: on where --effects names it";

// clang-format off
static const struct vw_effect effects[] = {
    {.name = "distortion", .constant = CONSTANT(distortion), .renderers = VW_RENDERERS_ALL,
     .meaning = "largest shift of an image corner by lens distortion, px"},
    {.name = "background", .constant = CONSTANT(background), .renderers = VW_RENDERERS_ALL,
     .meaning = "share of photos with transparent pixels"},
    {.name = "masks", .constant = HOST_ONLY, .renderers = VW_RENDERERS_ALL,
     .meaning = "share of photos with a mask file"},
    {.name = "sky", .constant = CONSTANT(sky), .renderers = VW_RENDERERS_ALL, .meaning = measured_gain},
    // Its last sample reaches so far that nothing beyond it is seen.
    {.name = "unbounded", .constant = CONSTANT(unbounded), .renderers = VW_RENDERER_VOLUME,
     .meaning = measured_gain, .hides = "sky"},
    {.name = "wide_box", .constant = HOST_ONLY, .renderers = VW_RENDERER_VOLUME, .meaning = measured_gain,
     .conflicts = {{.name = "unbounded"}}},
    {.name = "appearance", .constant = CONSTANT(appearance), .renderers = VW_RENDERERS_ALL, .meaning = appearance_gain},
    // Splats have no codes: a shift of all constant harmonics alike is the bias of appearance, and one per splat would
    // need columns and passes of its own.
    {.name = "appearance_code", .constant = CONSTANT(appearance_code), .renderers = VW_RENDERER_VOLUME,
     .meaning = on_request, .requires = "appearance",
     .on_request = true},
    {.name = "visibility", .constant = CONSTANT(visibility), .renderers = VW_RENDERER_VOLUME,
     .meaning = on_request, .on_request = true},
    // Visibility says of whole rays what transient says of samples, by another loss.
    {.name = "transient", .constant = CONSTANT(transient), .renderers = VW_RENDERER_VOLUME,
     .meaning = on_request, .on_request = true,
     .conflicts = {{.name = "visibility", .refusal = "visibility cannot be beside transient; leave one of them out"}}},
    // All three leave out of the loss what others contradict, and uncertainty takes the slots of visibility.
    {.name = "uncertainty", .constant = CONSTANT(uncertainty), .renderers = VW_RENDERERS_ALL, .meaning = on_request,
     .on_request = true,
     .conflicts = {{.name = "visibility", .refusal = "visibility cannot be beside uncertainty; leave one of them out"},
                   {.name = "transient", .refusal = "transient cannot be beside uncertainty; leave one of them out"}}},
    // The effect goes back through the hash grid's cells, within a box that needs no contraction.
    {.name = "pose", .constant = CONSTANT(pose), .renderers = VW_RENDERER_VOLUME,
     .meaning = on_request, .on_request = true,
     .conflicts = {{.name = "unbounded", .refused_unnamed = true,
                    .refusal = "pose excludes unbounded; leave one out (--effects +pose,-unbounded)"}}},
    // All three are effects by which photos have colours of their own.
    {.name = "appearance_encoder", .constant = CONSTANT(appearance_encoder), .renderers = VW_RENDERER_VOLUME,
     .meaning = on_request, .on_request = true,
     .conflicts = {{.name = "appearance",
                    .refusal = "appearance_encoder replaces appearance; leave one of them out"},
                   {.name = "appearance_code",
                    .refusal = "appearance_encoder replaces appearance_code; leave one of them out"}}},
};
// clang-format on
_Static_assert(VW_ARRAY_COUNT(effects) <= VW_EFFECT_COUNT_MAX, "more effects than decisions");

// The effects of the table above that have params, buffers or passes of their own; each in its own file.
extern const struct vw_effect_kind vw_effect_sky, vw_effect_appearance, vw_effect_transient, vw_effect_appearance_code,
    vw_effect_visibility, vw_effect_uncertainty, vw_effect_pose, vw_effect_appearance_encoder;

const struct vw_effect_kind *const vw_effect_kinds[] = {&vw_effect_sky,
                                                        &vw_effect_appearance,
                                                        &vw_effect_transient,
                                                        &vw_effect_appearance_code,
                                                        &vw_effect_visibility,
                                                        &vw_effect_uncertainty,
                                                        &vw_effect_pose,
                                                        &vw_effect_appearance_encoder,
                                                        NULL};
_Static_assert(VW_ARRAY_COUNT(vw_effect_kinds) - 1 <= VW_EFFECT_COUNT_MAX, "more kinds than effects");

static int find_effect(struct vw_word name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++)
        if (vw_word_is(name, effects[i].name)) return (int)i;
    return -1;
}

// Returns a word of --effects without its sign: "name" and "+name" switch on, "-name" switches off.
static struct vw_word unsigned_word(struct vw_word word) {
    size_t sign = word.length && (word.text[0] == '-' || word.text[0] == '+');
    return (struct vw_word){word.text + sign, word.length - sign};
}

static enum vw_status apply_word(struct vw_word word, struct vw_effect_decision *decisions) {
    int effect = find_effect(unsigned_word(word));
    if (effect < 0) {
        char known[256] = "";
        for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++)
            snprintf(known + strlen(known), sizeof known - strlen(known), " %s", effects[i].name);
        return vw_fail(VW_ERROR_USAGE, "--effects: \"%.*s\" is not an effect; known are:%s", (int)word.length,
                       word.text, known);
    }
    decisions[effect].on = word.text[0] != '-';
    return VW_OK;
}

const struct vw_effect *vw_effects_get(uint32_t *count) {
    *count = VW_ARRAY_COUNT(effects);
    return effects;
}

void vw_effects_list(struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++)
        decisions[i] = (struct vw_effect_decision){.name = effects[i].name,
                                                   .evidence = NAN,
                                                   .evidence_stderr = NAN,
                                                   .evidence_low = NAN,
                                                   .threshold = NAN,
                                                   .ms_per_step = NAN,
                                                   .device_bytes = NAN,
                                                   .meaning = effects[i].meaning};
    *count = VW_ARRAY_COUNT(effects);
}

// Returns whether the form of the choice (auto | none | LIST | +a,-b) leaves something to the evidence. A list without
// signs means exactly these effects; signs change what the evidence calls for.
bool vw_effects_leave_to_evidence(const char *choice) {
    return !strcmp(choice, "auto") || choice[0] == '+' || choice[0] == '-';
}

struct vw_effect_decision *vw_effects_find(struct vw_effect_decision *decisions, uint32_t count, const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(decisions[i].name, name)) return &decisions[i];
    return NULL;
}

bool vw_effects_is_on(const struct vw_effect_decision *decisions, uint32_t count, const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(decisions[i].name, name)) return decisions[i].on;
    return false;
}

bool vw_effects_fit_views(const struct vw_effect_decision *decisions, uint32_t count) {
    bool found = false;
    for (uint32_t i = 0; vw_effect_kinds[i]; i++)
        found |= vw_effect_kinds[i]->fits_views && vw_effects_is_on(decisions, count, vw_effect_kinds[i]->name);
    return found;
}

bool vw_effects_halve_views(const struct vw_effect_decision *decisions, uint32_t count) {
    bool found = vw_effects_fit_views(decisions, count);
    for (uint32_t i = 0; vw_effect_kinds[i]; i++)
        found |= vw_effect_kinds[i]->photo_pass_count && vw_effects_is_on(decisions, count, vw_effect_kinds[i]->name);
    return found;
}

bool vw_effects_obey_masks(const struct vw_scene *scene, const struct vw_effect_decision *decisions, uint32_t count) {
    return !scene->masked_view_count || vw_effects_is_on(decisions, count, "masks");
}

bool vw_effects_names(const char *choice, const char *name) {
    struct vw_word word;
    while (vw_word_list_next(&choice, &word))
        if (vw_word_is(unsigned_word(word), name)) return true;
    return false;
}

// Switches off an effect that `choice` does not name when the effect that it requires is off, or one that conflicts
// with it is on.
static void follow_others(const char *choice, struct vw_effect_decision *decisions, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (vw_effects_names(choice, effects[i].name)) continue;
        if (effects[i].requires && !vw_effects_is_on(decisions, count, effects[i].requires)) decisions[i].on = false;
        for (uint32_t c = 0; c < VW_EFFECT_CONFLICTS_MAX && effects[i].conflicts[c].name; c++)
            if (vw_effects_is_on(decisions, count, effects[i].conflicts[c].name)) decisions[i].on = false;
    }
}

enum vw_status vw_effects_choose(const char *choice, struct vw_effect_decision *decisions, uint32_t count) {
    bool exactly = !vw_effects_leave_to_evidence(choice);
    for (uint32_t i = 0; i < count; i++) decisions[i].on = decisions[i].called_for && !exactly;
    if (!strcmp(choice, "none") || !strcmp(choice, "auto")) return VW_OK;
    const char *rest = choice;
    struct vw_word word;
    while (vw_word_list_next(&rest, &word)) {
        if ((word.text[0] != '+' && word.text[0] != '-') != exactly)
            return vw_fail(VW_ERROR_USAGE, "--effects: \"%s\" mixes names with and without + or -; use one form",
                           choice);
        enum vw_status status = apply_word(word, decisions);
        if (status) return status;
    }
    if (!exactly) follow_others(choice, decisions, count);
    return VW_OK;
}

// Switches an effect off beside another one, or refuses it where --effects names it, or always.
static enum vw_status switch_off(const struct vw_config *config, struct vw_effect_decision *decisions, uint32_t count,
                                 const char *name, const char *refusal, bool always) {
    if (!vw_effects_is_on(decisions, count, name)) return VW_OK;
    if (always || vw_effects_names(config->effects, name)) return vw_fail(VW_ERROR_USAGE, "--effects: %s", refusal);
    decisions[find_effect((struct vw_word){name, strlen(name)})].on = false;
    return VW_OK;
}

bool vw_effect_works_with(const struct vw_effect *effect, enum vw_field field) {
    return effect->renderers & vw_renderer_of(field);
}

bool vw_effects_suit(const char *choice, enum vw_field field) {
    struct vw_word word;
    while (vw_word_list_next(&choice, &word)) {
        int effect = word.text[0] == '-' ? -1 : find_effect(unsigned_word(word));
        if (effect >= 0 && !vw_effect_works_with(&effects[effect], field)) return false;
    }
    return true;
}

// Leaves a renderer the effects that it can have.
static enum vw_status follow_renderer(const struct vw_config *config, struct vw_effect_decision *decisions,
                                      uint32_t count) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        char refusal[128];
        snprintf(refusal, sizeof refusal, "%s is not there with --field %s; leave it out", effects[i].name,
                 vw_field_name(config->field));
        if (!vw_effect_works_with(&effects[i], config->field))
            status = switch_off(config, decisions, count, effects[i].name, refusal, false);
    }
    return status;
}

static enum vw_status check_config(const struct vw_config *config, const struct vw_effect_decision *decisions,
                                   uint32_t count) {
    bool transient = vw_effects_is_on(decisions, count, "transient");
    if (vw_effects_is_on(decisions, count, "pose") && config->field != VW_FIELD_HASH)
        return vw_fail(VW_ERROR_USAGE, "--effects: pose needs --field hash, not %s", vw_field_name(config->field));
    if (transient && config->loss != VW_LOSS_L2)
        return vw_fail(VW_ERROR_USAGE, "--effects: transient weighs squared errors; it needs --loss l2, not %s",
                       vw_loss_name(config->loss));
    if (transient && config->consistency_weight > 0.0 && vw_effects_is_on(decisions, count, "appearance_encoder"))
        return vw_fail(VW_ERROR_USAGE,
                       "--consistency-weight: excludes the effect transient; use 0, or leave out transient or "
                       "appearance_encoder");
    return VW_OK;
}

enum vw_status vw_effects_follow_field(const struct vw_config *config, struct vw_effect_decision *decisions,
                                       uint32_t count) {
    enum vw_status status = follow_renderer(config, decisions, count);
    if (!status) status = check_config(config, decisions, count);
    for (uint32_t i = 0; i < count && !status; i++) {
        const struct vw_effect_conflict *conflicts = effects[i].conflicts;
        for (uint32_t c = 0; decisions[i].on && c < VW_EFFECT_CONFLICTS_MAX && conflicts[c].refusal && !status; c++)
            status = switch_off(config, decisions, count, conflicts[c].name, conflicts[c].refusal,
                                conflicts[c].refused_unnamed);
    }
    return status;
}

// Returns whether a lens has more than k1, k2, p1 and p2.
static bool any_rich_lens(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_camera *camera = &scene->views[i].camera;
        bool more_terms = camera->k3 != 0.0 || camera->k4 != 0.0 || camera->k5 != 0.0 || camera->k6 != 0.0;
        if (camera->lens == VW_LENS_FISHEYE || more_terms) return true;
    }
    return false;
}

void vw_effects_specialise(const struct vw_effect_decision *decisions, const struct vw_scene *scene,
                           struct vw_specialization *specialization) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        uint32_t on = decisions[i].on;
        if (effects[i].constant == HOST_ONLY) continue;
        memcpy((char *)specialization + effects[i].constant, &on, sizeof on);
    }
    if (specialization->effect_distortion && any_rich_lens(scene))
        specialization->effect_distortion = DISTORTION_ANY_LENS;
    if (specialization->effect_appearance)
        specialization->effect_appearance = scene->points_tell_exposures ? APPEARANCE_GIVEN : APPEARANCE_FITTED;
    if (!specialization->effect_background) return;
    specialization->background_red = scene->background[0];
    specialization->background_green = scene->background[1];
    specialization->background_blue = scene->background[2];
}

#include "effects.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "viewworth/memory.h"

// How far distortion moves an image corner, in pixels, at most over all photos.
static double distortion_shift_px(const struct vw_scene *scene) {
    double largest = 0.0;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_camera *camera = &scene->views[i].camera;
        if (!vw_camera_is_distorted(camera)) continue;
        for (int corner = 0; corner < 4; corner++) {
            double x_px = corner & 1 ? camera->width_px : 0.0, y_px = corner & 2 ? camera->height_px : 0.0;
            double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px, -(y_px - camera->centre_y_px) / camera->focal_y_px,
                                   -1.0};
            double moved_x_px, moved_y_px;
            if (vw_camera_project(camera, direction, &moved_x_px, &moved_y_px))
                largest = fmax(largest, hypot(moved_x_px - x_px, moved_y_px - y_px));
        }
    }
    return largest;
}

static double transparent_share(const struct vw_scene *scene) {
    uint32_t transparent = 0;
    for (uint32_t i = 0; i < scene->view_count; i++) transparent += scene->views[i].image.has_alpha;
    return scene->view_count ? (double)transparent / scene->view_count : 0.0;
}

// Evidence that is still to be measured: see evidence.c.
static double no_evidence(const struct vw_scene *scene) {
    (void)scene;
    return 0.0;
}

static const struct effect {
    const char *name, *meaning;
    double threshold;
    double (*evidence)(const struct vw_scene *scene);
    size_t constant; // offset of its switch in struct vw_specialization
} effects[] = {
    {"distortion", "largest shift of an image corner by lens distortion, px", 0.01, distortion_shift_px,
     offsetof(struct vw_specialization, effect_distortion)},
    {"background", "share of photos with transparent pixels", 0.01, transparent_share,
     offsetof(struct vw_specialization, effect_background)},
    {"sky", "TODO", 1.0, no_evidence, offsetof(struct vw_specialization, effect_sky)},
    {"unbounded", "TODO", 1.0, no_evidence, offsetof(struct vw_specialization, effect_unbounded)},
    {"appearance", "TODO", 1.0, no_evidence, offsetof(struct vw_specialization, effect_appearance)},
    {"appearance_code", "TODO", 1.0, no_evidence, offsetof(struct vw_specialization, effect_appearance_code)},
    {"occupancy", "TODO", 1.0, no_evidence, offsetof(struct vw_specialization, effect_occupancy)},
};
_Static_assert(VW_ARRAY_COUNT(effects) <= VW_EFFECT_COUNT_MAX, "more effects than verdicts");

static int find_effect(const char *name, size_t length) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++)
        if (strlen(effects[i].name) == length && !strncmp(effects[i].name, name, length)) return (int)i;
    return -1;
}

// One word of --effects: "name" and "+name" switch on, "-name" switches off.
static enum vw_status apply_word(const char *word, size_t length, struct vw_effect_verdict *verdicts) {
    bool on = word[0] != '-';
    size_t sign = word[0] == '-' || word[0] == '+';
    int effect = find_effect(word + sign, length - sign);
    if (effect < 0) {
        char known[256] = "";
        for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++)
            snprintf(known + strlen(known), sizeof known - strlen(known), " %s", effects[i].name);
        return vw_fail(VW_ERROR_USAGE, "--effects: \"%.*s\" is no effect; known are:%s", (int)length, word, known);
    }
    verdicts[effect].on = on;
    return VW_OK;
}

// auto | none | LIST | +a,-b : a list without signs means exactly these, signs change what the evidence calls for.
static enum vw_status apply_choice(const char *choice, struct vw_effect_verdict *verdicts) {
    if (!strcmp(choice, "auto")) return VW_OK;
    bool exactly = choice[0] != '+' && choice[0] != '-';
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects) && exactly; i++) verdicts[i].on = false;
    if (!strcmp(choice, "none")) return VW_OK;
    for (const char *word = choice;;) {
        size_t length = strcspn(word, ",");
        if ((word[0] != '+' && word[0] != '-') != exactly)
            return vw_fail(VW_ERROR_USAGE, "--effects: \"%s\" mixes names with and without + or -; use one form", choice);
        enum vw_status status = apply_word(word, length, verdicts);
        if (status != VW_OK || !word[length]) return status;
        word += length + 1;
    }
}

enum vw_status vw_effects_decide(const struct vw_scene *scene, const char *choice, struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX],
                                 uint32_t *count) {
    struct vw_effect_verdict decided[VW_EFFECT_COUNT_MAX] = {0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        double evidence = effects[i].evidence(scene);
        bool called_for = evidence >= effects[i].threshold;
        decided[i] = (struct vw_effect_verdict){.name = effects[i].name,
                                                .called_for = called_for,
                                                .evidence = evidence,
                                                .threshold = effects[i].threshold,
                                                .meaning = effects[i].meaning,
                                                .on = called_for};
    }
    enum vw_status status = apply_choice(choice, decided);
    if (status != VW_OK) return status;
    memcpy(verdicts, decided, sizeof decided);
    *count = VW_ARRAY_COUNT(effects);
    return VW_OK;
}

// Whether a lens needs more than k1, k2, p1 and p2.
static bool any_rich_lens(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_camera *camera = &scene->views[i].camera;
        bool more_terms = camera->k3 != 0.0 || camera->k4 != 0.0 || camera->k5 != 0.0 || camera->k6 != 0.0;
        if (camera->lens == VW_LENS_FISHEYE || more_terms) return true;
    }
    return false;
}

void effects_specialize(const struct vw_effect_verdict *verdicts, const struct vw_scene *scene, struct vw_specialization *specialization) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        uint32_t on = verdicts[i].on;
        memcpy((char *)specialization + effects[i].constant, &on, sizeof on);
    }
    if (specialization->effect_distortion && any_rich_lens(scene)) specialization->effect_distortion = DISTORTION_ANY_LENS;
    if (!specialization->effect_background) return;
    specialization->background_red = scene->background[0];
    specialization->background_green = scene->background[1];
    specialization->background_blue = scene->background[2];
}

#include "detect/decide.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "detect/evidence.h"
#include "detect/pilot_run.h"
#include "train/effects/registry.h"

// How an effect is detected: it is called for when its evidence reaches the threshold. Basic ones are decided first,
// since the rest of the evidence and the pilot run take them into account.
static const struct detector {
    const char *effect;
    double threshold;
    bool basic;
    enum vw_status (*evidence)(const struct survey *survey, double *evidence);
} detectors[] = {
    {"distortion", 0.01, true, evidence_distortion},
    {"background", 0.01, true, evidence_background},
    {"masks", 1e-9, true, evidence_masks},
    {"sky", 0.05, false, evidence_sky},
    {"unbounded", 4.0, false, evidence_unbounded},
    {"appearance", 0.05, false, evidence_appearance},
    {"appearance_code", 0.075, false, evidence_appearance_code},
    {"occupancy", 0.25, false, evidence_occupancy},
};

static const struct detector *find_detector(const char *effect) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(detectors); i++)
        if (strcmp(detectors[i].effect, effect) == 0) return &detectors[i];
    return NULL;
}

static const struct vw_effect_verdict *find_verdict(const struct vw_effect_verdict *verdicts, uint32_t count,
                                                    const char *name) {
    for (uint32_t i = 0; name && i < count; i++)
        if (strcmp(verdicts[i].name, name) == 0) return &verdicts[i];
    return NULL;
}

// 0 where another effect's verdict rules this one out, NaN where that verdict is unknown; else what the detector finds.
static enum vw_status measure_effect(const struct survey *survey, const struct effect *effect,
                                     const struct detector *detector, const struct vw_effect_verdict *verdicts,
                                     uint32_t count, double *evidence) {
    const struct vw_effect_verdict *required = find_verdict(verdicts, count, effect->requires),
                                   *conflict = find_verdict(verdicts, count, effect->conflicts);
    if (required && !required->called_for) *evidence = isnan(required->evidence) ? NAN : 0.0;
    else if (conflict && conflict->called_for) *evidence = 0.0;
    else return detector->evidence(survey, evidence);
    return VW_OK;
}

// The evidence of the basic effects, or of the others.
static enum vw_status measure(const struct survey *survey, bool basic, struct vw_effect_verdict *verdicts) {
    uint32_t count;
    const struct effect *effects = effects_get(&count);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && status == VW_OK; i++) {
        const struct detector *detector = find_detector(effects[i].name);
        if (!detector || detector->basic != basic) continue;
        status = measure_effect(survey, &effects[i], detector, verdicts, count, &verdicts[i].evidence);
        verdicts[i].threshold = detector->threshold;
        verdicts[i].called_for = verdicts[i].evidence >= detector->threshold;
    }
    return status;
}

// With the basic effects as they are decided, and no others.
static enum vw_status run_pilot(struct vw_gpu *gpu, const struct vw_scene *scene,
                                const struct vw_effect_verdict *decided, uint32_t count,
                                struct pilot_findings *findings) {
    struct vw_effect_verdict simulated[VW_EFFECT_COUNT_MAX];
    memcpy(simulated, decided, count * sizeof *decided);
    for (uint32_t i = 0; i < count; i++) {
        const struct detector *detector = find_detector(simulated[i].name);
        simulated[i].on &= detector && detector->basic;
    }
    return pilot_run(gpu, scene, simulated, count, findings);
}

enum vw_status vw_effects_decide(struct vw_gpu *gpu, const struct vw_scene *scene, const char *choice,
                                 struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX], uint32_t *count) {
    struct vw_effect_verdict decided[VW_EFFECT_COUNT_MAX];
    uint32_t decided_count;
    struct survey survey = {.scene = scene, .masks = true, .pilot = {.gain_spread = NAN, .empty_share = NAN}};
    vw_effects_list(decided, &decided_count);
    enum vw_status status = measure(&survey, true, decided);
    if (status == VW_OK) status = vw_effects_choose(choice, decided, decided_count);
    if (status != VW_OK) return status;
    survey.masks = vw_effects_is_on(decided, decided_count, "masks");
    if (gpu && effects_leave_to_evidence(choice) && scene->split_count[VW_SPLIT_TRAIN] > 0)
        status = run_pilot(gpu, scene, decided, decided_count, &survey.pilot);
    if (status == VW_OK) status = measure(&survey, false, decided);
    if (status == VW_OK) status = vw_effects_choose(choice, decided, decided_count);
    if (status != VW_OK) return status;
    memcpy(verdicts, decided, decided_count * sizeof *decided);
    *count = decided_count;
    return VW_OK;
}

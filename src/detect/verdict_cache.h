// Verdicts of pilots, kept from run to run: the same scene, pilots, device and version decide at once, with the same
// verdicts.
//
// A file per search in the user's cache folder (base/cache.h): a BLAKE2b-256 of its key and of what
// follows, in hex, a line end, and the verdicts as run.effects_json. A file that is damaged, of another key or not
// plausible counts as missing, and the pilots are made again. No cache is worth an error. Files are replaced as a
// whole, so that several programs may share the folder.
#ifndef VIEWWORTH_DETECT_VERDICT_CACHE_H
#define VIEWWORTH_DETECT_VERDICT_CACHE_H

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// Decides as vw_effects_decide() does, through the cache. Facts are always found anew.
enum vw_status vw_effects_decide_cached(struct vw_gpu *gpu, const struct vw_scene *scene,
                                        const struct vw_config *planned,
                                        struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX], uint32_t *count);

#endif

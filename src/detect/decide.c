#include "detect/decide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "detect/pilots.h"
#include "train/effects/field_box.h"
#include "train/effects/registry.h"

// ---- Facts ---------------------------------------------------------------------------------------------------------

static bool is_used(const struct vw_view *view) { return view->split == VW_SPLIT_TRAIN || view->split == VW_SPLIT_VAL; }

static double corner_shift_px(const struct vw_camera *camera, double x_px, double y_px) {
    double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px,
                           -(y_px - camera->centre_y_px) / camera->focal_y_px, -1.0};
    double moved_x_px, moved_y_px;
    if (!vw_camera_project(camera, direction, &moved_x_px, &moved_y_px)) return 0.0;
    return hypot(moved_x_px - x_px, moved_y_px - y_px);
}

// Returns the largest shift of a photo's corner by its lens, in pixels, over all photos. No photo resolves a hundredth
// of a pixel.
static double find_distortion(const struct vw_scene *scene) {
    double largest_px = 0.0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        if (!vw_camera_is_distorted(camera)) continue;
        for (int corner = 0; corner < 4; corner++)
            largest_px = fmax(largest_px, corner_shift_px(camera, corner & 1 ? camera->width_px : 0.0,
                                                          corner & 2 ? camera->height_px : 0.0));
    }
    return largest_px;
}

static bool has_alpha(const struct vw_view *view) { return view->image.has_alpha; }
static bool has_mask(const struct vw_view *view) { return view->has_mask; }

static double share(const struct vw_scene *scene, bool (*holds)(const struct vw_view *view)) {
    uint32_t count = 0, used = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!is_used(&scene->views[v])) continue;
        count += holds(&scene->views[v]);
        used++;
    }
    return used ? (double)count / used : 0.0;
}

// Returns the share of photos that have transparent pixels.
static double find_background(const struct vw_scene *scene) { return share(scene, has_alpha); }

// Returns the share of photos that have a mask file. Any share calls for the effect.
static double find_masks(const struct vw_scene *scene) { return share(scene, has_mask); }

// ---- Exposures -----------------------------------------------------------------------------------------------------

static const double NORMAL_95 = 1.645;

// Returns the gain in dB of an error that is smaller by `reduction`, and then at the level.
static double gain_of(double reduction) {
    return 10.0 * log10(1.0 + fmax(reduction, 0.0) / pow(10.0, -0.1 * PHOTOMETRIC_LEVEL_DB));
}

enum vw_status vw_photometric_measure(const struct vw_scene *scene, struct vw_photometric_evidence *evidence) {
    const struct vw_exposure *exposures = NULL;
    double reduction = 0.0, variance = 0.0;
    *evidence = (struct vw_photometric_evidence){.gain_db = NAN, .stderr_db = NAN, .low_db = NAN};
    enum vw_status status = vw_scene_estimate_exposures(scene, &exposures);
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        const struct vw_exposure *exposure = &exposures[v];
        if (!isfinite(exposure->reduction_stderr)) continue;
        reduction += exposure->error_without - exposure->error_with;
        variance += pow(exposure->reduction_stderr, 2.0);
        evidence->observation_count += exposure->observation_count;
        evidence->photo_count++;
    }
    if (status || !evidence->photo_count) return status;
    double mean = reduction / evidence->photo_count, error = sqrt(variance) / evidence->photo_count;
    evidence->gain_db = gain_of(mean);
    evidence->stderr_db = gain_of(mean + error) - evidence->gain_db;
    evidence->low_db = gain_of(mean - NORMAL_95 * error);
    return VW_OK;
}

// ---- Extent --------------------------------------------------------------------------------------------------------

enum { CELLS = 8, POINTS_MIN = 64 }; // along the sides of a photo; as for the scene's box

static uint32_t cell_of(float place_px, uint32_t side_px) {
    float cell = place_px * CELLS / (float)side_px;
    return cell < 0.0f ? 0 : cell >= CELLS ? CELLS - 1 : (uint32_t)cell;
}

// Marks the cell of an observation and its neighbours.
static void mark(bool *cells, uint32_t column, uint32_t row) {
    for (uint32_t y = row ? row - 1 : 0; y <= row + 1 && y < CELLS; y++)
        for (uint32_t x = column ? column - 1 : 0; x <= column + 1 && x < CELLS; x++) cells[y * CELLS + x] = true;
}

static enum vw_status measure_bare(const struct vw_scene *scene, double *share) {
    bool *cells = vw_allocate((size_t)scene->view_count * CELLS * CELLS, sizeof *cells);
    uint32_t bare = 0, photos = 0;
    if (!cells) return VW_ERROR_MEMORY;
    for (uint32_t t = 0; t < scene->track_count; t++) {
        const struct vw_track *track = &scene->tracks[t];
        const struct vw_camera *camera = &scene->views[track->view].camera;
        mark(cells + (size_t)track->view * CELLS * CELLS, cell_of(track->x_px, camera->width_px),
             cell_of(track->y_px, camera->height_px));
    }
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split != VW_SPLIT_TRAIN) continue;
        for (uint32_t i = 0; i < CELLS * CELLS; i++) bare += !cells[(size_t)v * CELLS * CELLS + i];
        photos++;
    }
    free(cells);
    *share = photos ? (double)bare / photos / (CELLS * CELLS) : 0.0;
    return VW_OK;
}

enum vw_status vw_point_evidence_find(const struct vw_scene *scene, struct vw_point_evidence *evidence) {
    struct vw_box inner;
    *evidence = (struct vw_point_evidence){.known = scene->point_count >= POINTS_MIN && scene->track_count};
    if (!evidence->known) return VW_OK;
    enum vw_status status = vw_contraction_box(scene, NULL, 0, &inner);
    if (!status) status = measure_bare(scene, &evidence->bare_share);
    if (status) return status;
    evidence->outside_share = (double)vw_scene_count_outside(scene, &scene->box) / scene->track_count;
    evidence->inner_share = inner.half_extent_world / scene->box.half_extent_world;
    return VW_OK;
}

static const double PRICE_DB = 0.1; // least gain of an effect
// With fewer observations outside the box, less of the photos without points, and an inner region that is nearly all of
// the box, nothing worth an effect lies beyond it.
static const double OUTSIDE_SHARE = 0.005, BARE_SHARE = 0.15, INNER_SHARE = 0.9;

// The measurement of a fact: it calls for its effect when it reaches the threshold.
static const struct detector {
    const char *effect;
    double threshold;
    double (*find)(const struct vw_scene *scene);
} facts[] = {
    {"distortion", 0.01, find_distortion},
    {"background", 0.01, find_background},
    {"masks", 1e-9, find_masks},
};

static const struct detector *find_fact(const char *effect) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(facts); i++)
        if (strcmp(facts[i].effect, effect) == 0) return &facts[i];
    return NULL;
}

// Judges appearance by the points that photos share, if the choice leaves it open.
static enum vw_status find_appearance(const struct vw_scene *scene, const char *choice,
                                      struct vw_effect_decision *decisions, uint32_t count) {
    struct vw_photometric_evidence evidence;
    struct vw_effect_decision *decision = vw_effects_find(decisions, count, "appearance");
    if (!scene->points_tell_exposures || !vw_effects_leave_to_evidence(choice) ||
        vw_effects_names(choice, "appearance"))
        return VW_OK;
    enum vw_status status = vw_photometric_measure(scene, &evidence);
    if (status) return status;
    decision->evidence = evidence.gain_db;
    decision->evidence_stderr = evidence.stderr_db;
    decision->evidence_low = evidence.low_db;
    decision->threshold = PRICE_DB;
    decision->called_for = evidence.low_db >= PRICE_DB;
    snprintf(decision->measured_on, sizeof decision->measured_on,
             "exposures, at %d dB, by %llu observations of points in %u train photos", PHOTOMETRIC_LEVEL_DB,
             (unsigned long long)evidence.observation_count, evidence.photo_count);
    return VW_OK;
}

enum vw_status vw_effects_find_facts(const struct vw_scene *scene, const char *choice,
                                     struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count) {
    struct vw_effect_decision decided[VW_EFFECT_COUNT_MAX];
    uint32_t decided_count;
    vw_effects_list(decided, &decided_count);
    for (uint32_t i = 0; i < decided_count; i++) {
        const struct detector *fact = find_fact(decided[i].name);
        if (!fact) continue;
        decided[i].evidence = decided[i].evidence_low = fact->find(scene);
        decided[i].threshold = fact->threshold;
        decided[i].called_for = decided[i].evidence >= fact->threshold;
        snprintf(decided[i].measured_on, sizeof decided[i].measured_on, "the scene's files");
    }
    enum vw_status status = find_appearance(scene, choice, decided, decided_count);
    if (!status) status = vw_effects_choose(choice, decided, decided_count);
    if (status) return status;
    memcpy(decisions, decided, decided_count * sizeof *decided);
    *count = decided_count;
    return VW_OK;
}

// ---- The search -----------------------------------------------------------------------------------------------------

struct search {
    struct vw_pilots pilots;
    struct vw_pilots_params params;
    struct vw_effect_decision *decisions;
    const struct vw_effect *effects;
    uint32_t count;
    uint32_t set;        // a bit for each effect that was chosen so far, by its place in the registry
    uint32_t candidates; // that may be added
    uint32_t doubts;     // candidates that seemed to gain in the last round, but not surely
    bool asks_photos;    // whether they differ in exposure: points do not tell
};

// Returns the place of an effect in the registry, the number of effects where it is not there.
static uint32_t place_of(const struct search *search, const char *name) {
    uint32_t place = 0;
    while (place < search->count && strcmp(search->effects[place].name, name) != 0) place++;
    return place;
}

static uint32_t bit_of(const struct search *search, const char *name) {
    uint32_t place = name ? place_of(search, name) : search->count;
    return place < search->count ? 1u << place : 0;
}

static uint32_t bits_of_conflicts(const struct search *search, const struct vw_effect *effect) {
    uint32_t bits = 0;
    for (uint32_t c = 0; c < VW_EFFECT_CONFLICTS_MAX; c++) bits |= bit_of(search, effect->conflicts[c].name);
    return bits;
}

static bool is_possible(const struct search *search, uint32_t effect) {
    const struct vw_effect *it = &search->effects[effect];
    if (!(search->candidates >> effect & 1) || search->set >> effect & 1) return false;
    if (search->set & bits_of_conflicts(search, it)) return false;
    for (uint32_t i = 0; i < search->count; i++) { // the other way round
        const struct vw_effect *on = &search->effects[i];
        if (!(search->set >> i & 1)) continue;
        if ((bits_of_conflicts(search, on) | bit_of(search, on->hides)) & 1u << effect) return false;
    }
    return true;
}

// Returns the effect that pilots called for and that changes nothing beside this one, as a bit. This one is richer and
// learns more slowly, so that a short training understates it: it takes the other's place unless it is surely worse.
static uint32_t replaced_by(const struct search *search, uint32_t effect) {
    return bit_of(search, search->effects[effect].hides) & search->set & search->candidates;
}

static void describe_measurement(struct vw_effect_decision *decision, const struct search *search, uint32_t effect,
                                 const struct vw_pilot_gain *gain) {
    const struct vw_pilots *pilots = &search->pilots;
    size_t room = sizeof decision->measured_on;
    int used = snprintf(decision->measured_on, room,
                        "%d x %u steps of %u rays on %u train photos, scored on %u of them held out; beside",
                        PILOT_FOLDS, pilots->steps, pilots->config.rays, pilots->photo_count, gain->photo_count);
    bool any = false;
    for (uint32_t i = 0; i < search->count && used >= 0 && (size_t)used < room; i++) {
        if (!(search->set >> i & 1)) continue;
        used += snprintf(decision->measured_on + used, room - (size_t)used, "%s%s", any ? ", " : " ",
                         search->effects[i].name);
        any = true;
    }
    const char *end = !any ? " no effect" : replaced_by(search, effect) ? ", taken unless surely worse" : "";
    if (used >= 0 && (size_t)used < room) snprintf(decision->measured_on + used, room - (size_t)used, "%s", end);
}

static void take_gain(const struct search *search, uint32_t effect, const struct vw_pilot_gain *gain) {
    struct vw_effect_decision *decision = &search->decisions[effect];
    decision->evidence = gain->mean_db;
    decision->evidence_stderr = gain->stderr_db;
    decision->evidence_low = gain->low_db;
    decision->threshold = PRICE_DB;
    decision->called_for = gain->low_db >= PRICE_DB;
    describe_measurement(decision, search, effect, gain);
}

// Judges the gain of an effect beside those chosen so far.
static struct vw_pilot_gain judge(const struct search *search, uint32_t effect) {
    const struct vw_pilot *without = vw_pilots_find(&search->pilots, search->set),
                          *with = vw_pilots_find(&search->pilots, search->set | 1u << effect);
    const struct vw_pilot_gain gain = vw_pilot_gain(&search->pilots, with, without);
    struct vw_effect_decision *decision = &search->decisions[effect];
    take_gain(search, effect, &gain);
    decision->ms_per_step = with->ms_per_step - without->ms_per_step;
    decision->device_bytes = (double)with->device_bytes - (double)without->device_bytes;
    return gain;
}

static enum vw_status make_pilots(struct search *search, const uint32_t *tried, uint32_t count) {
    uint32_t sets[VW_EFFECT_COUNT_MAX + 1];
    sets[0] = search->set;
    for (uint32_t i = 0; i < count; i++) sets[1 + i] = search->set | 1u << tried[i];
    return vw_pilots_make(&search->pilots, sets, 1 + count);
}

// Returns whether the effect waits until one beside which it is never called for has been tried: most often that one is
// chosen, and a pilot is saved.
static bool is_deferred(const struct search *search, uint32_t effect) {
    return bits_of_conflicts(search, &search->effects[effect]) & search->candidates & ~search->set;
}

static void add(struct search *search, uint32_t effect) {
    uint32_t replaced = replaced_by(search, effect);
    search->decisions[effect].called_for = true;
    search->set |= 1u << effect;
    search->set &= ~replaced;
    for (uint32_t i = 0; i < search->count; i++)
        if (replaced >> i & 1) search->decisions[i].called_for = false;
}

static double high_db(const struct vw_pilot_gain *gain) { return 2.0 * gain->mean_db - gain->low_db; }

static bool is_doubtful(const struct vw_pilot_gain *gain) { return gain->mean_db > 0.0 && gain->low_db < PRICE_DB; }

// Opens longer pilots, for the effects in doubt.
static enum vw_status lengthen(struct search *search, uint32_t steps) {
    search->candidates = search->doubts;
    search->params.steps = steps;
    return vw_pilots_open(&search->params, &search->pilots);
}

// Tries the effects, those that are deferred only on demand. Adds the one that gains most, if any is worth its price;
// *added tells.
static enum vw_status take_round(struct search *search, bool tries_deferred, bool *added) {
    uint32_t tried[VW_EFFECT_COUNT_MAX], count = 0, best = 0;
    double best_db = -INFINITY;
    *added = false;
    search->doubts = 0;
    for (uint32_t i = 0; i < search->count; i++)
        if (is_possible(search, i) && (tries_deferred || !is_deferred(search, i))) tried[count++] = i;
    enum vw_status status = count ? make_pilots(search, tried, count) : VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        struct vw_pilot_gain gain = judge(search, tried[i]);
        if (high_db(&gain) < 0.0) search->candidates &= ~(1u << tried[i]); // harms: not tried again
        if (is_doubtful(&gain)) search->doubts |= 1u << tried[i];
        double bound_db = replaced_by(search, tried[i]) ? high_db(&gain) : gain.low_db;
        if (!(bound_db > best_db)) continue;
        best_db = bound_db;
        best = tried[i];
    }
    *added = !status && best_db >= PRICE_DB;
    for (uint32_t i = 0; i < count && !status; i++) // until a later round has measured it beside the chosen one
        search->decisions[tried[i]].called_for = false;
    if (*added) add(search, best);
    return status;
}

// Adds effects until none is worth its price. Those in doubt are then tried once more, with longer pilots.
static enum vw_status run_search(struct search *search) {
    uint32_t longer = vw_pilot_steps_in_doubt(search->params.scene, search->params.planned);
    bool added = true;
    enum vw_status status = VW_OK;
    while (added && !status) {
        status = take_round(search, false, &added);
        if (!status && !added) status = take_round(search, true, &added);
        if (status || added || !search->doubts || search->params.steps == longer) continue;
        status = lengthen(search, longer);
        added = true;
    }
    return status;
}

// Judges appearance beside what was chosen, by what a gain and a bias of its own gain on each photo held out: 256 steps
// show that sooner than they show a better field.
static enum vw_status judge_fits(struct search *search) {
    if (!search->asks_photos) return VW_OK;
    enum vw_status status = make_pilots(search, NULL, 0);
    if (status) return status;
    const struct vw_pilot_gain gain =
        vw_pilot_gain_of_fits(&search->pilots, vw_pilots_find(&search->pilots, search->set));
    take_gain(search, place_of(search, "appearance"), &gain);
    return VW_OK;
}

// Rules out what lies beyond the box where the points say that nothing does.
static enum vw_status rule_out(const struct vw_scene *scene, struct search *search) {
    static const char *const beyond[] = {"sky", "unbounded", "wide_box"};
    struct vw_point_evidence points;
    enum vw_status status = vw_point_evidence_find(scene, &points);
    bool within = points.known && points.outside_share < OUTSIDE_SHARE && points.bare_share < BARE_SHARE &&
                  points.inner_share > INNER_SHARE;
    for (size_t i = 0; i < VW_ARRAY_COUNT(beyond) && !status && within; i++) {
        struct vw_effect_decision *decision = vw_effects_find(search->decisions, search->count, beyond[i]);
        if (!(search->candidates & bit_of(search, beyond[i]))) continue;
        search->candidates &= ~bit_of(search, beyond[i]);
        snprintf(
            decision->measured_on, sizeof decision->measured_on,
            "ruled out: %.1f %% of the observations of points lie outside the box, %.0f %% of the photos' area has "
            "no points",
            100.0 * points.outside_share, 100.0 * points.bare_share);
    }
    return status;
}

// Lists the effects that may be added: possible, not facts, and not named by --effects.
static enum vw_status list_candidates(const struct vw_scene *scene, const struct vw_config *planned,
                                      struct search *search) {
    struct vw_box wide;
    uint32_t candidates = 0;
    enum vw_status status = vw_wide_box(scene, &wide);
    if (status) return status;
    for (uint32_t i = 0; i < search->count; i++)
        if (!search->effects[i].on_request && !find_fact(search->effects[i].name) &&
            !vw_effects_names(planned->effects, search->effects[i].name) &&
            vw_effect_works_with(&search->effects[i], planned->field))
            candidates |= 1u << i;
    // If all photos have transparent pixels, these show the background of the scene.
    if (find_background(scene) >= 1.0) candidates &= ~bit_of(search, "sky");
    if (!(wide.half_extent_world > scene->box.half_extent_world)) candidates &= ~bit_of(search, "wide_box");
    search->candidates = candidates;
    search->asks_photos = is_possible(search, place_of(search, "appearance")) && !scene->points_tell_exposures;
    search->candidates &= ~bit_of(search, "appearance"); // never by what a short training with it gains
    return rule_out(scene, search);
}

// Returns an effect that is on and beside which this one is not.
static const struct vw_effect *find_rival(const struct search *search, uint32_t effect) {
    for (uint32_t i = 0; i < search->count; i++) {
        const struct vw_effect *on = &search->effects[i];
        uint32_t excluded = bits_of_conflicts(search, on) | bit_of(search, on->hides);
        bool excludes = excluded >> effect & 1 || bits_of_conflicts(search, &search->effects[effect]) >> i & 1;
        if (search->set >> i & 1 && excludes) return on;
    }
    return NULL;
}

// Names the rival of each effect that gained enough and was not chosen, since the gain alone would call for it.
static void explain_left_out(struct search *search) {
    for (uint32_t i = 0; i < search->count; i++) {
        struct vw_effect_decision *decision = &search->decisions[i];
        const struct vw_effect *rival = find_rival(search, i);
        size_t used = strlen(decision->measured_on);
        if (search->set >> i & 1 || !rival || !(decision->evidence_low >= decision->threshold)) continue;
        snprintf(decision->measured_on + used, sizeof decision->measured_on - used, "; %s was taken instead",
                 rival->name);
    }
}

static enum vw_status measure(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned,
                              struct vw_effect_decision *decisions, uint32_t count) {
    struct search search = {.decisions = decisions};
    search.effects = vw_effects_get(&search.count);
    for (uint32_t i = 0; i < count; i++) search.set |= (uint32_t)decisions[i].on << i;
    enum vw_status status = list_candidates(scene, planned, &search);
    if (status) return status;
    uint32_t fitted = bit_of(&search, "appearance") | bit_of(&search, "appearance_code");
    search.params = (struct vw_pilots_params){.gpu = gpu,
                                              .scene = scene,
                                              .planned = planned,
                                              .steps = vw_pilot_steps(scene, planned),
                                              .masks = vw_effects_obey_masks(scene, decisions, count),
                                              .fits = search.asks_photos || search.set & fitted};
    if (!search.candidates && !search.asks_photos) return VW_OK;
    status = vw_pilots_open(&search.params, &search.pilots);
    if (!status && search.candidates) status = run_search(&search);
    if (!status) explain_left_out(&search);
    return status ? status : judge_fits(&search);
}

bool vw_effects_need_pilots(const struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned) {
    bool enough = scene->split_count[VW_SPLIT_TRAIN] >= PILOT_FOLDS * PILOT_HELD_OUT_MIN;
    return gpu && planned->pilot_steps && enough && vw_effects_leave_to_evidence(planned->effects);
}

enum vw_status vw_effects_decide(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *planned,
                                 struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX], uint32_t *count) {
    struct vw_effect_decision decided[VW_EFFECT_COUNT_MAX];
    uint32_t decided_count;
    enum vw_status status = vw_effects_find_facts(scene, planned->effects, decided, &decided_count);
    if (!status && vw_effects_need_pilots(gpu, scene, planned))
        status = measure(gpu, scene, planned, decided, decided_count);
    if (!status) status = vw_effects_choose(planned->effects, decided, decided_count);
    if (status) return status;
    memcpy(decisions, decided, decided_count * sizeof *decided);
    *count = decided_count;
    return VW_OK;
}

// ---- Cost -----------------------------------------------------------------------------------------------------------

// Together, pilots look at no more than a tenth of the rays that the run trains on, where that leaves enough for a
// decision. Most searches make so many: a pilot without, one with each effect, and a second round.
enum { STEPS_LEAST = 256, STEPS_MOST = 1024, PILOTS_EXPECTED = 6 };
static const double SHARE = 0.1;

uint32_t vw_pilot_steps(const struct vw_scene *scene, const struct vw_config *planned) {
    double rays = (double)planned->epochs * scene->split_count[VW_SPLIT_TRAIN] * planned->rays;
    double steps = SHARE * rays / (PILOTS_EXPECTED * PILOT_FOLDS) / vw_pilots_config(planned, 0).rays;
    if (planned->pilot_steps != VW_PILOT_STEPS_AUTO) return planned->pilot_steps;
    return (uint32_t)fmin(fmax(steps, STEPS_LEAST), STEPS_MOST);
}

uint32_t vw_pilot_steps_in_doubt(const struct vw_scene *scene, const struct vw_config *planned) {
    uint32_t steps = vw_pilot_steps(scene, planned);
    uint64_t run_steps = (uint64_t)planned->epochs * scene->split_count[VW_SPLIT_TRAIN];
    bool may_double = planned->pilot_steps == VW_PILOT_STEPS_AUTO && 2 * (uint64_t)steps <= run_steps;
    return may_double ? 2 * steps : steps;
}

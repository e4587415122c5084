#include "detect/pilots.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/statistics.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "train/trainer_parts.h"
#include "train/training_pool.h"
#include "train/validation/measure_views.h"
#include "viewworth/log.h"

enum {
    HELD_OUT_EACH = 4, // one photo in so many
    PIXELS_PER_PHOTO = 256,
    TIMED_STEPS = 4,
    SCORED_STATES = 4, // the last four, each SCORED_EACH-th of the steps apart
    SCORED_EACH = 16,
};

static const double LEARNING_RATE = 1e-2; // above the hash grid's default, as so few steps have to go farther

// ---- What all pilots share ------------------------------------------------------------------------------------------

// Effects depend on the scene, and a small field shows them soonest. Of a hash grid four times the entries, 8 levels
// and twice the width told no more of drawn scenes. Its samples are those of a default run: without placed ones, all of
// space is undervalued.
static void shrink(struct vw_config *config, const struct vw_config *planned) {
    bool splats = config->field == VW_FIELD_SPLATS;
    uint32_t rays = splats ? PILOT_SPLAT_RAYS : PILOT_RAYS;
    config->rays = planned->rays < rays ? planned->rays : rays;
    if (splats) {
        config->splats = PILOT_SPLATS;
        config->ssim_weight = planned->ssim_weight;
        return;
    }
    config->levels = 6;
    config->log2_table = 12;
    config->width = 16;
    config->learning_rate = LEARNING_RATE;
}

struct vw_config vw_pilots_config(const struct vw_config *planned, uint32_t steps) {
    bool splats = planned->field == VW_FIELD_SPLATS;
    // With a seed of 0: runs of all seeds have the same decisions.
    struct vw_config config = vw_config_of_field(splats ? VW_FIELD_SPLATS : VW_FIELD_HASH);
    shrink(&config, planned);
    config.loss = planned->loss;
    config.huber_length = planned->huber_length;
    config.background = planned->background;
    memcpy(config.effects, planned->effects, sizeof config.effects);
    config.burn_in_epochs = 0;
    config.learning_rate_decay = 1.0;
    config.epochs = steps + TIMED_STEPS; // an epoch has at least one step
    return config;
}

// Divides evenly spaced photos: every fold holds out one in four, evenly spaced as well; no two folds the same one.
static void share_out(const uint32_t *views, uint32_t count, struct vw_pilots *pilots) {
    uint32_t photos = count < PILOT_PHOTOS_MAX ? count : PILOT_PHOTOS_MAX, held_out = photos / HELD_OUT_EACH;
    if (held_out < PILOT_HELD_OUT_MIN) held_out = PILOT_HELD_OUT_MIN;
    if (photos < PILOT_FOLDS * held_out) return;
    for (uint32_t f = 0; f < PILOT_FOLDS; f++) {
        struct vw_pilot_fold *fold = &pilots->folds[f];
        for (uint32_t i = 0; i < photos; i++) {
            uint32_t view = views[(uint64_t)i * count / photos], place = PILOT_FOLDS * fold->held_out_count + f;
            bool held = fold->held_out_count < held_out && i == (2 * place + 1) * photos / (2 * held_out * PILOT_FOLDS);
            if (held) fold->held_out[fold->held_out_count++] = view;
            else fold->train_views[fold->train_count++] = view;
        }
    }
    pilots->photo_count = photos;
}

enum vw_status vw_pilots_open(const struct vw_pilots_params *params, struct vw_pilots *pilots) {
    uint32_t *views = NULL, count = 0;
    *pilots = (struct vw_pilots){.gpu = params->gpu,
                                 .scene = params->scene,
                                 .config = vw_pilots_config(params->planned, params->steps),
                                 .steps = params->steps,
                                 .masks = params->masks,
                                 .fits = params->fits};
    enum vw_status status = vw_scene_list_views(params->scene, VW_SPLIT_TRAIN, &views, &count);
    if (!status) share_out(views, count, pilots);
    free(views);
    return status;
}

const struct vw_pilot *vw_pilots_find(const struct vw_pilots *pilots, uint32_t set) {
    for (uint32_t i = 0; i < pilots->made_count; i++)
        if (pilots->made[i].effects == set) return &pilots->made[i];
    return NULL;
}

// ---- Trainings ------------------------------------------------------------------------------------------------------

struct training {
    struct vw_pilot *pilot;
    uint32_t fold;       // also its seed
    uint32_t left;       // states to score
    double timed_from_s; // its share of the time when the timed steps began; NaN: they have not
    struct vw_trainer *trainer;
};

// The trainings of a call.
struct making {
    const struct vw_pilots *pilots;
    struct vw_training_device device;
    struct training trainings[PILOTS_MAX * PILOT_FOLDS];
    uint32_t count;
    uint64_t steps; // taken so far
    double told_s;  // when progress was last told
};

static enum vw_status create_trainer(const struct making *making, struct training *training) {
    const struct vw_pilots *pilots = making->pilots;
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    struct vw_config config = pilots->config;
    uint32_t count;
    vw_effects_list(effects, &count);
    for (uint32_t i = 0; i < count; i++) effects[i].on = training->pilot->effects >> i & 1;
    config.seed = training->fold;
    return vw_trainer_create(&(struct vw_trainer_params){.gpu = pilots->gpu,
                                                         .scene = pilots->scene,
                                                         .config = &config,
                                                         .train_views = pilots->folds[training->fold].train_views,
                                                         .train_view_count = pilots->folds[training->fold].train_count,
                                                         .effects = effects,
                                                         .effect_count = count,
                                                         .submissions = making->device.submissions},
                             &training->trainer);
}

static double share_of_state(double mse) { return isfinite(mse) ? vw_psnr_db(mse) / SCORED_STATES : NAN; }

// Adds the PSNR of one of the states that are scored.
static enum vw_status score(const struct vw_pilots *pilots, const struct training *training) {
    struct vw_view_error errors[PILOT_HELD_OUT_MAX];
    double plain_mse[PILOT_HELD_OUT_MAX];
    const struct vw_measured_field measured = {.field = vw_trainer_get_parts(training->trainer)->field,
                                               .scene = pilots->scene,
                                               .masks = pilots->masks,
                                               .fits = pilots->fits,
                                               .allows_blank = true,
                                               .plain_mse = plain_mse};
    const struct vw_pilot_fold *fold = &pilots->folds[training->fold];
    enum vw_status status = vw_measure_views(&measured, fold->held_out, fold->held_out_count, PIXELS_PER_PHOTO, errors);
    for (uint32_t i = 0; i < fold->held_out_count && !status; i++) {
        training->pilot->psnr_db[training->fold][i] += share_of_state(errors[i].mse);
        training->pilot->plain_psnr_db[training->fold][i] += share_of_state(plain_mse[i]);
    }
    return status;
}

// Lets a training go to the next state that is scored, and after the last one to the end of a few steps that are timed.
// Several late states are scored, since the very last one depends on the photos of its last few steps.
static void release(const struct vw_pilots *pilots, const struct training *training) {
    uint32_t left = training->left;
    uint64_t before_end = left ? (uint64_t)(left - 1) * (pilots->steps / SCORED_EACH) : 0;
    vw_trainer_stop_after(training->trainer, pilots->steps - before_end + (left ? 0 : TIMED_STEPS));
}

static void tell_progress(struct making *making) {
    if (vw_progress_is_due(&making->told_s))
        vw_log_info("effects: %" PRIu64 " of %u steps of %u trial runs", making->steps,
                    making->count * (making->pilots->steps + TIMED_STEPS), making->count);
}

static enum vw_status begin(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct making *making = context;
    struct training *training = &making->trainings[seat->place];
    (void)answer;
    tell_progress(making);
    enum vw_status status = create_trainer(making, training);
    if (!status) release(making->pilots, training);
    return status;
}

// Returns the training's share of the time. On a CPU the time of all its cores is counted, which other load on the
// machine changes less.
static double share_s(const struct vw_pilots *pilots, const struct vw_pool_seat *seat) {
    return vw_gpu_get_info(pilots->gpu)->kind == VW_GPU_CPU ? seat->cpu_s : seat->wall_s;
}

static enum vw_status advance(void *context, const struct vw_pool_seat *seat, bool *ended) {
    struct making *making = context;
    struct training *training = &making->trainings[seat->place];
    const struct vw_step_record *records;
    uint32_t count;
    if (!training->left && isnan(training->timed_from_s)) training->timed_from_s = share_s(making->pilots, seat);
    enum vw_status status = vw_trainer_advance(training->trainer, &records, &count);
    making->steps += count;
    tell_progress(making);
    if (status || count > 0) return status;
    *ended = !training->left;
    if (*ended) return VW_OK;
    status = score(making->pilots, training);
    training->left--;
    release(making->pilots, training);
    return status;
}

// Counts a trainer's bytes as those that it frees: the first one on a device also allocates memory that all share.
static enum vw_status end(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    struct making *making = context;
    struct training *training = &making->trainings[seat->place];
    double took_s = share_s(making->pilots, seat) - training->timed_from_s;
    uint64_t before = vw_gpu_buffer_bytes(making->pilots->gpu);
    vw_trainer_destroy(&training->trainer);
    training->pilot->device_bytes = before - vw_gpu_buffer_bytes(making->pilots->gpu);
    training->pilot->ms_per_step += 1e3 * took_s / TIMED_STEPS / PILOT_FOLDS;
    return status;
}

static enum vw_status run(struct making *making) {
    const struct vw_training_pool pool = {.devices = &making->device,
                                          .device_count = 1,
                                          .begin = begin,
                                          .advance = advance,
                                          .end = end,
                                          .context = making};
    making->device.gpu = making->pilots->gpu;
    enum vw_status status = vw_submissions_create(making->device.gpu, &making->device.submissions);
    if (!status) status = vw_training_pool_run(&pool, making->count);
    vw_submissions_destroy(&making->device.submissions);
    return status;
}

enum vw_status vw_pilots_make(struct vw_pilots *pilots, const uint32_t *sets, uint32_t count) {
    uint32_t made = pilots->made_count;
    // The first one tells at once, since it compiles shaders.
    struct making making = {.pilots = pilots, .told_s = made ? vw_now_s() : -INFINITY};
    for (uint32_t i = 0; i < count; i++) {
        if (vw_pilots_find(pilots, sets[i])) continue;
        if (made == PILOTS_MAX) return vw_fail(VW_ERROR_USAGE, "more than %d pilots", PILOTS_MAX);
        pilots->made[made] = (struct vw_pilot){.effects = sets[i]};
        for (uint32_t fold = 0; fold < PILOT_FOLDS; fold++)
            making.trainings[making.count++] = (struct training){
                .pilot = &pilots->made[made], .fold = fold, .left = SCORED_STATES, .timed_from_s = NAN};
        made++;
    }
    enum vw_status status = run(&making);
    if (!status) pilots->made_count = made;
    return status;
}

// ---- Differences ----------------------------------------------------------------------------------------------------

// Estimates the variance of the mean from all photos.
static double variance_of_photos(const double *gains, uint32_t count, double mean) {
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) sum += pow(gains[i] - mean, 2.0);
    return sum / (count - 1.0) / count;
}

// Estimates it from the means of the folds, whose trainings differ in their seed for all their photos alike.
static double variance_of_folds(const double *of_folds, double mean) {
    double sum = 0.0;
    for (uint32_t f = 0; f < PILOT_FOLDS; f++) sum += pow(of_folds[f] - mean, 2.0);
    return sum / (PILOT_FOLDS - 1.0) / PILOT_FOLDS;
}

typedef const double by_photo[PILOT_FOLDS][PILOT_HELD_OUT_MAX];

static struct vw_pilot_gain compare(const struct vw_pilots *pilots, by_photo with_db, by_photo without_db,
                                    bool trainings_differ) {
    struct vw_pilot_gain gain = {.mean_db = NAN, .stderr_db = NAN, .low_db = NAN};
    double gains[PILOT_FOLDS * PILOT_HELD_OUT_MAX], of_folds[PILOT_FOLDS], all = 0.0;
    for (uint32_t f = 0; f < PILOT_FOLDS; f++) {
        double sum = 0.0;
        uint32_t first = gain.photo_count;
        for (uint32_t i = 0; i < pilots->folds[f].held_out_count; i++) {
            double db = with_db[f][i] - without_db[f][i];
            if (!isfinite(db)) continue;
            gains[gain.photo_count++] = db;
            sum += db;
        }
        of_folds[f] = sum / (gain.photo_count - first);
        all += sum;
    }
    if (gain.photo_count < 2) return gain;
    gain.mean_db = all / gain.photo_count;
    double variance = variance_of_photos(gains, gain.photo_count, gain.mean_db);
    if (trainings_differ) variance = fmax(variance, variance_of_folds(of_folds, gain.mean_db));
    gain.stderr_db = sqrt(variance);
    double caution = trainings_differ ? 1.0 : vw_student_quantile_95(gain.photo_count - 1.0);
    gain.low_db = gain.mean_db - caution * gain.stderr_db;
    return gain;
}

struct vw_pilot_gain vw_pilot_gain(const struct vw_pilots *pilots, const struct vw_pilot *with,
                                   const struct vw_pilot *without) {
    return compare(pilots, with->psnr_db, without->psnr_db, true);
}

struct vw_pilot_gain vw_pilot_gain_of_fits(const struct vw_pilots *pilots, const struct vw_pilot *pilot) {
    return compare(pilots, pilot->psnr_db, pilot->plain_psnr_db, false);
}

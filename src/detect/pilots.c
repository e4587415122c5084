#include "detect/pilots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "gpu/compute.h"
#include "train/shared_submissions.h"
#include "train/trainer.h"
#include "train/validation/measure_views.h"

enum {
    HELD_OUT_EACH = 4, // one photo in so many
    PIXELS_PER_PHOTO = 256,
    TIMED_STEPS = 4,
    SCORED_STATES = 4, // the last four, each SCORED_EACH-th of the steps apart
    SCORED_EACH = 16,
};

static const double LEARNING_RATE = 1e-2; // above the default, as so few steps have to go farther

// ---- What all pilots share ------------------------------------------------------------------------------------------

// Effects depend on the scene, and a small hash grid shows them soonest: four times the entries, 8 levels and twice the
// width told no more of drawn scenes. Samples are those of a default run: without placed ones, all of space is
// undervalued.
struct vw_config vw_pilots_config(const struct vw_config *planned, uint32_t steps) {
    struct vw_config config = vw_config_default; // with a seed of 0: runs of all seeds have the same verdicts
    config.loss = planned->loss;
    config.huber_length = planned->huber_length;
    config.background = planned->background;
    memcpy(config.effects, planned->effects, sizeof config.effects);
    config.rays = planned->rays < PILOT_RAYS ? planned->rays : PILOT_RAYS;
    config.levels = 6;
    config.log2_table = 12;
    config.width = 16;
    config.burn_in_epochs = 0;
    config.learning_rate = LEARNING_RATE;
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

// ---- One training ---------------------------------------------------------------------------------------------------

struct training {
    struct vw_pilot *pilot;
    uint32_t fold; // also its seed
    struct vw_trainer *trainer;
};

static enum vw_status create_trainer(const struct vw_pilots *pilots, struct vw_submissions *submissions,
                                     struct training *training) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
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
                                                         .submissions = submissions},
                             &training->trainer);
}

static enum vw_status take_steps(struct vw_trainer *trainer) {
    const struct vw_step_record *records;
    uint32_t count = 1;
    enum vw_status status = VW_OK;
    while (!status && count > 0) status = vw_trainer_advance(trainer, &records, &count);
    return status;
}

static double share_of_state(double mse) { return isfinite(mse) ? vw_psnr_db(mse) / SCORED_STATES : NAN; }

// Adds the PSNR of one of the states that are scored.
static enum vw_status score(const struct vw_pilots *pilots, const struct training *training) {
    struct vw_view_error errors[PILOT_HELD_OUT_MAX];
    double plain_mse[PILOT_HELD_OUT_MAX];
    const struct vw_measured_field measured = {.field = vw_trainer_field(training->trainer),
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

// Times a few more steps, alone. On a CPU the time of all its cores is counted, which other load on the machine changes
// less.
static enum vw_status time_steps(const struct vw_pilots *pilots, const struct training *training) {
    bool cpu = vw_gpu_get_info(pilots->gpu)->kind == VW_GPU_CPU;
    double began_s = cpu ? vw_cpu_s() : vw_now_s();
    vw_trainer_stop_after(training->trainer, pilots->steps + TIMED_STEPS);
    enum vw_status status = take_steps(training->trainer);
    double took_s = (cpu ? vw_cpu_s() : vw_now_s()) - began_s;
    training->pilot->ms_per_step += 1e3 * took_s / TIMED_STEPS / PILOT_FOLDS;
    return status;
}

// ---- Several trainings ----------------------------------------------------------------------------------------------

// Runs a group and scores its last states, since the very last state depends on the photos of its last few steps.
static enum vw_status run_group(const struct vw_pilots *pilots, struct training *group, uint32_t count) {
    enum vw_status status = VW_OK;
    for (uint32_t left = SCORED_STATES; left > 0 && !status; left--) {
        uint64_t stop = pilots->steps - (uint64_t)(left - 1) * (pilots->steps / SCORED_EACH);
        for (uint32_t i = 0; i < count; i++) vw_trainer_stop_after(group[i].trainer, stop);
        for (uint32_t i = 0; i < count && !status; i++) status = take_steps(group[i].trainer);
        for (uint32_t i = 0; i < count && !status; i++) status = score(pilots, &group[i]);
    }
    for (uint32_t i = 0; i < count && !status; i++) status = time_steps(pilots, &group[i]);
    return status;
}

// Counts a trainer's bytes as those that it frees: the first one on a device also allocates memory that all share.
static void close_group(struct vw_gpu *gpu, struct training *group, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        uint64_t before = vw_gpu_buffer_bytes(gpu);
        vw_trainer_destroy(&group[i].trainer);
        group[i].pilot->device_bytes = before - vw_gpu_buffer_bytes(gpu);
    }
}

// Takes as many trainings as the first one says that the device takes at a time.
static enum vw_status make_group(const struct vw_pilots *pilots, struct training *trainings, uint32_t count,
                                 uint32_t *taken) {
    struct vw_submissions *submissions = NULL;
    uint32_t created = 0, together = 1;
    enum vw_status status = vw_submissions_create(pilots->gpu, &submissions);
    while (created < count && created < together && !status) {
        uint64_t before = vw_submissions_unshared_bytes(submissions, pilots->gpu);
        status = create_trainer(pilots, submissions, &trainings[created]);
        created += !status;
        if (created == 1)
            together = vw_trainers_together(vw_gpu_get_info(pilots->gpu),
                                            vw_submissions_unshared_bytes(submissions, pilots->gpu) - before);
    }
    if (!status) status = run_group(pilots, trainings, created);
    close_group(pilots->gpu, trainings, created);
    vw_submissions_destroy(&submissions);
    *taken = created;
    return status;
}

enum vw_status vw_pilots_make(struct vw_pilots *pilots, const uint32_t *sets, uint32_t count) {
    struct training trainings[PILOTS_MAX * PILOT_FOLDS];
    uint32_t wanted = 0, made = pilots->made_count;
    for (uint32_t i = 0; i < count; i++) {
        if (vw_pilots_find(pilots, sets[i])) continue;
        if (made == PILOTS_MAX) return vw_fail(VW_ERROR_USAGE, "more than %d pilots", PILOTS_MAX);
        pilots->made[made] = (struct vw_pilot){.effects = sets[i]};
        for (uint32_t fold = 0; fold < PILOT_FOLDS; fold++)
            trainings[wanted++] = (struct training){.pilot = &pilots->made[made], .fold = fold};
        made++;
    }
    enum vw_status status = VW_OK;
    for (uint32_t done = 0, taken = 0; done < wanted && !status; done += taken)
        status = make_group(pilots, trainings + done, wanted - done, &taken);
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

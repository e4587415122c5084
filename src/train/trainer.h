// The API of the trainer, for the rest of the program: it takes the steps of a training in submissions and hands out
// their records. A trainer never changes its scene and decides neither its views nor its effects.
#ifndef VIEWWORTH_TRAIN_TRAINER_H
#define VIEWWORTH_TRAIN_TRAINER_H

#include <stdbool.h>
#include <stdint.h>

#include "train/device_choices.h"
#include "train/shared_submissions.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

struct vw_trainer;

struct vw_trainer_params {
    struct vw_gpu *gpu;             // outlives the trainer
    const struct vw_scene *scene;   // outlives the trainer; its split val is not empty when `validate` is set
    const struct vw_config *config; // checked and copied; all parts of the trainer point to the copy
    const uint32_t *train_views;    // views to train on: scene indices, ascending; copied. NULL: the split train
    uint32_t train_view_count;
    // Train views that are left out: their steps are taken on the others, in turn, so that trainings with and
    // without a view have the same number of steps and the most in common. Scene indices, ascending; copied. Not all.
    const uint32_t *left_out_views;
    uint32_t left_out_count;
    const struct vw_effect_decision
        *effects; // needed; decided, recorded or listed decisions, in registry order; copied
    uint32_t effect_count;
    bool awaits_field;                       // vw_trainer_load_field() follows: nothing is estimated that the field has
    bool validate;                           // render the validation rays after every step (`value`), or not (`train`)
    const struct vw_device_choices *choices; // NULL: by the kind of device; for tests and benchmarks
    struct vw_submissions *submissions;      // shared by trainers that step together; outlives them. NULL: alone
    uint32_t steps_per_submission; // 0: chosen from the time that a step takes; does not change a bit of the result
};

// ---- Life ----------------------------------------------------------------------------------------------------------

enum vw_status vw_trainer_create(const struct vw_trainer_params *params, struct vw_trainer **trainer);
void vw_trainer_destroy(struct vw_trainer **trainer);

// ---- Steps ---------------------------------------------------------------------------------------------------------

// Runs one more submission of steps (the first call begins with step 0, the untrained field) and lends their records
// until the next call. count = 0 when the run is complete. Where submissions are shared, this takes along the next
// steps of all their trainers: set each of them up (checkpoint, stop) before any of them advances.
enum vw_status vw_trainer_advance(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count);
// Hands out what is in flight, as vw_trainer_advance() does, without submitting more. count = 0 when nothing is, and
// the state on the device is the one after the last step handed out.
enum vw_status vw_trainer_collect(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count);
// Takes no step beyond `step` until called again with a later one: once all up to it are handed out, vw_trainer_advance
// gives count = 0 as at the end of the run. To be called before a step beyond it was submitted: before the first
// advance, or after count = 0. Where a run is held changes no bit of its steps.
void vw_trainer_stop_after(struct vw_trainer *trainer, uint64_t step);

// Returns whether steps are submitted that were not handed out yet.
bool vw_trainer_in_flight(const struct vw_trainer *trainer);

// ---- What it trains ------------------------------------------------------------------------------------------------

// Returns epochs times train views. Steps run from 1 to this.
uint64_t vw_trainer_total_steps(const struct vw_trainer *trainer);
// Returns the last step of the epoch that `step` is in.
uint64_t vw_trainer_epoch_end(const struct vw_trainer *trainer, uint64_t step);
// Returns the decisions that the trainer follows, in registry order.
const struct vw_effect_decision *vw_trainer_effects(const struct vw_trainer *trainer, uint32_t *count);
// Returns the views validated on, in the order of vw_step_record.views: scene indices.
const uint32_t *vw_trainer_validation_views(const struct vw_trainer *trainer, uint32_t *count);

struct vw_run_exposure; // identity.h
// Lists the exposures that train photos of the scene are corrected by from the first step on; none without the effect
// appearance or without points. The caller frees the list; its names are the scene's.
enum vw_status vw_trainer_list_exposures(const struct vw_trainer *trainer, struct vw_run_exposure **exposures,
                                         uint32_t *count);

// Returns the identity of the run: the hash of scene, subset, config (without epochs), seed, effects that are on, the
// box that they choose and the exposures, whether every step is validated, shaders, version, device and driver.
enum vw_status vw_trainer_run_id(const struct vw_trainer *trainer, uint8_t run_id[VW_HASH_BYTES]);
void vw_trainer_subset_hash(const struct vw_trainer *trainer, uint8_t hash[VW_HASH_BYTES]); // hash of the train views
// Returns the box that the field sees with the effect unbounded or wide_box, borrowed; NULL without them.
const struct vw_box *vw_trainer_effect_box(const struct vw_trainer *trainer);
void vw_shader_hash(uint8_t hash[VW_HASH_BYTES]); // hash of all embedded shaders

struct vw_trainer_stats {
    uint64_t param_count, device_bytes;
    uint64_t clamped_count, nonfinite_steps, floored_steps;
    uint32_t val_rays; // actually taken and scored
};
void vw_trainer_get_stats(const struct vw_trainer *trainer, struct vw_trainer_stats *stats);

// The corrections of the train cameras by the effect pose so far: by turns, and by shifts in box edges. 0 without it.
struct vw_camera_corrections {
    double mean_deg, largest_deg, mean_edges, largest_edges;
};
enum vw_status vw_trainer_camera_corrections(const struct vw_trainer *trainer,
                                             struct vw_camera_corrections *corrections);

// ---- Files ---------------------------------------------------------------------------------------------------------

// Saves a checkpoint (decision 11): run_id, step, params and moments as a file, written next to its place, synced and
// moved there. Call when nothing is in flight (see vw_trainer_collect).
enum vw_status vw_trainer_save_checkpoint(struct vw_trainer *trainer, const char *path);
// Resumes from a checkpoint: the next step is the one after `*step`, and the records are those of an uninterrupted run.
// VW_ERROR_INPUT when the file is missing, damaged or of another run, VW_ERROR_USAGE when it is of a later step than
// `last_step`: the trainer is then untouched. Before the first advance only.
enum vw_status vw_trainer_load_checkpoint(struct vw_trainer *trainer, const char *path, uint64_t last_step,
                                          uint64_t *step);

// Saves the trained field as a file (OUT/field.vwf): config, box and params, so that it renders without the scene's
// photos.
enum vw_status vw_trainer_save_field(struct vw_trainer *trainer, const char *path);
// Loads it. VW_ERROR_INPUT when it is damaged or does not fit the trainer.
enum vw_status vw_trainer_load_field(struct vw_trainer *trainer, const char *path);

// Makes the bytes of a file that other programs draw (train/renderers/splats/splat_file.h), owned by the caller; NULL
// with another field than splats.
enum vw_status vw_trainer_make_splats(struct vw_trainer *trainer, uint32_t degree, void **data, size_t *size_bytes);

// ---- Views ---------------------------------------------------------------------------------------------------------

// Renders a whole view with bin-centre samples: rgb floats, width * height * 3, rows top to bottom, owned by the
// caller. Its photo is decoded, too.
enum vw_status vw_trainer_render(struct vw_trainer *trainer, uint32_t view, float **rgb);
// Renders the same with fewer pixels, at most the view's width and height: pixel (x, y) is the view's pixel in the
// middle of what it covers, ((2 x + 1) width / (2 size_px[0]), ...) rounded down.
enum vw_status vw_trainer_render_small(struct vw_trainer *trainer, uint32_t view, const uint32_t size_px[2],
                                       float **rgb);
// Renders what another camera sees: camera, camera_to_world and range of depths of `posed`, of which nothing else is
// read. An effect that sees a view by its photo sees it by that of `view`. `depth`: instead of rgb one float per pixel,
// the expected depth along the camera's axis in world units; 0 where a ray sees less than a hundredth of anything.
enum vw_status vw_trainer_render_posed(struct vw_trainer *trainer, uint32_t view, const struct vw_view *posed,
                                       bool depth, float **values);
// Renders `count` > 0 such cameras of the same size, one after another, each seen as the view at its place of `views`.
// Many small ones cost less so than one by one. `depth_share` > 0: depths, 0 where a ray sees no more than this share
// of anything; 0: rgb.
enum vw_status vw_trainer_render_poses(struct vw_trainer *trainer, const uint32_t *views, const struct vw_view *posed,
                                       uint32_t count, double depth_share, float **values);

// Measures how near the field comes to each of these views (scene indices): validation's passes, on all usable pixels,
// or on `pixels_max` of them spread evenly over a view that has more. Where validation fits a gain and a bias to the
// left half of a view and scores the right one, so does this. `errors` has one entry per view. Call when nothing is in
// flight (see vw_trainer_collect).
enum vw_status vw_trainer_measure_views(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count,
                                        uint32_t pixels_max, struct vw_view_error *errors);

// The same for all pixels of one view, which are handed out: as the field shows them, with the gain and bias that
// validation fits, and as the photo has them.
struct vw_whole_view {
    uint32_t width_px, height_px;
    float *rendered, *photo; // owned; rgb floats, rows top to bottom; not clamped to [0,1]
    uint8_t *counts;         // owned; by pixel: 1 for those that are usable and scored, else 0
    struct vw_view_error error;
};
// Measures a whole view, by the photo and camera of `sized`, the scene at another size, where its errors are NaN if no
// pixel is usable; NULL: by the trainer's scene, where that is a failure.
enum vw_status vw_trainer_measure_whole(struct vw_trainer *trainer, const struct vw_scene *sized, uint32_t view,
                                        struct vw_whole_view *whole);
void vw_whole_view_free(struct vw_whole_view *whole);

#endif

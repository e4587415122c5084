// The command lists that trainers submit. Trainers that share them take steps together: each records its own steps
// into the same submission, where the scheduler of src/gpu places them side by side, because they write no common
// buffer. So K trainings wait at as many barriers as one. Results are bit-identical to training alone.
#ifndef VIEWWORTH_TRAIN_SHARED_SUBMISSIONS_H
#define VIEWWORTH_TRAIN_SHARED_SUBMISSIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/status.h"

struct vw_device_photos; // device_photos.h
struct vw_scene;
struct vw_submission;
struct vw_trainer;

enum { VW_TRAINERS_TOGETHER_MAX = 16 };
enum { SUBMISSIONS_IN_FLIGHT = 2 }; // one runs while the host records the next and reads the last one's records

// A trainer, and what it is asked.
struct vw_submissions_member {
    struct vw_trainer *trainer;
    // Returns whether it can record steps into the submission `index` now: its steps of that submission are handed out,
    // and one is left that needs no look at the state before.
    bool (*has_steps)(const struct vw_trainer *trainer, uint32_t index);
    // Decodes the photos of these steps and brings them to a device that draws; a failure ends this trainer alone.
    void (*take_photos)(struct vw_trainer *trainer);
    void (*record_steps)(struct vw_trainer *trainer, uint32_t index, struct vw_submission *submission);
};

struct vw_submissions {
    struct vw_submission *submissions[SUBMISSIONS_IN_FLIGHT];
    bool in_flight[SUBMISSIONS_IN_FLIGHT]; // submitted, and not waited for
    double submitted_s[SUBMISSIONS_IN_FLIGHT], took_s[SUBMISSIONS_IN_FLIGHT];
    struct vw_submissions_member members[VW_TRAINERS_TOGETHER_MAX];
    uint32_t member_count;
    struct vw_device_photos *photos; // owned; NULL until a trainer draws on the device
    enum vw_status failure;          // that of any submission: it ends all of them
    struct vw_saved_error why;
};

// Creates submissions. `gpu` outlives them, and they outlive their trainers.
enum vw_status vw_submissions_create(struct vw_gpu *gpu, struct vw_submissions **submissions);
void vw_submissions_destroy(struct vw_submissions **submissions);

// Returns how many trainings to run together on a device: one on a CPU, whose cores a single training fills; otherwise
// as many of `bytes_each` as fit into half of its memory, up to VW_TRAINERS_TOGETHER_MAX.
uint32_t vw_trainers_together(const struct vw_gpu_info *device, uint64_t bytes_each);

// Returns the bytes of all live buffers of the device but the photos that its trainers share.
uint64_t vw_submissions_unshared_bytes(const struct vw_submissions *submissions, const struct vw_gpu *gpu);

// ---- For trainers ----

// Returns the photos of a scene that the device draws from, kept until the last trainer leaves; NULL where the host has
// to, since they do not fit or trainers of another scene have theirs there.
struct vw_device_photos *vw_submissions_take_photos(struct vw_submissions *submissions, struct vw_gpu *gpu,
                                                    const struct vw_scene *scene);

enum vw_status vw_submissions_join(struct vw_submissions *submissions, const struct vw_submissions_member *member);
// Waits for what is in flight, which the trainer may be part of.
void vw_submissions_leave(struct vw_submissions *submissions, const struct vw_trainer *trainer);
// Returns the failure that ended all submissions, with its message, or VW_OK.
enum vw_status vw_submissions_check(const struct vw_submissions *submissions);
// Submits the submission `index` with the next steps of every trainer that has some and no steps in that submission
// already.
enum vw_status vw_submissions_submit(struct vw_submissions *submissions, uint32_t index);
enum vw_status vw_submissions_wait(struct vw_submissions *submissions, uint32_t index);

#endif

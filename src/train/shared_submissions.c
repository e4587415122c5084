#include "train/shared_submissions.h"

#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "train/device_photos.h"
#include "viewworth/log.h"

// ---- Life -----------------------------------------------------------------------------------------------------------

enum vw_status vw_submissions_create(struct vw_gpu *gpu, struct vw_submissions **submissions) {
    struct vw_submissions *made = vw_allocate(1, sizeof *made);
    enum vw_status status = made ? VW_OK : VW_ERROR_MEMORY;
    for (int i = 0; i < SUBMISSIONS_IN_FLIGHT && !status; i++)
        status = vw_submission_create(gpu, &made->submissions[i]);
    if (status) vw_submissions_destroy(&made);
    else *submissions = made;
    return status;
}

void vw_submissions_destroy(struct vw_submissions **submissions) {
    struct vw_submissions *dying = *submissions;
    if (!dying) return;
    for (int i = 0; i < SUBMISSIONS_IN_FLIGHT; i++) vw_submission_destroy(&dying->submissions[i]); // waits
    vw_device_photos_destroy(&dying->photos);
    free(dying);
    *submissions = NULL;
}

uint64_t vw_submissions_unshared_bytes(const struct vw_submissions *submissions, const struct vw_gpu *gpu) {
    const struct vw_device_photos *photos = submissions->photos;
    return vw_gpu_buffer_bytes(gpu) - (photos ? vw_buffer_size_bytes(photos->buffer) : 0);
}

struct vw_device_photos *vw_submissions_take_photos(struct vw_submissions *submissions, struct vw_gpu *gpu,
                                                    const struct vw_scene *scene) {
    if (!submissions->member_count) vw_device_photos_destroy(&submissions->photos); // a trainer failed to join
    if (!submissions->photos && vw_device_photos_create(gpu, scene, &submissions->photos)) return NULL;
    return submissions->photos->scene == scene ? submissions->photos : NULL;
}

uint32_t vw_trainers_together(const struct vw_gpu_info *device, uint64_t bytes_each) {
    if (device->kind == VW_GPU_CPU) return 1;
    uint64_t fit = bytes_each ? device->memory_bytes / 2 / bytes_each : 1;
    if (fit > VW_TRAINERS_TOGETHER_MAX) return VW_TRAINERS_TOGETHER_MAX;
    return fit ? (uint32_t)fit : 1;
}

// ---- Submissions ----------------------------------------------------------------------------------------------------

// Keeps a failure. It fails all trainers that are in the submission, or will be: the next one that asks receives it,
// too.
static enum vw_status keep_failure(struct vw_submissions *submissions, enum vw_status status) {
    if (!status) return VW_OK;
    submissions->failure = status;
    submissions->why = vw_error_save();
    return status;
}

enum vw_status vw_submissions_check(const struct vw_submissions *submissions) {
    if (submissions->failure) vw_error_restore(&submissions->why);
    return submissions->failure;
}

static enum vw_status wait_for(struct vw_submissions *submissions, uint32_t index) {
    if (!submissions->in_flight[index]) return VW_OK;
    enum vw_status status = vw_submission_wait(submissions->submissions[index]);
    submissions->in_flight[index] = false;
    submissions->took_s[index] = vw_now_s() - submissions->submitted_s[index];
    return keep_failure(submissions, status);
}

enum vw_status vw_submissions_wait(struct vw_submissions *submissions, uint32_t index) {
    enum vw_status status = vw_submissions_check(submissions);
    return !status ? wait_for(submissions, index) : status;
}

enum vw_status vw_submissions_submit(struct vw_submissions *submissions, uint32_t index) {
    struct vw_submission *submission = submissions->submissions[index];
    bool recorded = false;
    enum vw_status status = vw_submissions_wait(submissions, index);
    for (uint32_t i = 0; i < submissions->member_count && !status; i++) {
        const struct vw_submissions_member *member = &submissions->members[i];
        if (member->has_steps(member->trainer, index)) member->take_photos(member->trainer);
    }
    for (uint32_t i = 0; i < submissions->member_count && !status; i++) {
        const struct vw_submissions_member *member = &submissions->members[i];
        if (!member->has_steps(member->trainer, index)) continue;
        if (!recorded) vw_submission_begin(submission);
        recorded = true;
        member->record_steps(member->trainer, index, submission);
    }
    if (!recorded) return status;
    submissions->submitted_s[index] = vw_now_s();
    status = vw_submission_submit(submission);
    submissions->in_flight[index] = !status;
    return keep_failure(submissions, status);
}

// ---- Trainers -------------------------------------------------------------------------------------------------------

enum vw_status vw_submissions_join(struct vw_submissions *submissions, const struct vw_submissions_member *member) {
    if (submissions->member_count == VW_TRAINERS_TOGETHER_MAX)
        return vw_fail(VW_ERROR_USAGE, "at most %d trainings can run together; lower --together",
                       VW_TRAINERS_TOGETHER_MAX);
    submissions->members[submissions->member_count++] = *member;
    return VW_OK;
}

void vw_submissions_leave(struct vw_submissions *submissions, const struct vw_trainer *trainer) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < SUBMISSIONS_IN_FLIGHT; i++) (void)wait_for(submissions, i); // its buffers are in use
    for (uint32_t i = 0; i < submissions->member_count; i++)
        if (submissions->members[i].trainer != trainer) submissions->members[kept++] = submissions->members[i];
    submissions->member_count = kept;
    if (!kept) vw_device_photos_destroy(&submissions->photos); // the scene may be closed next
}

#include "run/together.h"

#include "gpu/compute.h"
#include "run/run.h"

// The runs that are open, and where each is listed.
struct group {
    struct vw_run *runs[VW_SESSION_TRAININGS_MAX];
    uint32_t places[VW_SESSION_TRAININGS_MAX], count;
    struct vw_first_failure failure;
};

static uint64_t device_bytes(const struct vw_session *session) {
    const struct vw_session_device *device = &session->devices[0];
    return session->device_count ? vw_submissions_unshared_bytes(device->submissions, device->gpu) : 0;
}

static void open_run(const struct vw_together_params *params, uint32_t place, struct group *group) {
    uint32_t device_count = params->session->device_count;
    struct vw_run **run = &group->runs[group->count];
    enum vw_status status = params->open_run(params->context, place, device_count ? place % device_count : 0, run);
    group->places[group->count] = place;
    group->count += !status;
    vw_first_failure_note(&group->failure, status);
}

// Opens the runs and returns how many were tried. The first one shows how much of a device's memory each takes.
static uint32_t open_runs(const struct vw_together_params *params, uint32_t count, struct group *group) {
    uint32_t tried = 0, wanted = 1;
    uint64_t before = device_bytes(params->session);
    for (; tried < count && tried < wanted; tried++) {
        open_run(params, tried, group);
        if (!tried && group->count)
            wanted = vw_session_at_a_time(params->session, params->together, device_bytes(params->session) - before);
    }
    return tried;
}

enum vw_status vw_together_make(const struct vw_together_params *params, uint32_t count, uint32_t *made) {
    struct group group = {.count = 0};
    enum vw_status statuses[VW_SESSION_TRAININGS_MAX];
    *made = open_runs(params, count, &group);
    vw_first_failure_note(&group.failure, vw_runs_advance(group.runs, group.count, statuses));
    for (uint32_t i = 0; i < group.count; i++) {
        vw_first_failure_note(&group.failure,
                              params->finish(params->context, group.places[i], statuses[i], group.runs[i]));
        vw_run_close(&group.runs[i]);
    }
    return vw_first_failure_report(&group.failure);
}

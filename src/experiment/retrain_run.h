// Retraining the photos of a recorded run.
#ifndef VIEWWORTH_EXPERIMENT_RETRAIN_RUN_H
#define VIEWWORTH_EXPERIMENT_RETRAIN_RUN_H

#include "run/recorded/recorded_run.h"
#include "run/session.h"
#include "viewworth/value.h"

// Opens a session on devices (the first NULL: the run's), scene and effects of the run. Returns VW_ERROR_INPUT for a
// scene that has changed. Close it also after a failure, before the run, which owns the scene and the first device.
enum vw_status vw_session_open_recorded(struct vw_recorded_run *recorded, const struct vw_device_choice *devices,
                                        struct vw_session *session);
void vw_session_close_recorded(struct vw_session *session);
// Returns the run's config with the epochs that its steps took.
struct vw_config vw_config_of_retrainings(const struct vw_recorded_run *recorded, const struct vw_value_input *steps);
// Returns the first of 2^32 seeds without the run's own: trainings with that one would favour what its scores select.
// All retrainings, now or later, count from here.
uint64_t vw_first_seed_after(uint64_t own);

#endif

#include "detect/photometric.h"

#include <math.h>

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

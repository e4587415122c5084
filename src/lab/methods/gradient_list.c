#include "lab/methods/gradient_list.h"

const struct vw_gradient_method_row vw_gradient_methods[VW_GRADIENT_METHODS] = {
    [VW_GRADIENT_IN_RUN_FIRST] =
        {"in_run_shapley",
         "In-Run Data Shapley: what the steps on the photo change in validation PSNR, to first "
         "order",
         true, 3.2},
    [VW_GRADIENT_IN_RUN_SECOND] = {"in_run_shapley_second", "the same to second order", true, 3.2},
    [VW_GRADIENT_TRACIN] = {"tracin",
                            "TracIn at 10 checkpoints: minus the gradient of the photo's loss times that of validation "
                            "PSNR and the learning rate",
                            true, 2.5},
    [VW_GRADIENT_TRACIN_ADAM] = {"tracin_adam", "the same with the step that Adam takes in place of the gradient", true,
                                 2.5},
    [VW_GRADIENT_INFLUENCE] = {"influence",
                               "influence functions at the end of the run, by LiSSA with Gauss-Newton products", true,
                               3.6},
};

#include "step_bench.h"

#include "base/memory.h"

const struct step_case step_cases[] = {
    {"default sizes", .seed = 1},
    {"7 samples, padded rays, all dense", .seed = 2, .ray_lanes = 8, .samples = 7, .rays = 300, .width = 16,
     .features = 4, .levels = 2, .base_resolution = 4, .loss = VW_LOSS_L2, .optimizer = VW_OPTIMIZER_DENSE_ADAM,
     .random_background = true, .effects = "background"},
    {"48 samples, wide network, wide gradient", .seed = 3, .samples = 48, .rays = 16, .width = 64, .levels = 16,
     .loss = VW_LOSS_HUBER, .beta1 = 0.9, .wide = true, .as_on_gpus = true, .effects = "sky"},
    {"one entry per level", .seed = 4, .features = 4, .one_entry = true, .optimizer = VW_OPTIMIZER_SGD,
     .slice_parts = 32, .random_background = true, .effects = "distortion,background,sky"},
    {"small table, largest encoding", .seed = 5, .samples = 7, .rays = 256, .width = 64, .levels = 16, .features = 4,
     .log2_table = 8, .loss = VW_LOSS_L2, .optimizer = VW_OPTIMIZER_DENSE_ADAM, .beta1 = 0.8, .beta2 = 0.999,
     .wide = true, .effects = "distortion"},
    {"smallest network", .seed = 0x123456789abcdefu, .width = 16, .levels = 2, .log2_table = 8, .loss = VW_LOSS_HUBER,
     .huber_length = 0.3, .beta1 = 0.5, .as_on_gpus = true, .effects = "sky,visibility"},
    {"large weights, saturated densities", .seed = 7, .weight_scale = 10.0f, .effects = "background,sky"},
    {"large weights, one entry, wide", .seed = 8, .ray_lanes = 4, .weight_scale = 10.0f, .one_entry = true,
     .samples = 7, .rays = 256, .wide = true, .loss = VW_LOSS_L2},
    {"photos of their own exposure", .seed = 10, .loss = VW_LOSS_L2, .effects = "background,appearance,visibility"},
    {"photos with codes", .seed = 11, .samples = 16, .width = 64, .beta1 = 0.9, .loss = VW_LOSS_L2,
     .effects = "appearance_code"},
    {"photos with exposures and codes", .seed = 12, .rays = 300, .samples = 7, .width = 16, .levels = 4,
     .optimizer = VW_OPTIMIZER_DENSE_ADAM, .loss = VW_LOSS_HUBER, .effects = "appearance,appearance_code"},
    {"one sample per ray, half a workgroup of pairs", .seed = 9, .ray_lanes = 32, .samples = 1, .rays = 256,
     .levels = 1, .features = 4, .log2_table = 4, .width = 16, .effects = "background"},
    {"unbounded", .seed = 10, .loss = VW_LOSS_L2, .effects = "unbounded"},
    {"unbounded, distortion and background, 7 samples, wide gradient", .seed = 11, .ray_lanes = 2, .samples = 7,
     .rays = 256, .levels = 4, .features = 4, .width = 16, .wide = true, .effects = "distortion,background,unbounded"},
    {"48 samples", .seed = 12, .ray_lanes = 16, .samples = 48, .rays = 30, .levels = 6, .width = 16, .slice_parts = 4},
    {"all effects that may be together, but unbounded", .seed = 13, .levels = 4, .width = 16,
     .effects = "distortion,background,sky,appearance,appearance_code,visibility,masks"},
    {"pixels with features", .seed = 14, .width = 16, .effects = "sky,uncertainty"},
    {"pixels with features, squares", .seed = 15, .ray_lanes = 32, .rays = 300, .samples = 7, .width = 16, .levels = 4,
     .beta1 = 0.9, .beta_min = 0.05, .loss = VW_LOSS_L2, .effects = "background,appearance,uncertainty"},
};
const uint32_t step_case_count = VW_ARRAY_COUNT(step_cases);

// The options of published methods, for --preset. lab/results/published_methods.md says which facts each follows, and
// where it departs.
#include "cli/options.h"

static const struct {
    const char *name, *options;
} presets[VW_PRESET_COUNT] = {
    [VW_PRESET_NONE] = {"none", ""},
    // instant-ngp (Mueller et al., SIGGRAPH 2022): its configs/nerf/base.json
    [VW_PRESET_HASH] = {"hash", "field=hash levels=8 features=4 log2-table=19 base-resolution=16 growth=2 width=64 "
                                "rays=4096 samples=64 importance-samples=0 loss=huber lr=0.01 learning-rate-decay=1"},
    // 3-D Gaussian splatting (Kerbl et al., SIGGRAPH 2023), section 5 and appendix
    [VW_PRESET_SPLATS] = {"splats", "field=splats harmonics=3 loss=l1 ssim-weight=0.2"},
    // NeRF (Mildenhall et al., ECCV 2020), section 5.3
    [VW_PRESET_NERF] = {"nerf", "field=mlp mlp-depth=8 width=256 frequencies=10 rays=4096 samples=64 "
                                "importance-samples=128 coarse-network=own loss=l2 lr=0.0005 learning-rate-decay=0.1 "
                                "effects=-sky,-appearance,-appearance_code"},
    // NeRF-W (Martin-Brualla et al., CVPR 2021), as its PyTorch port nerf_pl
    [VW_PRESET_NERF_W] = {"nerf-w", "field=mlp mlp-depth=8 width=256 frequencies=10 rays=1024 samples=64 "
                                    "importance-samples=128 coarse-network=own loss=l2 lr=0.0005 "
                                    "learning-rate-decay=0.1 effects=+appearance_code,+transient,-appearance,-sky"},
    // HA-NeRF (Chen et al., CVPR 2022), as its code says
    [VW_PRESET_HA_NERF] = {"ha-nerf",
                           "field=mlp mlp-depth=8 width=256 frequencies=15 rays=1024 samples=64 importance-samples=64 "
                           "coarse-network=own loss=l2 lr=0.0005 learning-rate-decay=0.1 consistency-weight=0.001 "
                           "effects=+appearance_encoder,+visibility,-appearance,-appearance_code,-sky"},
    // The valuation of Cheimariotis et al. (CAIP 2025): 500 pixels of one photo a step, L1, the first epoch left out
    [VW_PRESET_PAPER] = {"paper", "field=mlp mlp-depth=4 width=128 rays=500 samples=32 importance-samples=32 "
                                  "val-rays=4096 loss=l1 lr=0.0005 burn-in=1 "
                                  "effects=+appearance_code,-appearance,-sky"},
};

const char *vw_option_preset_name(uint32_t preset) { return presets[preset].name; }
const char *vw_option_preset_options(enum vw_option_preset preset) { return presets[preset].options; }

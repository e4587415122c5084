// Made by scripts/lab/train_predictor on 12 scenes with 373 photos, with penalty 0.111.
// Spearman with worth on scenes left out: 0.55 in the mean.
// Without features of tracks, which know wrong poses of recipes. Scenes: scripts/lab/benchmark_scenes 777 12,
// 2026-11-23.
const struct vw_feature_weight vw_predictor[] = {
    {"brightness", 0.0364056},       {"contrast", 0.0400761},
    {"sharpness", -0.026736},        {"noise", 0.0832297},
    {"exposure_distance", 0.142787}, {"sfm_coverage", 0.112512},
    {"overlap_train", -0.0551611},   {"overlap_val", 0.0780552},
    {"nearest_ratio", -0.0104064},   {"nearest_angle_deg", -0.0025652},
    {"transport", -0.184013},        {"loss_first", 0.0255017},
    {"loss_late", -0.0377972},       {"loss_last", 0.0376743},
    {"loss_relative", -0.0377972},   {"loss_slope", -0.0207643},
    {"loss_change", 0.0392591},      {"credit_psnr_db", 0.480854},
    {"credit_l1", 0.0486843},
};

// Not fitted yet: scripts/train_predictor overwrites this. Until then no scorer takes it.
const struct vw_feature_weight vw_predictor[] = {
    {"loss_late", -1},
};

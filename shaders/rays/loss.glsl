// Photometric losses, value and slope from the same locals: of one channel's error, averaged over the channels by the
// caller.
#ifndef LOSS_GLSL
#define LOSS_GLSL

// Computes loss and slope. Huber's loss is quadratic below HUBER_LENGTH and linear above, where its slope is 1.
void loss_channel(float error, out float value, out float slope) {
    float size = abs(error);
    float linear_slope = error > 0.0 ? 1.0 : error < 0.0 ? -1.0 : error; // keeps NaN
    if (LOSS == LOSS_L2) {
        value = error * error;
        slope = 2.0 * error;
    } else if (LOSS == LOSS_HUBER) {
        bool quadratic = size < HUBER_LENGTH;
        value = quadratic ? 0.5 / HUBER_LENGTH * error * error : size - 0.5 * HUBER_LENGTH;
        slope = quadratic ? error / HUBER_LENGTH : linear_slope;
    } else {
        value = size;
        slope = linear_slope;
    }
}

// The curvature of the loss by an error, for Gauss-Newton products. A loss without curvature uses that of the
// pseudo-Huber loss sqrt(error^2 + edge^2).
const float L1_EDGE = 0.05;

float loss_curvature(float error) {
    float edge = LOSS == LOSS_HUBER ? HUBER_LENGTH : L1_EDGE, size = error / edge;
    float smooth_curvature = 1.0 / (edge * (1.0 + size * size) * sqrt(1.0 + size * size));
    return LOSS == LOSS_L2 ? 2.0 : smooth_curvature;
}

#endif

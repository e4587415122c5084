// Adam (Kingma and Ba, 2015) on four parameters at a time, or plain gradient descent. With beta1 = 0 there is no first
// moment: the step is this photo's own gradient (see src/experiment/README.md, "Why no momentum").
#ifndef ADAM_GLSL
#define ADAM_GLSL

// Returns Adam's epsilon: one quantum of the mean gradient, so that a gradient of a few quanta cannot blow up (decision
// 4).
float adam_epsilon() { return GRADIENT_QUANTUM * INVERSE_RAYS; }

// Returns 1 - beta^visits, without cancellation for the first visits.
float bias_correction(float beta, float log2_beta, uint visits) {
    if (visits == 1u) return 1.0 - beta;
    return 1.0 - exp2(float(visits) * log2_beta);
}

// Updates the moments and returns the amount to subtract from the parameters. `gradient` is that of the mean loss. The
// result is not finite if the gradient's square is not.
vec4 adam_step(vw_adam adam, vec4 gradient, uint visits, inout vec4 moment1, inout vec4 moment2) {
    if (OPTIMIZER == OPTIMIZER_SGD) return adam.learning_rate * gradient;
    moment2 = adam.beta2 * moment2 + (1.0 - adam.beta2) * gradient * gradient;
    vec4 direction = gradient;
    if (MOMENTUM != 0u) {
        moment1 = adam.beta1 * moment1 + (1.0 - adam.beta1) * gradient;
        direction = moment1 / bias_correction(adam.beta1, adam.log2_beta1, visits);
    }
    vec4 square = moment2 / bias_correction(adam.beta2, adam.log2_beta2, visits);
    vec4 by = adam.learning_rate * direction / (sqrt(square) + adam_epsilon());
    return finite(square) ? by : square; // an infinite square would silently hold its parameter in place for ever
}

#endif

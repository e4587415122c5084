#include "reference/reference.h"

#include <math.h>
#include <string.h>

#include "image/image.h"

// ---- Thumbnails -----------------------------------------------------------------------------------------------------

// Computes the mean of a function that is constant within pixels, by its integral up to each edge.
void reference_thumbnail(const struct vw_view *view, uint32_t first, uint32_t end, bool masks,
                         double thumbnail[THUMBNAIL_PIXELS][4]) {
    double width = end - first, height = view->image.height_px;
    memset(thumbnail, 0, THUMBNAIL_PIXELS * sizeof *thumbnail);
    for (uint32_t y = 0; y < view->image.height_px; y++)
        for (uint32_t x = first; x < end; x++) {
            float rgba[4];
            vw_image_pixel(&view->image, x, y, rgba);
            if (!(masks ? vw_view_keeps(view, x, y) : vw_view_can_use(view, x, y))) continue;
            for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
                double left = i % THUMBNAIL_SIDE * width / THUMBNAIL_SIDE,
                       top = i / THUMBNAIL_SIDE * height / THUMBNAIL_SIDE,
                       wide = fmin(left + width / THUMBNAIL_SIDE, x - first + 1.0) - fmax(left, x - first),
                       high = fmin(top + height / THUMBNAIL_SIDE, y + 1.0) - fmax(top, y),
                       share = fmax(wide, 0.0) * fmax(high, 0.0) * THUMBNAIL_PIXELS / (width * height) * rgba[3];
                for (int c = 0; c < 3; c++) thumbnail[i][c] += share * (2.0 * rgba[c] - 1.0);
                thumbnail[i][3] += share;
            }
        }
}

// ---- The network ----------------------------------------------------------------------------------------------------

enum { CHANNELS = 4 * ENCODER4 };

static uint32_t side_of(uint32_t layer) { return THUMBNAIL_SIDE >> layer; } // the input's side of convolution `layer`
static uint32_t inputs_of(uint32_t layer) { return layer ? CHANNELS : 4; }
static uint32_t first_of(uint32_t layer) { return 4 * (uint32_t[]){0, ENCODER_LAYER2, ENCODER_LAYER3}[layer]; }

// Returns the index of a weight of a matrix of 4x4 blocks, counted from the matrix's first weight.
static uint32_t weight_at(uint32_t in_count, uint32_t out, uint32_t in) {
    return 16 * (out / 4 * (in_count / 4) + in / 4) + 4 * (in % 4) + out % 4;
}
static uint32_t kernel_at(uint32_t layer, uint32_t tap, uint32_t out, uint32_t in) {
    return first_of(layer) + tap * CHANNELS * inputs_of(layer) + weight_at(inputs_of(layer), out, in);
}
static uint32_t bias_at(uint32_t layer, uint32_t out) {
    return first_of(layer) + ENCODER_TAPS * CHANNELS * inputs_of(layer) + out;
}
static uint32_t code_at(uint32_t out, uint32_t in) { return 4 * ENCODER_CODE + weight_at(CHANNELS, out, in); }
static uint32_t shift_at(uint32_t unit, uint32_t k) { return 4 * ENCODER_SHIFT + weight_at(REFERENCE_CODE, unit, k); }

// A product of a convolution: output, input and weight.
struct product {
    uint32_t to, from, weight;
};
typedef void product_visitor(void *context, const struct product *product);

static void visit(uint32_t layer, product_visitor *visitor, void *context) {
    uint32_t side = side_of(layer), inputs = inputs_of(layer);
    for (uint32_t y = 0; y < side; y += 2)
        for (uint32_t x = 0; x < side; x += 2)
            for (uint32_t tap = 0; tap < ENCODER_TAPS; tap++) {
                uint32_t from_x = x + tap % 3 - 1, from_y = y + tap / 3 - 1; // beyond 0: larger than any side
                if (from_x >= side || from_y >= side) continue;
                for (uint32_t out = 0; out < CHANNELS; out++)
                    for (uint32_t in = 0; in < inputs; in++)
                        visitor(context, &(struct product){(y / 2 * (side / 2) + x / 2) * CHANNELS + out,
                                                           (from_y * side + from_x) * inputs + in,
                                                           kernel_at(layer, tap, out, in)});
            }
}

struct layer_values {
    const double *network, *inputs, *d_outputs;
    double *outputs, *d_network, *d_inputs;
};

static void add_output(void *context, const struct product *p) {
    const struct layer_values *it = context;
    it->outputs[p->to] += it->network[p->weight] * it->inputs[p->from];
}

static void add_gradients(void *context, const struct product *p) {
    const struct layer_values *it = context;
    it->d_network[p->weight] += it->d_outputs[p->to] * it->inputs[p->from];
    if (it->d_inputs) it->d_inputs[p->from] += it->d_outputs[p->to] * it->network[p->weight];
}

static const double *inputs_to(const struct reference_photo_encoding *it, uint32_t layer) {
    return layer ? it->outputs[layer - 1] : it->thumbnail[0];
}

void reference_encode_photo(const double *network, uint32_t width, struct reference_photo_encoding *it) {
    for (uint32_t layer = 0; layer < ENCODER_LAYERS; layer++) {
        struct layer_values values = {
            .network = network, .inputs = inputs_to(it, layer), .outputs = it->outputs[layer]};
        uint32_t count = (uint32_t)REFERENCE_ENCODER_OUTPUTS >> 2 * layer;
        for (uint32_t i = 0; i < count; i++) it->outputs[layer][i] = network[bias_at(layer, i % CHANNELS)];
        visit(layer, add_output, &values);
        for (uint32_t i = 0; i < count; i++) it->outputs[layer][i] = fmax(it->outputs[layer][i], 0.0);
    }
    memset(it->mean, 0, sizeof it->mean);
    for (uint32_t i = 0; i < 16 * CHANNELS; i++) it->mean[i % CHANNELS] += it->outputs[2][i] / 16.0;
    for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
        it->code[k] = network[4 * ENCODER_CODE_BIAS + k];
        for (uint32_t in = 0; in < CHANNELS; in++) it->code[k] += network[code_at(k, in)] * it->mean[in];
    }
    for (uint32_t unit = 0; unit < width; unit++) {
        it->shift[unit] = 0.0;
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) it->shift[unit] += network[shift_at(unit, k)] * it->code[k];
    }
}

void reference_encode_photo_gradient(const double *network, uint32_t width, const struct reference_photo_encoding *it,
                                     const double *d_shift, double *d_network) {
    double d_code[REFERENCE_CODE] = {0};
    for (uint32_t unit = 0; unit < width; unit++)
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
            d_network[shift_at(unit, k)] += d_shift[unit] * it->code[k];
            d_code[k] += d_shift[unit] * network[shift_at(unit, k)];
        }
    reference_code_gradient(network, it, d_code, d_network, NULL);
}

void reference_code_gradient(const double *network, const struct reference_photo_encoding *it, const double *d_code,
                             double *d_network, double d_thumbnail[THUMBNAIL_PIXELS][4]) {
    static double d_outputs[ENCODER_LAYERS][REFERENCE_ENCODER_OUTPUTS];
    double d_mean[CHANNELS] = {0};
    memset(d_outputs, 0, sizeof d_outputs);
    if (d_thumbnail) memset(d_thumbnail, 0, THUMBNAIL_PIXELS * sizeof *d_thumbnail);
    for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
        d_network[4 * ENCODER_CODE_BIAS + k] += d_code[k];
        for (uint32_t in = 0; in < CHANNELS; in++) {
            d_network[code_at(k, in)] += d_code[k] * it->mean[in];
            d_mean[in] += d_code[k] * network[code_at(k, in)];
        }
    }
    for (uint32_t i = 0; i < 16 * CHANNELS; i++) d_outputs[2][i] = d_mean[i % CHANNELS] / 16.0;
    for (uint32_t layer = ENCODER_LAYERS; layer-- > 0;) {
        struct layer_values values = {.network = network,
                                      .inputs = inputs_to(it, layer),
                                      .d_outputs = d_outputs[layer],
                                      .d_network = d_network,
                                      .d_inputs = layer         ? d_outputs[layer - 1]
                                                  : d_thumbnail ? d_thumbnail[0]
                                                                : NULL};
        for (uint32_t i = 0; i < (uint32_t)REFERENCE_ENCODER_OUTPUTS >> 2 * layer; i++) {
            if (it->outputs[layer][i] <= 0.0) d_outputs[layer][i] = 0.0;
            d_network[bias_at(layer, i % CHANNELS)] += d_outputs[layer][i];
        }
        visit(layer, add_gradients, &values);
    }
}

// ---- Pictures of the consistency loss ------------------------------------------------------------------------------

// Returns the share of a thumbnail's pixel that one of the picture's covers along one axis.
static double share_of(uint32_t thumbnail_at, uint32_t picture_at, double side) {
    double begin = fmax(thumbnail_at / (double)THUMBNAIL_SIDE, picture_at / side),
           end = fmin((thumbnail_at + 1.0) / THUMBNAIL_SIDE, (picture_at + 1.0) / side);
    return fmax(end - begin, 0.0) * THUMBNAIL_SIDE;
}

static double area_share(uint32_t pixel, uint32_t cell, uint32_t side) {
    return share_of(pixel % THUMBNAIL_SIDE, cell % side, side) * share_of(pixel / THUMBNAIL_SIDE, cell / side, side);
}

void reference_picture_thumbnail(uint32_t side, const double (*colours)[3], double thumbnail[THUMBNAIL_PIXELS][4]) {
    memset(thumbnail, 0, THUMBNAIL_PIXELS * sizeof *thumbnail);
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++)
        for (uint32_t cell = 0; cell < side * side; cell++) {
            double share = area_share(i, cell, side);
            for (int c = 0; c < 3; c++) thumbnail[i][c] += share * (2.0 * colours[cell][c] - 1.0);
            thumbnail[i][3] += share;
        }
}

void reference_picture_gradient(uint32_t side, double d_thumbnail[THUMBNAIL_PIXELS][4], double (*d_colours)[3]) {
    memset(d_colours, 0, side * side * sizeof *d_colours);
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++)
        for (uint32_t cell = 0; cell < side * side; cell++)
            for (int c = 0; c < 3; c++) d_colours[cell][c] += 2.0 * area_share(i, cell, side) * d_thumbnail[i][c];
}

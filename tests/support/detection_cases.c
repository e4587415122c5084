#include "detection_cases.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "detect/decide.h"
#include "support/gpu_fixture.h"
#include "support/temporary_folder.h"
#include "train/effects/registry.h"
#include "viewworth/train.h"

// The parts of a recipe. Some shapes on a slab in a void (sparse), or a block that fills the box (full).
static const struct detection_case {
    bool exposure; // photos differ in exposure
    bool alpha;    // the void is transparent
    bool far;      // ground and towers up to 30 box edges away
    bool lens;     // radial and tangential distortion
    bool masks;    // passers-by and their masks
    bool sky;      // a bright gradient instead of the black void
    bool weather;  // the sun stands elsewhere in every photo
    bool full;
} cases[] = {
    {.full = true}, // calls for nothing at all
    {0},
    {.exposure = true},
    {.alpha = true},
    {.far = true},
    {.lens = true},
    {.masks = true},
    {.sky = true},
    {.exposure = true, .weather = true},
    {.exposure = true, .alpha = true},
    {.exposure = true, .far = true},
    {.exposure = true, .lens = true, .full = true},
    {.exposure = true, .masks = true},
    {.alpha = true, .lens = true},
    {.alpha = true, .masks = true},
    {.far = true, .sky = true},
    {.far = true, .lens = true, .masks = true},
    {.lens = true, .masks = true, .full = true},
    {.exposure = true, .alpha = true, .lens = true, .masks = true},
    {.exposure = true, .far = true, .lens = true, .masks = true, .sky = true, .weather = true},
};

// Returns whether a case has two or three effects at once: the quick tests have these alone or all together.
static bool is_pair(const struct detection_case *c) {
    int effects = c->exposure + c->alpha + c->far + c->lens + c->masks + c->sky + c->weather;
    return effects == 3 || (effects == 2 && !c->weather);
}

static bool is_true(const struct detection_case *c, const char *effect) {
    const struct {
        const char *name;
        bool holds;
    } ground_truths[] = {
        {"distortion", c->lens}, {"background", c->alpha}, {"masks", c->masks},         {"sky", c->sky},
        {"unbounded", c->far},   {"wide_box", c->far},     {"appearance", c->exposure},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(ground_truths); i++)
        if (!strcmp(ground_truths[i].name, effect)) return ground_truths[i].holds;
    fail_msg("effect %s has no ground_truth in tests/support/detection_cases.c", effect);
    return false;
}

// ---- The recipe -----------------------------------------------------------------------------------------------------

static const char sparse_shapes[] =
    "{\"kind\": \"box\", \"centre\": [0, 0, -0.55], \"half_extent\": [0.95, 0.95, 0.05], \"texture\": {\"kind\": "
    "\"checker\","
    " \"colour\": [0.75, 0.7, 0.6], \"second_colour\": [0.35, 0.45, 0.4], \"cell\": 0.38}},"
    "{\"kind\": \"sphere\", \"centre\": [0.35, 0.2, -0.1], \"radius\": 0.4, \"texture\": {\"kind\": \"stripes\","
    " \"colour\": [0.7, 0.35, 0.25], \"second_colour\": [0.6, 0.55, 0.3], \"cell\": 0.2}},"
    "{\"kind\": \"box\", \"centre\": [-0.4, -0.2, -0.2], \"half_extent\": [0.25, 0.25, 0.3], \"turn_deg\": 25, "
    "\"texture\":"
    " {\"kind\": \"noise\", \"colour\": [0.3, 0.5, 0.7], \"second_colour\": [0.5, 0.4, 0.3], \"cell\": 0.2}}";
static const char full_shapes[] =
    "{\"kind\": \"box\", \"centre\": [0, 0, 0], \"half_extent\": [0.95, 0.95, 0.95], \"texture\": {\"kind\": \"noise\","
    " \"colour\": [0.75, 0.7, 0.6], \"second_colour\": [0.3, 0.4, 0.5], \"cell\": 0.3}}";
static const char ground[] = ", {\"kind\": \"plane\", \"centre\": [0, 0, -0.62], \"radius\": 60, \"texture\": "
                             "{\"kind\": \"checker\", \"colour\": [0.5, 0.55, 0.4],"
                             " \"second_colour\": [0.4, 0.35, 0.3], \"cell\": 1.5}}";
static const char tower[] =
    ", {\"kind\": \"box\", \"centre\": [%g, %g, 3], \"half_extent\": [3, 3, %g], \"texture\": {\"kind\": \"noise\","
    " \"colour\": [0.6, 0.5, 0.4], \"second_colour\": [0.4, 0.3, 0.5], \"cell\": 2}}";

static void append(char **text, char *more) {
    char *longer = vw_format_text("%s%s", *text, more);
    free(*text);
    free(more);
    *text = longer;
}

static char *make_shapes(const struct detection_case *c) {
    static const double places[][2] = {{25, 0},  {22, 12},   {12, 22},   {0, 25},  {-12, 22}, {-22, 12},
                                       {-25, 0}, {-22, -12}, {-12, -22}, {0, -25}, {12, -22}, {22, -12}};
    char *shapes = vw_copy_text(c->full ? full_shapes : sparse_shapes);
    if (!c->far) return shapes;
    append(&shapes, vw_copy_text(ground));
    for (size_t i = 0; i < VW_ARRAY_COUNT(places); i++)
        append(&shapes, vw_format_text(tower, places[i][0], places[i][1], 4.0 + i % 3));
    return shapes;
}

static char *make_recipe(const struct detection_case *c, uint64_t seed) {
    char *shapes = make_shapes(c);
    char *text = vw_format_text(
        "{\"viewworth_recipe\": 1, \"seed\": %llu, \"image\": {\"width_px\": 48, \"height_px\": 36},"
        " \"box\": {\"centre\": [0, 0, 0], \"half_extent\": 1}, \"background\": %s,"
        " \"sun\": {\"direction\": [0.4, -0.6, 0.9], \"intensity\": 0.5, \"ambient\": 0.4%s}, \"shapes\": [%s],"
        " \"cameras\": [{\"path\": \"orbit\", \"centre\": [0, 0, 0], \"radius\": %s, \"elevation_deg\": %s, \"turns\": "
        "2, \"count\": 24,"
        " \"start_deg\": %llu, \"field_of_view_deg\": 50%s}]%s%s}",
        (unsigned long long)seed,
        c->sky     ? "\"sky\""
        : c->alpha ? "\"transparent\""
                   : "[0, 0, 0]",
        c->weather ? ", \"spread_deg\": 150" : "", shapes, c->full ? "4" : "2.6",
        c->far || c->sky ? "[5, 20]" : "[15, 45]", (unsigned long long)(40 * seed % 360),
        c->lens ? ", \"distortion\": {\"k1\": 0.08, \"p1\": 0.004}" : "",
        c->exposure ? ", \"exposure\": {\"gain\": 0.2}" : "",
        c->masks ? ", \"transients\": {\"share\": 0.6, \"size\": 0.08}" : "");
    free(shapes);
    return text;
}

static struct vw_scene *open_case(const struct detection_case *c, uint64_t seed) {
    char *folder = temporary_folder_create(), *text = make_recipe(c, seed);
    struct vw_scene_params params = {.path = temporary_file(folder, "recipe.json", text), .gpu = test_gpu()};
    struct vw_scene *scene = NULL;
    if (vw_scene_open(&params, &scene)) fail_msg("%s in\n%s", vw_error_message(), text);
    temporary_folder_remove(folder);
    free(text);
    return scene;
}

struct vw_scene *detection_plain_scene(void) {
    return open_case(&cases[0], 1);
}

struct vw_scene *detection_sky_scene(void) {
    return open_case(&(struct detection_case){.sky = true}, 1);
}

// ---- The check ------------------------------------------------------------------------------------------------------

struct confusion {
    uint32_t counts[2][2]; // [true][called for]
    double highest_off, lowest_on;
};

static void print_matrix(const struct vw_effect_decision *decisions, uint32_t count,
                         const struct confusion *confusions) {
    print_message("%-16s %6s %6s %6s %6s   %-12s %-12s %s\n", "effect", "right+", "right-", "false+", "false-",
                  "highest off", "lowest on", "threshold");
    for (uint32_t e = 0; e < count; e++) {
        const struct confusion *m = &confusions[e];
        print_message("%-16s %6u %6u %6u %6u   %-12.4g %-12.4g %g\n", decisions[e].name, m->counts[1][1],
                      m->counts[0][0], m->counts[0][1], m->counts[1][0], m->highest_off, m->lowest_on,
                      decisions[e].threshold);
    }
}

// Returns whether files and points tell, without pilots.
static bool is_certain(const char *effect) {
    return !strcmp(effect, "distortion") || !strcmp(effect, "background") || !strcmp(effect, "masks") ||
           !strcmp(effect, "appearance");
}

// Adds a decision; prints it when it is wrong.
static uint32_t evaluate(const struct vw_effect_decision *decision, bool ground_truth, size_t index, uint64_t seed,
                         struct confusion *confusion) {
    confusion->counts[ground_truth][decision->called_for]++;
    if (ground_truth && !(decision->evidence >= confusion->lowest_on)) confusion->lowest_on = decision->evidence;
    if (!ground_truth && decision->evidence > confusion->highest_off) confusion->highest_off = decision->evidence;
    if (decision->called_for == ground_truth) return 0;
    print_error("case %zu, seed %llu: %s is %scalled for: %g +- %g\n", index, (unsigned long long)seed, decision->name,
                decision->called_for ? "" : "not ", decision->evidence, decision->evidence_stderr);
    return is_certain(decision->name);
}

void detection_check(uint64_t first_seed, uint32_t seed_count, bool pilots) {
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    if (!pilots) config.pilot_steps = 0;
    struct confusion confusions[VW_EFFECT_COUNT_MAX];
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count = 0, mistakes = 0;
    const struct vw_effect *effects = vw_effects_get(&count);
    for (size_t e = 0; e < VW_EFFECT_COUNT_MAX; e++)
        confusions[e] = (struct confusion){.lowest_on = 1e9, .highest_off = 0.0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        if (is_pair(&cases[i]) && !test_is_full()) continue;
        for (uint64_t seed = first_seed; seed < first_seed + seed_count; seed++) {
            struct vw_scene *scene = open_case(&cases[i], seed);
            if (vw_effects_decide(test_gpu(), scene, &config, decisions, &count)) fail_msg("%s", vw_error_message());
            for (uint32_t e = 0; e < count; e++)
                if (!effects[e].on_request && (pilots || is_certain(effects[e].name)))
                    mistakes += evaluate(&decisions[e], is_true(&cases[i], decisions[e].name), i, seed, &confusions[e]);
            vw_scene_close(&scene);
        }
    }
    print_matrix(decisions, count, confusions);
    if (mistakes) fail_msg("%u mistakes", mistakes);
}

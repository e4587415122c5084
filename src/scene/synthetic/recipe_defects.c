// Decides which views are corrupted and how: the ground truth by which scores are evaluated.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "scene/synthetic/recipe_private.h"

const char *const vw_recipe_ground_truths[] = {"clean",    "noise",      "blur",       "occluder",
                                               "exposure", "wrong_pose", "striped_box"};

static const struct {
    double least, most;
} strengths[] = {
    // by enum vw_recipe_defect_kind
    {0, 0}, {1e-3, 1}, {1e-2, 64}, {1e-3, 0.95}, {1e-2, 100}, {1e-3, 180}, {1e-2, 1},
};

struct defect_reader {
    struct vw_recipe *recipe;
    const struct vw_scene *scene;
    uint32_t index; // index of the defect being read
};

static bool is_clean_train(const struct defect_reader *state, uint32_t view) {
    return state->scene->views[view].split == VW_SPLIT_TRAIN && !state->recipe->defects[view].kind;
}

static void corrupt_listed(struct vw_json_reader *reader, const json_t *views, const struct vw_recipe_defect *defect,
                           struct defect_reader *state) {
    if (!json_is_array(views)) vw_json_refuse(reader, "views", "expected an array of view indices");
    for (size_t i = 0; i < json_array_size(views) && !reader->status; i++) {
        const json_t *item = json_array_get(views, i);
        json_int_t view = json_is_integer(item) ? json_integer_value(item) : -1;
        if (view < 0 || view >= state->scene->view_count) {
            vw_json_refuse(reader, "views", "item %zu is not a view; give indices from 0 to %u", i,
                           state->scene->view_count - 1);
        } else if (!is_clean_train(state, (uint32_t)view)) {
            const char *what = state->recipe->defects[view].kind ? "corrupted already"
                                                                 : vw_split_name(state->scene->views[view].split);
            vw_json_refuse(reader, "views", "view %lld is %s; only clean train views can be corrupted", (long long)view,
                           what);
        } else {
            state->recipe->defects[view] = *defect;
        }
    }
}

static void corrupt_every(struct vw_json_reader *reader, int64_t every, const struct vw_recipe_defect *defect,
                          struct defect_reader *state) {
    int64_t clean = 0;
    for (uint32_t v = 0; v < state->scene->view_count && !reader->status; v++)
        if (is_clean_train(state, v) && ++clean % every == 0) state->recipe->defects[v] = *defect;
}

// Draws the clean train view with the smallest random number; -1: none.
static int64_t draw_view(const struct defect_reader *state) {
    int64_t drawn = -1;
    uint32_t smallest = UINT32_MAX;
    for (uint32_t v = 0; v < state->scene->view_count; v++) {
        uint32_t words[4];
        vw_random_words(state->recipe->seed, VW_RANDOM_RECIPE, state->index, v, VW_DRAW_CHOICE, words);
        if (!is_clean_train(state, v) || (drawn >= 0 && words[0] >= smallest)) continue;
        drawn = v;
        smallest = words[0];
    }
    return drawn;
}

static void corrupt_share(struct vw_json_reader *reader, double share, const struct vw_recipe_defect *defect,
                          struct defect_reader *state) {
    uint32_t train = 0;
    for (uint32_t v = 0; v < state->scene->view_count; v++) train += state->scene->views[v].split == VW_SPLIT_TRAIN;
    for (long left = lround(share * train); left > 0 && !reader->status; left--) {
        int64_t view = draw_view(state);
        if (view < 0) vw_json_refuse(reader, "share", "no clean train view is left to corrupt; lower the shares");
        else state->recipe->defects[view] = *defect;
    }
}

static void read_targets(struct vw_json_reader *reader, const json_t *object, const struct vw_recipe_defect *defect,
                         struct defect_reader *state) {
    const json_t *views = json_object_get(object, "views");
    bool by_every = json_object_get(object, "every"), by_share = json_object_get(object, "share");
    int64_t every = 1;
    double share = 0;
    if ((views != NULL) + by_every + by_share != 1)
        vw_json_refuse(reader, "", "give exactly one of views, every and share");
    vw_json_integer(reader, object, "every", 1, VW_RECIPE_VIEWS_MAX, &every);
    vw_json_number(reader, object, "share", 0, 1, &share);
    if (reader->status) return;
    if (views) corrupt_listed(reader, views, defect, state);
    else if (by_every) corrupt_every(reader, every, defect, state);
    else corrupt_share(reader, share, defect, state);
}

static void read_defect(struct vw_json_reader *reader, const json_t *object, void *context) {
    struct defect_reader *state = context;
    struct vw_recipe_defect defect = {.strength = NAN};
    int kind = -1;
    vw_json_check_keys(reader, object, "kind strength bias views every share");
    vw_json_word(reader, object, "kind", "noise blur occluder exposure wrong_pose striped_box", &kind);
    if (reader->status) return;
    defect.kind = (enum vw_recipe_defect_kind)(kind + 1);
    if (defect.kind != VW_DEFECT_EXPOSURE) vw_json_check_keys(reader, object, "kind strength views every share");
    vw_json_number(reader, object, "strength", strengths[defect.kind].least, strengths[defect.kind].most,
                   &defect.strength);
    vw_json_number(reader, object, "bias", -1, 1, &defect.bias);
    if (defect.kind == VW_DEFECT_BLUR) defect.strength /= state->recipe->downscale;
    read_targets(reader, object, &defect, state);
    state->index++;
}

void vw_recipe_read_defects(struct vw_json_reader *reader, const json_t *root, struct vw_recipe *recipe,
                            struct vw_scene *scene) {
    if (reader->status) return;
    recipe->defects = vw_allocate(scene->view_count, sizeof *recipe->defects);
    if (!recipe->defects) {
        reader->status = VW_ERROR_MEMORY;
        return;
    }
    struct defect_reader state = {.recipe = recipe, .scene = scene};
    if (json_object_get(root, "defects"))
        vw_json_each(reader, root, "defects", VW_RECIPE_DEFECTS_MAX, read_defect, &state);
    for (uint32_t v = 0; v < scene->view_count && !reader->status; v++) {
        scene->views[v].ground_truth = vw_copy_text(vw_recipe_ground_truths[recipe->defects[v].kind]);
        if (!scene->views[v].ground_truth) reader->status = VW_ERROR_MEMORY;
    }
}

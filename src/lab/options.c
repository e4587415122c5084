#include "lab/options.h"

#include "base/memory.h"
#include "experiment/comparison.h"
#include "lab/methods/gradient_list.h"
#include "lab/methods/registry.h"
#include "viewworth/train.h"

static const char *vary_choice(uint32_t choice) { return vw_vary_name((enum vw_vary)choice); }
static const char *background_choice(uint32_t choice) { return vw_background_name((enum vw_background_form)choice); }
static const char *optimizer_choice(uint32_t choice) { return vw_optimizer_name((enum vw_optimizer)choice); }

_Static_assert(sizeof(enum vw_vary) == sizeof(uint32_t) && sizeof(enum vw_optimizer) == sizeof(uint32_t) &&
                   sizeof(enum vw_background_form) == sizeof(uint32_t),
               "VW_OPTION_CHOICE stores 32 bits");

#define OPTION(type, field) VW_OPTION_FIELD(struct vw_lab_options, type, field)
#define CHOICE(field, name_of, last) OPTION(CHOICE, field), .choice_name = name_of, .choice_count = (uint32_t)(last) + 1
#define COMMON .common = true
#define DEFAULT(text) .default_text = text

const struct vw_option vw_lab_option_table[] = {
    {"vary", NULL,
     "Parts of a run that the seed varies: all of order, pixels and init, or one kind alone, where everything else "
     "uses --seed in all runs; validation: the validation pixels alone, which are the same in all runs otherwise; "
     "all,validation: each run has its own, so that their error does not count as agreement",
     VW_LAB_REPRODUCE, VW_SECTION_MAIN, CHOICE(common.config.vary, vary_choice, VW_VARY_ALL_VALIDATION), COMMON},
    {"paper", NULL, "Also compare the other scores that the paper discusses: revisit, last epoch, linear, exponential",
     VW_LAB_REPRODUCE, VW_SECTION_MAIN, OPTION(FLAG, evaluated.paper_methods)},
    {"halves", "N",
     "Number of random halves of the train photos that evaluate the scores, each trained on twice; 0: none; LDS needs "
     "at least 3",
     VW_LAB_TRADEOFF, VW_SECTION_MAIN, OPTION(COUNT, halves), VW_OPTION_RANGE(0, 10000), COMMON},
    {"subsets", "N|all",
     "Number of subsets of the train photos to train on, 8 to 10000: one half of them are random halves, the others "
     "have random sizes of 40 to 100 %; all: every subset of at most 10 photos, for exact Shapley and Banzhaf values",
     VW_LAB_BENCHMARK, VW_SECTION_MAIN, OPTION(TEXT, subsets), COMMON, DEFAULT("200"), .words = "all"},
    {"retraining-seeds", "K",
     "Number of trainings of each subset, one per seed; their mean is what scores should predict", VW_LAB_BENCHMARK,
     VW_SECTION_MAIN, OPTION(COUNT, retraining_seeds), VW_OPTION_RANGE(1, 8), COMMON},
    {"valued-seeds", "K", "Number of runs that are valued, one per seed", VW_LAB_BENCHMARK, VW_SECTION_MAIN,
     OPTION(COUNT, valued_seeds), VW_OPTION_RANGE(1, 8), COMMON},
    {"leave-one-out", NULL, "Also train without each photo in turn, with each retraining seed", VW_LAB_BENCHMARK,
     VW_SECTION_MAIN, OPTION(FLAG, leave_one_out), COMMON},
    {"worth-retrainings", "LIST",
     "Also evaluate worth (see viewworth worth) from so many retrainings, at most 6 numbers with commas between; these "
     "retrainings are not those that judge",
     VW_LAB_BENCHMARK, VW_SECTION_MAIN, OPTION(TEXT, worth_retrainings), COMMON, DEFAULT("none")},
    {"methods", "LIST|all",
     "Also evaluate methods of the literature, with commas between: by retrainings, "
     "which are not those that judge, " VW_RETRAINING_METHODS "; by gradients along the run, " VW_GRADIENT_METHOD_NAMES,
     VW_LAB_BENCHMARK | VW_LAB_REPRODUCE, VW_SECTION_MAIN, OPTION(TEXT, evaluated.methods), COMMON, DEFAULT("none"),
     .words = "all"},
    {"run-equivalents", "LIST",
     "Budgets of --methods, at most 12 with commas between, in trainings on all photos; N stands for the number of "
     "train photos, as in N/2 and 4N",
     VW_LAB_BENCHMARK | VW_LAB_REPRODUCE, VW_SECTION_MAIN, OPTION(TEXT, evaluated.run_equivalents), COMMON,
     DEFAULT("1,2,4,10,N,4N")},
    {"curves", "LIST|all|none|gain",
     "Methods with removal and addition curves, with commas between; gain: all methods, but only what leaving out the "
     "lowest 20 % of the photos gains",
     VW_LAB_BENCHMARK, VW_SECTION_MAIN, OPTION(TEXT, curves), DEFAULT("dv_psnr,ground_truth"),
     .words = "all none gain"},
    {"corrupt", "N", "Number of train photos to corrupt, each by one of five defects, as ground truth for scores",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(COUNT, common.scene.corrupt), VW_OPTION_RANGE(0, 1000000)},
    {"huber-length", "X", "Colour difference beyond which --loss huber is linear; colours reach from 0 to 1",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(REAL, common.config.huber_length)},
    {"beta-min", "X",
     "Least uncertainty of a colour with transient or uncertainty, a standard deviation; NeRF-W has 0.03",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(REAL, common.config.beta_min)},
    {"optimizer", NULL, "Optimiser; lazy-adam leaves grid entries without a gradient unchanged", VW_OPTIONS_TRAINING,
     VW_SECTION_TRAINING, CHOICE(common.config.optimizer, optimizer_choice, VW_OPTIMIZER_SGD)},
    {"background", NULL,
     "Colour seen through transparent train pixels: the scene's own, or a random one per ray and step",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     CHOICE(common.config.background, background_choice, VW_BACKGROUND_RANDOM)},
    {"lasting-rays", "N", "Rays of each step that the backward pass uses; fewer are faster", VW_OPTIONS_LASTING,
     VW_SECTION_SCORES, OPTION(COUNT, common.lasting.rays), VW_OPTION_RANGE(1, 65536), DEFAULT("all rays of a step"),
     .needs = "lasting"},
    {"same-state", "N", "Also score all photos by steps from the same N states of the field", VW_LAB_PROBES,
     VW_SECTION_MAIN, OPTION(COUNT, same_state), VW_OPTION_RANGE(1, 1000000)},
    {"lengthen", "PERCENT",
     "Also measure lasting credit: train on from the end of burn-in with the steps on one photo so much longer, and so "
     "much shorter, for each photo in turn",
     VW_LAB_PROBES, VW_SECTION_MAIN, OPTION(COUNT, lengthen_percent), VW_OPTION_RANGE(1, 100)},
    {"seeds", "K", "Number of runs, one per seed; seeds count up from --seed", VW_LAB_REPRODUCE, VW_SECTION_MAIN,
     OPTION(COUNT, common.seeds), VW_OPTION_RANGE(2, 50), COMMON},
    {"lasting", NULL,
     "Also compute lasting credit of every run: what the steps on a photo leave at its end (scores lasting_psnr "
     "and lasting_loss)",
     VW_LAB_BENCHMARK | VW_LAB_REPRODUCE, VW_SECTION_SCORES, OPTION(FLAG, common.lasting.wanted), COMMON},
};

const uint32_t vw_lab_option_count = VW_ARRAY_COUNT(vw_lab_option_table);

const struct vw_lab_options vw_lab_options_default = {
    .common = VW_OPTIONS_DEFAULT, .retraining_seeds = 2, .valued_seeds = 2, .halves = 24};

#include "cli/program.h"

#include "base/memory.h"
#include "batch/batch.h"
#include "experiment/sweep/configurations.h"
#include "scene/camera_path.h"

static const char *loss_choice(uint32_t choice) { return vw_loss_name((enum vw_loss)choice); }
static const char *field_choice(uint32_t choice) { return vw_field_name((enum vw_field)choice); }
static const char *coarse_network_choice(uint32_t choice) {
    return vw_coarse_network_name((enum vw_coarse_network)choice);
}
static const char *equal_choice(uint32_t choice) { return vw_equal_name((enum vw_equal)choice); }

_Static_assert(sizeof(enum vw_loss) == sizeof(uint32_t) && sizeof(enum vw_equal) == sizeof(uint32_t) &&
                   sizeof(enum vw_field) == sizeof(uint32_t) && sizeof(enum vw_coarse_network) == sizeof(uint32_t),
               "VW_OPTION_CHOICE stores 32 bits");

// ---- Presets --------------------------------------------------------------------------------------------------------

// The options of published methods, for --preset. lab/results/published_methods.md says which facts each follows, and
// where it departs.
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

static const char *preset_choice(uint32_t preset) { return presets[preset].name; }
const char *vw_option_preset_options(enum vw_option_preset preset) { return presets[preset].options; }

// ---- Options --------------------------------------------------------------------------------------------------------

#define OPTION(type, field) VW_OPTION_FIELD(struct vw_options, type, field)
#define RANGE VW_OPTION_RANGE
#define CHOICE(field, name_of, last) OPTION(CHOICE, field), .choice_name = name_of, .choice_count = (uint32_t)(last) + 1
#define COMMON .common = true
#define DEFAULT(text) .default_text = text
#define NEEDS(option) .needs = option

const struct vw_option vw_option_table[] = {
    // Results and inputs of a command.
    {"out", "FOLDER", "Folder for the results (required)",
     VW_OPTIONS_OUT | VW_OPTIONS_IMPORT | VW_OPTIONS_RUNS | VW_OPTIONS_BATCH | VW_OPTIONS_MERGE, VW_SECTION_MAIN,
     OPTION(TEXT, out), COMMON, .letter = 'o'},
    {"per-device", "N", "Number of processes at a time on each device", VW_OPTIONS_BATCH, VW_SECTION_MAIN,
     OPTION(COUNT, per_device), RANGE(1, 64), COMMON},
    {"together", "K", "Number of trainings at the same time on each device; it changes no result",
     VW_OPTIONS_RUNS | VW_OPTIONS_SELECT | VW_OPTIONS_WORTH | VW_OPTIONS_ONE_VALUE, VW_SECTION_MAIN,
     OPTION(COUNT, together), RANGE(1, 16), DEFAULT("1 on a CPU; on a GPU as many as fit into half of its memory")},
    {"devices", "LIST|all",
     "Vulkan devices that train at the same time, each an index or part of a name, with commas between; or all GPUs, "
     "or the CPU if there is no GPU. Results are the same on any number of devices of equal name and driver",
     VW_OPTIONS_BATCH | VW_OPTIONS_RUNS | VW_OPTIONS_SELECT | VW_OPTIONS_WORTH, VW_SECTION_MAIN, OPTION(TEXT, devices),
     COMMON, DEFAULT("the preferred device, or --device")},
    {"job", "K",
     "Run only job K, counted from 1 in the order of job, config and seed, and merge nothing; other processes may run "
     "other jobs into the same --out folder at the same time",
     VW_OPTIONS_BATCH, VW_SECTION_MAIN, OPTION(COUNT, job), RANGE(1, VW_JOBS_MAX)},
    {"slurm", NULL,
     "Submit the jobs that are not done to a Slurm cluster, as an array of batch --job K, the last of which merges; "
     "jobs that reach the time limit or are preempted resume. Partition, GPUs and time limit come from "
     "sbatch's variables, such as SBATCH_PARTITION, SBATCH_GPUS and SBATCH_TIMELIMIT",
     VW_OPTIONS_BATCH, VW_SECTION_MAIN, OPTION(FLAG, slurm), COMMON},
    {"resume", NULL, "Continue the run in --out, or extend it if --epochs is larger; start a new run if there is none",
     VW_OPTIONS_OUT, VW_SECTION_MAIN, OPTION(FLAG, resume), COMMON},
    {"to", "PATH", "File to write, or folder of frames; its extension says what, as explained above",
     VW_OPTIONS_VIEW | VW_OPTIONS_SELECT | VW_OPTIONS_REPORT | VW_OPTIONS_NEXT | VW_OPTIONS_CHECK, VW_SECTION_MAIN,
     OPTION(TEXT, to), COMMON},
    {"copy", "DIR",
     "Folder to make for other trainers, beside or instead of --to: the photos that select keeps and those that "
     "validate and test, or by check all, those off their pose where they were found; with their masks (Postshot wants "
     "them inverted: mogrify -negate) and maps of features, a COLMAP model and transforms.json",
     VW_OPTIONS_SELECT | VW_OPTIONS_CHECK, VW_SECTION_MAIN, OPTION(TEXT, copy), COMMON},
    {"view", "NAME|N",
     "Photo to render, or whose intrinsics --pose and --path take: its name, also without folder and extension, or its "
     "index among the validation photos",
     VW_OPTIONS_VIEW, VW_SECTION_MAIN, OPTION(TEXT, view), COMMON, DEFAULT("0")},
    {"depth", NULL,
     "Write also the expected depth of each pixel along the camera's axis, in units of the scene, 0 where nothing is "
     "seen: NAME_depth.exr beside NAME.png",
     VW_OPTIONS_VIEW, VW_SECTION_MAIN, OPTION(FLAG, depth), COMMON},
    {"pose", "NUMBERS",
     "Camera to render from: the 12 or 16 numbers of its camera-to-world matrix, rows first, in coordinates of the "
     "scene, with the camera's x to the right, y up, and its view along -z",
     VW_OPTIONS_VIEW, VW_SECTION_MAIN, OPTION(TEXT, pose), COMMON},
    {"path", "orbit|spiral|cameras|FILE",
     "Path of a camera to render frames along: orbit, a circle around the scene at the cameras' median distance and "
     "height; spiral, for scenes that all cameras face; cameras, through all cameras in the order of their names; or a "
     "file, a camera path of nerfstudio or a transforms.json, in coordinates of the scene",
     VW_OPTIONS_VIEW, VW_SECTION_MAIN, OPTION(TEXT, path), COMMON, .words = "orbit spiral cameras"},
    {"frames", "N", "Number of frames of orbit, spiral or cameras", VW_OPTIONS_VIEW, VW_SECTION_MAIN,
     OPTION(COUNT, frames), RANGE(1, VW_CAMERA_PATH_FRAMES_MOST), COMMON, NEEDS("path")},
    {"video", "FILE",
     "Video to make of the frames (.mp4 or .gif) at 30 frames a second, by the program ffmpeg; without it the frames "
     "alone are made",
     VW_OPTIONS_VIEW, VW_SECTION_MAIN, OPTION(TEXT, video), COMMON, NEEDS("path")},
    {"cameras", "FILE",
     "File to write the cameras to, coloured by rank of the recommended score (grey: not valued): .ply or .json",
     VW_OPTIONS_EXPORT, VW_SECTION_MAIN, OPTION(TEXT, cameras), COMMON},
    {"points", "FILE.ply", "File to write the scene's points with their colours to", VW_OPTIONS_EXPORT, VW_SECTION_MAIN,
     OPTION(TEXT, points), COMMON},
    {"count", "N", "Number of places to propose", VW_OPTIONS_NEXT, VW_SECTION_MAIN, OPTION(COUNT, proposals),
     RANGE(1, VW_CAMERA_PATH_FRAMES_MOST), COMMON},
    {"among", "FILE",
     "Poses to choose among: a transforms.json, or a camera path of nerfstudio, in coordinates of the scene. All are "
     "candidates, also copies of photos and poses inside matter",
     VW_OPTIONS_NEXT, VW_SECTION_MAIN, OPTION(TEXT, among), COMMON, DEFAULT("places around the cameras")},
    {"quick", NULL, "Keep photos by --rule without-outliers, without trainings that verify it", VW_OPTIONS_SELECT,
     VW_SECTION_MAIN, OPTION(FLAG, quick), COMMON},
    {"seeds", "K",
     "Number of trainings of each list (compare, select) or configuration (tradeoff), one per seed; seeds "
     "count up from --seed",
     VW_OPTIONS_SELECT | VW_OPTIONS_COMPARE | VW_OPTIONS_TRADEOFF, VW_SECTION_MAIN, OPTION(COUNT, seeds), RANGE(1, 50),
     COMMON, DEFAULT("3; for select 2")},
    {"rule", "RULE",
     "Photos to keep, without trainings that verify it: without-outliers, positive (above zero, as in the paper, which "
     "drops a third of a clean scene), significant (95 % interval above zero), not-harmful (interval not below zero), "
     "top:K, top:P%, drop:K or drop:P%",
     VW_OPTIONS_SELECT, VW_SECTION_MAIN, OPTION(TEXT, rule), COMMON,
     .words = "without-outliers positive significant not-harmful top: drop:"},
    {"list", "LIST",
     "Photos to train on (required, repeatable): all, without-outliers, positive, significant, not-harmful, top:K, "
     "top:P%, drop:P%, random, a file of names, a NeRF-W TSV, a transforms file, or SCORES.csv@LEAST, which keeps the "
     "photos with at least that score (CSV header: name,score)",
     VW_OPTIONS_COMPARE, VW_SECTION_MAIN, OPTION(TEXTS, lists), COMMON},
    {"scores", "OUT",
     "Result folder of the valued run whose scores positive, significant, not-harmful, top and drop use",
     VW_OPTIONS_COMPARE, VW_SECTION_MAIN, OPTION(TEXT, scores), COMMON},
    {"method", "NAME", "Scoring method that decides which photos are kept", VW_OPTIONS_SELECT | VW_OPTIONS_COMPARE,
     VW_SECTION_MAIN, OPTION(TEXT, method), COMMON,
     DEFAULT("worth_psnr, lasting_psnr or dv_psnr, the first that there is; of without-outliers train_fit, dv_psnr "
             "and dv_loss")},
    {"equal", NULL,
     "Quantity that is equal in trainings on different numbers of photos: steps, or epochs (as in the paper)",
     VW_OPTIONS_COMPARE, VW_SECTION_MAIN, CHOICE(equal, equal_choice, VW_EQUAL_EPOCHS), COMMON},
    {"parameters", "LIST", "Parameters to change, with commas between: " VW_SWEEP_PARAMETERS, VW_OPTIONS_TRADEOFF,
     VW_SECTION_MAIN, OPTION(TEXT, parameters), COMMON, DEFAULT("all")},
    {"expect", "HEAD", "Chain head that the ledger must have, as an earlier command printed it", VW_OPTIONS_VERIFY,
     VW_SECTION_MAIN, OPTION(TEXT, expect), COMMON},
    {"providers", "FILE.csv", "Table of who supplied each photo (CSV header: name,provider)",
     VW_OPTIONS_SCENE | VW_OPTIONS_VERIFY, VW_SECTION_SCENE, OPTION(TEXT, scene.providers), COMMON},
    {"replay", "N|all", "Train the first N steps again and compare every bit with the ledger", VW_OPTIONS_VERIFY,
     VW_SECTION_MAIN, OPTION(COUNT, replay_steps), RANGE(1, UINT32_MAX), COMMON, .all = true},
    {"payout", "AMOUNT",
     "Amount of money to divide among the photos in proportion to their worth where that is positive; a provider gets "
     "the sum over its photos. Needs retrainings that tell at least two photos apart",
     VW_OPTIONS_ONE_VALUE | VW_OPTIONS_WORTH, VW_SECTION_MAIN, OPTION(TEXT, payout), COMMON},
    {"retrainings", "M|all",
     "Number of retrainings on random subsets of the photos, including those that OUT already contains, from whose "
     "results each photo's worth is scored; 0: none, or for worth show what they say so far. verify makes the first M "
     "of them again and compares every bit",
     VW_OPTIONS_WORTH | VW_OPTIONS_ONE_VALUE | VW_OPTIONS_VERIFY, VW_SECTION_MAIN, OPTION(COUNT, retrainings),
     RANGE(0, UINT32_MAX), COMMON, .all = true},
    {"until-confidence", "R",
     "Stop before all retrainings are made once the lower end of the interval of worth's correlation with left-out "
     "retrainings reaches R, below 1; checked after every 8; 0: never",
     VW_OPTIONS_WORTH | VW_OPTIONS_ONE_VALUE, VW_SECTION_MAIN, OPTION(REAL, until_confidence), COMMON,
     NEEDS("retrainings")},
    {"no-thumbnails", NULL, "Leave the photos out of the report, for example if they must not be shared",
     VW_OPTIONS_THUMBNAILS, VW_SECTION_MAIN, OPTION(FLAG, report.no_thumbnails)},

    // The scene and its photos.
    {"format", "NAME", "Scene format: recipe, transforms, phototourism or colmap", VW_OPTIONS_SCENE, VW_SECTION_SCENE,
     OPTION(TEXT, scene.format), DEFAULT("the first that fits"), .words = "recipe transforms phototourism colmap"},
    {"pool", "all|list", "Photos of a PhotoTourism scene: all registered photos, or those that the TSV lists",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(TEXT, scene.pool), DEFAULT("all"), .words = "all list"},
    {"train", "FILE", "Photos to train on: a file with one name per line, or a NeRF-W TSV", VW_OPTIONS_SCENE,
     VW_SECTION_SCENE, OPTION(TEXT, scene.train_list), COMMON},
    {"val", "FILE", "Photos to validate on: a file with one name per line", VW_OPTIONS_SCENE, VW_SECTION_SCENE,
     OPTION(TEXT, scene.val_list), COMMON},
    {"test", "FILE|none", "Photos to keep for tests: a file with one name per line; none: they train, too",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(TEXT, scene.test_list), COMMON},
    {"splits", "FILE",
     "The splits.json of an earlier run, instead of --train, --val and --test: every photo stays in its split. Photos "
     "that it does not name train; near-duplicates of validation and test photos join those",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(TEXT, scene.splits), COMMON},
    {"masks", "FOLDER",
     "Masks of photos, before the scene's own: NAME.png for the photo images/NAME; white keeps a pixel. The folder "
     "masks of a valued run has those of what covers photos",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(TEXT, scene.masks), COMMON},
    {"val-weights", "FILE",
     "Weight of each validation photo in validation PSNR and L1, and so in the scores: a CSV file (header: "
     "name,weight). Photos that it does not name have weight 1",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(TEXT, scene.val_weights), COMMON, DEFAULT("those of --splits, or 1")},
    {"downscale", "auto|N",
     "Factor by which width and height of the photos are divided; auto: so that a training of the level sees each "
     "pixel often enough on a CPU, and on a GPU to 2 megapixels",
     VW_OPTIONS_SCENE, VW_SECTION_SCENE, OPTION(COUNT, scene.downscale), RANGE(1, 64), COMMON, DEFAULT("auto"),
     .zero = "auto", .words = "auto"},

    // The training.
    {"seed", "N", "Seed of photo order, pixels, jitter and initialisation", VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     OPTION(SEED, config.seed), COMMON},
    {"epochs", "N", "Number of epochs; each photo is trained on once per epoch", VW_OPTIONS_TRAINING,
     VW_SECTION_TRAINING, OPTION(COUNT, config.epochs), COMMON},
    {"burn-in", "N", "Number of first epochs that do not count for the scores", VW_OPTIONS_TRAINING | VW_OPTIONS_IMPORT,
     VW_SECTION_TRAINING, OPTION(COUNT, config.burn_in_epochs)},
    {"rays", "N", "Training rays per step; of splats pixels, of which large photos need more", VW_OPTIONS_TRAINING,
     VW_SECTION_TRAINING, OPTION(COUNT, config.rays)},
    {"samples", "N", "Samples per ray, at even distances", VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     OPTION(COUNT, config.samples)},
    {"importance-samples", "N",
     "Further samples per ray, placed where the --samples even ones show matter, like NeRF's fine samples; training "
     "and rendering then use only these; 0: none",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(COUNT, config.importance_samples)},
    {"coarse-network", NULL,
     "Network that places the --importance-samples: the field itself (shared), or with --field mlp a coarse network of "
     "the same shape that is trained with it, as in NeRF (own)",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     CHOICE(config.coarse_network, coarse_network_choice, VW_COARSE_NETWORK_OWN)},
    {"val-rays", "N", "Validation rays in total; every validation photo gets at least 32", VW_OPTIONS_TRAINING,
     VW_SECTION_TRAINING, OPTION(COUNT, config.val_rays)},
    {"loss", NULL, "Training loss", VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     CHOICE(config.loss, loss_choice, VW_LOSS_HUBER)},
    {"ssim-weight", "W",
     "Share of the training loss that is 1 - SSIM, of windows within the squares of pixels that a step of --field "
     "splats draws; the rest is --loss",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(REAL, config.ssim_weight)},
    {"consistency-weight", "X",
     "Weight of HA-NeRF's consistency loss for the effect appearance_encoder: a render with a photo's code must encode "
     "to that code again; HA-NeRF uses 0.001; 0: none",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(REAL, config.consistency_weight)},
    {"lr", "X", "Learning rate; of splats a factor", VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     OPTION(REAL, config.learning_rate)},
    {"learning-rate-decay", "X",
     "Share of --lr that is left after --decay-epochs; the rate falls by the same factor at every step, and stays "
     "afterwards",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(REAL, config.learning_rate_decay)},
    {"decay-epochs", "N", "Epochs over which the learning rate falls", VW_OPTIONS_TRAINING, VW_SECTION_TRAINING,
     OPTION(COUNT, config.decay_epochs), DEFAULT("those that are planned")},
    {"beta1", "X", "Momentum of Adam; at 0 a step credits only its own photo", VW_OPTIONS_TRAINING | VW_OPTIONS_IMPORT,
     VW_SECTION_TRAINING, OPTION(REAL, config.beta1)},
    {"effects", "auto|none|LIST|+a,-b",
     "Optional parts of image formation: those that the scene calls for (auto), none, exactly those of a list, or auto "
     "with some added (+) and removed (-)",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(EFFECTS, config.effects), COMMON, .words = "auto none"},
    {"pilot-steps", "N",
     "Steps of each short training that measures what an effect gains; 0: files and points alone decide",
     VW_OPTIONS_TRAINING, VW_SECTION_TRAINING, OPTION(COUNT, config.pilot_steps), RANGE(0, VW_PILOT_STEPS_MOST),
     DEFAULT("by the length of the run")},

    // Accuracy and time.
    {"budget", "TIME",
     "Time limit of the whole command, for example 90s, 10min or 1.5h. It chooses an accuracy level and epochs; "
     "explicit options override it, and --epochs is an upper limit",
     VW_OPTIONS_ONE_VALUE, VW_SECTION_TIME, OPTION(TEXT, budget), COMMON, DEFAULT("none")},
    {"accuracy", "NAME",
     "Accuracy level: draft, quick, standard or reference. It sets rays, val-rays and epochs, and of a volume also "
     "samples, importance-samples, levels, log2-table and width; explicit options override it",
     VW_OPTIONS_ONE_VALUE | VW_OPTIONS_COMPARE, VW_SECTION_TIME, OPTION(TEXT, accuracy), COMMON, DEFAULT("none"),
     .words = "draft quick standard reference"},
    {"profile", NULL, "Also measure the time of every GPU pass, trial runs included", VW_OPTIONS_ONE_RUN,
     VW_SECTION_TIME, OPTION(FLAG, profile)},

    // More scores.
    {"lasting", NULL,
     "Also compute lasting credit by a backward pass through the finished training: what the steps on a photo leave at "
     "its end (scores lasting_psnr and lasting_loss); verify makes the recorded pass again and compares every bit",
     VW_OPTIONS_ONE_VALUE | VW_OPTIONS_VERIFY, VW_SECTION_SCORES, OPTION(FLAG, lasting.wanted), COMMON},
    {"lasting-matrix", NULL,
     "Also compute lasting credit for the PSNR of each validation photo: matrix.csv has it, and select also "
     "tries lists by it. Each validation photo adds up to half the time of a backward pass",
     VW_OPTIONS_LASTING, VW_SECTION_SCORES, OPTION(FLAG, lasting.matrix), NEEDS("lasting")},
    {"no-gate", NULL,
     "Do not check lasting credit by six short trainings in which the steps on a photo are made longer",
     VW_OPTIONS_LASTING, VW_SECTION_SCORES, OPTION(FLAG, lasting.no_gate), NEEDS("lasting")},

    // The field.
    {"preset", NULL,
     "Options of a published method; explicit options override it, and it overrides --accuracy and --budget",
     VW_OPTIONS_TRAINING, VW_SECTION_FIELD, CHOICE(preset, preset_choice, VW_PRESET_PAPER)},
    {"field", NULL,
     "What is trained: a hash grid with two small networks, one deep network as in NeRF, or Gaussian splats; auto: "
     "splats, or the hash grid where other options ask for what splats lack",
     VW_OPTIONS_TRAINING, VW_SECTION_FIELD, CHOICE(config.field, field_choice, VW_FIELD_AUTO), COMMON},
    {"splats", "N",
     "Number of splats with --field splats; 0: one for each point of the scene that a train photo sees, but at "
     "least 8192; points have up to 16; with fewer points, splats begin where photos agree",
     VW_OPTIONS_TRAINING, VW_SECTION_FIELD, OPTION(COUNT, config.splats)},
    {"harmonics", "N", "Degree of the spherical harmonics of colours with --field splats", VW_OPTIONS_TRAINING,
     VW_SECTION_FIELD, OPTION(COUNT, config.harmonics)},
    {"initial", "FILE.ply",
     "Splats to begin from with --field splats, as many as the file has, in place of the scene's points; field.ply of "
     "a run, or of another trainer, in the scene's coordinates",
     VW_OPTIONS_ONE_RUN, VW_SECTION_FIELD, OPTION(TEXT, initial), DEFAULT("the points of the scene")},
    {"ply-degree", "N",
     "Least degree of the harmonics in field.ply, padded by zeros; 3 for programs that want 45 coefficients",
     VW_OPTIONS_ONE_RUN, VW_SECTION_FIELD, OPTION(COUNT, report.ply_degree), RANGE(0, 3)},
    {"levels", "N", "Number of levels of the hash grid", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.levels)},
    {"features", "N", "Number of features per grid entry", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.features)},
    {"log2-table", "N", "Entries per level of the hash grid, at most 2^N", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.log2_table)},
    {"mlp-depth", "N", "Number of layers of the trunk with --field mlp", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.mlp_depth)},
    {"frequencies", "N", "Number of frequencies at which --field mlp encodes positions", VW_OPTIONS_TRAINING,
     VW_SECTION_FIELD, OPTION(COUNT, config.frequencies)},
    {"base-resolution", "N", "Cells along each axis of the coarsest level", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.base_resolution)},
    {"growth", "X", "Ratio of the resolutions of successive levels", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(REAL, config.growth)},
    {"width", "N", "Number of neurons per hidden layer", VW_OPTIONS_TRAINING, VW_SECTION_FIELD,
     OPTION(COUNT, config.width)},

    // Options that most commands share.
    {"device", "gpu|cpu|N|NAME",
     "Vulkan device: the first GPU or CPU, an index, or part of a name, see viewworth devices", VW_OPTIONS_DEVICE,
     VW_SECTION_GENERAL, OPTION(TEXT, device), COMMON, DEFAULT("the preferred one")},
    {"memory", "SIZE",
     "Memory for decoded photos, for example 4GB or 512MiB; photos that need more are kept in a file in the cache "
     "folder, which changes no result",
     VW_OPTIONS_DEVICE, VW_SECTION_GENERAL, OPTION(TEXT, memory), DEFAULT("half of the machine's")},
    {"json", NULL, "Print the results as one JSON object", VW_OPTIONS_JSON, VW_SECTION_GENERAL, OPTION(FLAG, json),
     COMMON},
    {"quiet", NULL, "Print only results, warnings and errors", VW_OPTIONS_ALWAYS, VW_SECTION_GENERAL,
     OPTION(FLAG, quiet), COMMON},
    {"help", NULL, "Show the main options; help COMMAND shows all", VW_OPTIONS_ALWAYS, VW_SECTION_GENERAL,
     OPTION(FLAG, help), COMMON, .letter = 'h'},
};

const uint32_t vw_option_count = VW_ARRAY_COUNT(vw_option_table);

const struct vw_options vw_options_default = VW_OPTIONS_DEFAULT;

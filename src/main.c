// viewworth: what each photo is worth to a 3-D reconstruction. The table of its commands.
#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/program.h"

enum command_group { VALUE, USE, CHECK, COMPARE };

// clang-format off
#define NEEDS_SCENE_FOLDER "If the scene path was relative, run the command in the same folder as the training."

static const struct vw_program_command commands[] = {
    {VALUE, "devices", NULL, "List the Vulkan devices in order of preference", NULL,
     VW_OPTIONS_JSON, vw_command_devices},
    {VALUE, "info", "SCENE", "Show what a scene contains and which effects it calls for",
     "SCENE is one of: a folder with transforms*.json, with a COLMAP model, or with a NeRF-W list (.tsv) beside "
     "dense/; a transforms file; a recipe (.json).\n"
     "An effect is an optional part of image formation, for example a sky or lens distortion. A scene calls for an "
     "effect if its files tell so, or if short trainings with it gain more than 0.1 dB over others without. The "
     "command prints the gain with its standard error, and what a step costs more, for a run with these options.\n"
     "Lists photos with defects, as value does first. "
     "Also estimates, by a few steps on the device, what the commands that train take at every accuracy level.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_JSON, vw_command_info},
    {VALUE, "check", "SCENE", "Find what is wrong with photos, in seconds and without training",
     "Compares every photo with what nearby photos say that its pose should show: points of the scene, and places that "
     "photos show alike. Finds photos that are empty, turned, swapped, off their pose, of another focal length, "
     "copies, blurred (also by motion), brighter, darker or noisier than others of the same, or partly hidden by "
     "something that others do not show; and tracks that are few or do not fit their points. Prints each with its "
     "measure and what to do. Nothing is trained, and no device is needed except for a recipe.\n"
     "Photos of more than 4 megapixels are checked at a smaller size, or at --downscale. --to writes a table (.csv) of "
     "all photos with the evidence: in_place is the share of the points that a photo should show and shows there; "
     "stops, sharpness and noise are relative to photos of the same points. --copy copies the scene, with photos off "
     "their pose where they were found.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_CHECK | VW_OPTIONS_JSON, vw_command_check},
    {VALUE, "value", "SCENE",
     "Train a radiance field, one photo per step, and score what each photo is worth",
     "Writes to the --out folder: ledger.db (every step and every score), scores.csv, matrix.csv (what each train "
     "photo did for each validation photo), splits.json (who trains, validates and tests, for --splits of a later "
     "run), report.html, map.json and residuals.json (cameras and renders, for the report), field.vwf (the trained "
     "field), field.ply (the splats of --field splats, for other programs) and checkpoints. masks/ has a mask for each "
     "photo of a file that is partly covered by something that the others do not show. Also writes "
     "providers.csv if providers are known, payout.csv and payout_photos.csv with --payout if somebody is paid, and "
     "duplicates.csv if photos are near-duplicates.\n"
     "A score is the credit of a photo: how much the steps on it improved the validation photos. With --resume, a "
     "finished run is not trained again: the report and the tables are written again, except scores.csv.",
     VW_OPTIONS_OF_VALUE, vw_command_value},
    {VALUE, "batch", "JOBS.json", "Value many scenes, with several seeds and configurations, from one file",
     "JOBS.json: {\"defaults\": {\"epochs\": 16}, \"seeds\": [0, 1, 2], \"configs\": [{\"name\": \"draft\", "
     "\"options\": {\"accuracy\": \"draft\"}}], \"jobs\": [{\"name\": \"fox\", \"scene\": \"fox\", \"seeds\": [7], "
     "\"options\": {\"downscale\": 2}}]}. Every job is valued with every seed and config; only jobs, with name and "
     "scene, is required. Options are those of value without dashes; true sets one that takes no value. Those of a "
     "job override those of a config, which override the defaults. Scenes are relative to the file's folder, paths in "
     "options to the folder that the command runs in.\n"
     "Each job is a process of its own; one that fails does not stop the others. Leaves in the --out folder "
     "NAME/seed-K/ (NAME/CONFIG/seed-K/ with configs) as value does, with seed-K.log and seed-K.json beside it; "
     "merged.db (all ledgers), scores.csv and summary.csv (all jobs and their states) and "
     "report.html.\n"
     "With --devices, job i always runs on the device at place i modulo their number. Run the same command again to "
     "resume: jobs that are done are kept, jobs that failed are tried again.",
     VW_OPTIONS_BATCH | VW_OPTIONS_JSON, vw_command_batch},
    {VALUE, "worth", "OUT", "Retrain on subsets of the photos of a run, and score what each photo is worth",
     "OUT is the --out folder of value. The retrainings take as many steps as the run, each on 40 to 100 % of the "
     "photos and with a seed of its own; every eighth is on all photos. A regression over their results gives "
     "worth_psnr in dB: what a training on all photos loses without the photo; below 0 the photo harms. Where the "
     "results say little, worth follows the other scores. Names of providers change none of it.\n"
     "--payout divides an amount among the photos by their worth where that is positive. It prints a 90 % interval "
     "for each provider, and pays nobody if the retrainings tell no two photos apart.\n"
     "Prints how well left-out retrainings are predicted beyond what the number of photos tells: that is how far these "
     "scores can be trusted on this scene. Adds the retrainings to ledger.db and retrainings.db, and writes "
     "scores.csv, the tables and the report again. Run the same command again to resume it. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_WORTH | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON, vw_command_worth},
    {VALUE, "train", "SCENE", "Take the same training steps as value, without validation and scores",
     "Writes to the --out folder: ledger.db, field.vwf (the trained field), field.ply (the splats of --field splats, "
     "for other programs) and checkpoints.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_ONE_RUN | VW_OPTIONS_OUT | VW_OPTIONS_JSON,
     vw_command_train},
    {VALUE, "import-steps", "LOG.csv", "Value photos from the step log of another trainer",
     "LOG.csv has the columns step, epoch, photo, psnr and l1, in any order; other columns are ignored. A row names "
     "the photo that the step trained on and the validation PSNR (dB) and mean absolute error after the step; a row "
     "between two validations leaves both empty, and its step shares the change. Step 0 is the untrained state. "
     "scripts/hooks/ of the source tree writes it from gsplat's trainer and from nerfstudio. Writes ledger.db and "
     "scores.csv to the --out folder.",
     VW_OPTIONS_IMPORT | VW_OPTIONS_JSON, vw_command_import_steps},

    {USE, "lasting", "OUT", "Score what the steps on each photo leave at the end of a finished run",
     "Trains the run of OUT again, step by step as recorded, and follows the gradient of its end (validation PSNR and "
     "mean absolute error) back over all steps. Adds the scores lasting_psnr and lasting_loss to the ledger, "
     "scores.csv and the report. Compare photos with each other; zero has no meaning.\n"
     "A gate checks it: six short trainings make the steps on a photo longer, and the change is compared "
     "with the predicted one. The command prints a warning if they disagree. The same command resumes a backward "
     "pass that was stopped, and only prints the scores of a finished one. With --lasting-matrix, matrix.csv also has "
     "lasting credit by validation photo. Uses the run's device unless --device is given. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_LASTING | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON, vw_command_lasting},
    {USE, "select", "OUT", "Write a list of the photos worth training on",
     "Trains on the lists of several rules, judges each on validation photos that did not select it, and keeps all "
     "photos unless a list is better beyond noise. Lists by lasting credit are among them after viewworth lasting OUT "
     "--lasting-matrix. Writes retrainings.db to OUT. Uses the run's device unless --device is given.\n"
     "--quick, --rule and --method train nothing and need no GPU. --quick drops only photos whose score is a robust "
     "outlier: which fit worse than the others by more than 3 robust standard deviations and have low credit.\n"
     "--copy makes a folder with the selected photos and their cameras for other trainers, beside the list or instead "
     "of it. A list (--to) is a .txt of names or, of a PhotoTourism scene, its NeRF-W TSV (.tsv), in which validation "
     "and test photos stay as they are. To train on the selection, pass a list to value --train.\n"
     "The scene must still name all valued photos. This command does not check whether photos or poses have changed; "
     "verify --replay does. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_SELECT | VW_OPTIONS_JSON, vw_command_select},
    {USE, "report", "OUT...", "Write the HTML report again, for one or several result folders",
     "OUT is the --out folder of value, compare, tradeoff or batch (whose table of jobs it "
     "shows). The report shows thumbnails if the scene can be opened. The page is "
     "report.html in the first OUT, or --to. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_REPORT | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON, vw_command_report},
    {USE, "merge", "OUT...", "Put the results of many runs side by side",
     "Takes the runs of these folders and of all folders in them; a run is called by its path from the folder that is "
     "named. Verifies every ledger. Writes to the --out folder: merged.db (the tables of all ledgers, with a column "
     "job), scores.csv (the scores of all runs) and report.html.",
     VW_OPTIONS_MERGE | VW_OPTIONS_JSON, vw_command_merge},
    {USE, "render", "OUT", "Render a view with the trained field, or a path of a camera",
     "The image of a view has the photo on the left and the render on the right. --pose and --path render from where "
     "no photo was taken, without lens distortion: far from all photos the field was not trained. Photos' own light "
     "(effects appearance and appearance_code) is left out; with appearance_encoder it is that of --view. "
     "The image is OUT/render_VIEW.png, or --to (.png or .exr); frames go to OUT/frames, or the folder --to. "
     NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_VIEW | VW_OPTIONS_JSON, vw_command_render},
    {USE, "next", "OUT", "Propose where to take the next photos",
     "Proposes poses of a camera for the next photos of a finished run, one after another: always the place that is "
     "farthest from the photos trained on and from the places before it, in position and direction, weighted by the "
     "field's error on validation photos near there. In tests, ten such photos gained 0.16 +- 0.13 dB more than ten at "
     "random where the known photos were near each other, as in an unfinished capture, and no more where they lay all "
     "around. The places are between, beside and beyond the cameras, clear of what the field shows, and see what two "
     "photos or more see from the same side; --among names others. The camera has the focal length that is usual in "
     "the scene, in a photo's pixels.\n"
     "Prints for each place its distance to the nearest photo (1 is usual between neighbours); how many photos see "
     "what it would see; why: seen by few, high error (of the field near there), extrapolates (more than 2 usual "
     "distances away), between photos, sees nothing, or no reason; and the way from the photo of the nearest position: "
     "steps in usual distances and turns, by that photo's own axes. Writes OUT/next.json, which report shows beside "
     "its map, and next_01.png and so on: what each would see. What an earlier call wrote there is replaced. --to "
     "writes the poses for other programs: as pyramids (.ply), or as a transforms file (.json) of poses without "
     "photos, in sizes after --downscale, whose file_path names the render in OUT; a file that exists is refused. "
     NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_NEXT | VW_OPTIONS_JSON, vw_command_next},
    {USE, "export", "OUT", "Write the cameras and points of a run's scene for other programs",
     "Blender and MeshLab open the .ply files. Positions are those of the scene; camera_to_world has the camera's x to "
     "the right, y up, and its view along -z. Files that exist are refused. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_EXPORT | VW_OPTIONS_JSON, vw_command_export},

    {CHECK, "verify", "OUT", "Check that the run in OUT and its files were not changed",
     "Finds rows that were edited, removed, added or reordered: recomputes every hash, every score and the identity of "
     "the run. Makes scores.csv, matrix.csv, providers.csv, payout.csv and payout_photos.csv again and compares them "
     "with the files; "
     "compares field.vwf with its hash. Prints a table of what was checked, and by what. Writes nothing.\n"
     "Compares every file that SHA256SUMS lists, and the chain head in it with the ledger's, and names the files in "
     "OUT that are not listed.\n"
     "A stranger can rewrite a ledger, its files and SHA256SUMS so that they fit together. A signature of SHA256SUMS "
     "(ssh-keygen -Y sign, minisign) detects that, and --expect HEAD if the chain head was noted elsewhere. With "
     "the scene, --replay N|all trains steps again, --retrainings N|all makes retrainings of worth again, and "
     "--lasting the backward pass of lasting credit; every bit must be the recorded one. " NEEDS_SCENE_FOLDER,
     VW_OPTIONS_DEVICE | VW_OPTIONS_VERIFY | VW_OPTIONS_JSON, vw_command_verify},

    {COMPARE, "compare", "SCENE", "Compare sets of photos by the reconstructions that they give",
     "Trains on every --list with the same seeds. Measures PSNR, SSIM and L1 of whole validation and test photos, "
     "and whether lists differ by more than noise. If an appearance effect is on, it comes from the left half of a "
     "photo, and only the right half is measured.\n"
     "Lists that use --scores were selected with the validation photos: only the test photos are a fair comparison, "
     "with other seeds than those of the valued run. The list random draws as many photos as the list before it, "
     "again for each seed.\n"
     "Writes to the --out folder: retrainings.db, compare.json, compare.csv, pairs.csv, renders/ "
     "and report.html. Run the same command again to resume it.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_COMPARE |
         VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_command_compare},
    {COMPARE, "tradeoff", "SCENE", "Measure what accuracy costs in time, one parameter at a time",
     "Values the scene with the configuration that the options give, the base, and with configurations that change "
     "one parameter each. A full-resolution reference (all validation pixels, twice the rays) shows how accurate the "
     "scores of the others are.\n"
     "Times the steps of all configurations first, and prints how long the rest takes; a "
     "higher --downscale makes it shorter.\n"
     "Writes to the --out folder: configurations/, tradeoff.csv and report.html. Run "
     "the same command again to resume it.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_TRADEOFF |
         VW_OPTIONS_JSON,
     vw_command_tradeoff},
};
// clang-format on

static const char *const groups[] = {
    [VALUE] = "Value photos", [USE] = "Use the scores", [CHECK] = "Check the results", [COMPARE] = "Experiments", NULL};

static const struct vw_program viewworth = {
    .name = "viewworth",
    .summary = "what each photo is worth to a 3-D reconstruction",
    .description = "viewworth trains a radiance field from posed photos, one photo per step, and measures the "
                   "validation photos after every step. It keeps a ledger of how much each photo changed the "
                   "validation error, and computes scores with uncertainty from it.",
    .groups = groups,
    .commands = commands,
    .command_count = VW_ARRAY_COUNT(commands),
    .tables = {{vw_option_table, &vw_option_count}},
    .defaults = &vw_options_default,
    .options_bytes = sizeof(struct vw_options),
};

int main(int argc, char **argv) { return vw_program_run(&viewworth, argc, argv); }

// viewworth: what each photo is worth to a 3-D reconstruction. The table of commands, and the only place that ends the
// program.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands/commands.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "viewworth/version.h"
#include "viewworth/train.h"

static const struct vw_command commands[] = {
    {"devices", NULL, "List the Vulkan devices, most preferred first", NULL, VW_OPTIONS_JSON, vw_command_devices},
    {"info", "SCENE", "Say what a scene holds and which effects it calls for",
     "SCENE is a folder with transforms*.json, a COLMAP model or a NeRF-W list (.tsv) beside dense/, a transforms "
     "file, or a recipe "
     "(.json).",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_INFO | VW_OPTIONS_JSON, vw_command_info},
    {"value", "SCENE", "Train a radiance field one photo per step and say what each photo is worth",
     "Leaves ledger.db (every step and score), report.html, scores.csv, matrix.csv (photo by validation photo), "
     "field.vwf and checkpoints "
     "in the --out folder; with providers also providers.csv and, by --payout, payout.csv; duplicates.csv where photos "
     "show the same. "
     "Positive scores help. With --resume on a finished run all tables but scores.csv are made again.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_VALUE | VW_OPTIONS_ONE_RUN |
         VW_OPTIONS_ONE_VALUE | VW_OPTIONS_OUT | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_command_value},
    {"train", "SCENE", "Take the same training steps as value, without validation after each and without scores",
     "Leaves ledger.db, field.vwf and checkpoints in the --out folder.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_ONE_RUN | VW_OPTIONS_OUT | VW_OPTIONS_JSON,
     vw_command_train},
    {"reproduce", "SCENE", "Value the photos with several seeds and say how far the scores agree",
     "Leaves a run per seed in OUT/seed_<seed>, as value does, report.html, reproduce.csv (every measure of agreement, "
     "pair, method and "
     "number of epochs) and scatter.csv (the scores of every pair side by side). Goes on with the runs that OUT holds, "
     "and reuses finished "
     "ones.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_VALUE | VW_OPTIONS_RUNS |
         VW_OPTIONS_REPRODUCE | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_command_reproduce},
    {"render", "OUT", "Render a photo's view with the trained field in OUT: photo left, render right",
     "Opens the scene as the training did: run it from the same folder when paths were relative.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_VIEW | VW_OPTIONS_JSON, vw_command_render},
    {"benchmark", "SCENE", "Evaluate every scoring method where truth is known",
     "Values the scene with two seeds, trains on random halves of its photos with two others, and says how well scores "
     "find corrupted photos "
     "and predict those trainings. Leaves seed_<N>/, retrainings.db and benchmark.csv in the --out folder; the same "
     "command goes on where it "
     "was stopped.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_BENCHMARK |
         VW_OPTIONS_JSON,
     vw_command_benchmark},
    {"compare", "SCENE", "Say which set of photos makes the better reconstruction",
     "Trains every --list with the same seeds and measures whole validation and test photos (where appearance effects "
     "fit them, their "
     "right "
     "halves): PSNR, SSIM and L1, and whether lists differ beyond noise. Lists chosen by --scores were chosen on "
     "validation photos: only "
     "test "
     "figures evaluate them; take other seeds than the valued run's. random draws as many photos as the list before "
     "it, anew for each seed. "
     "Leaves retrainings.db, compare.json, compare.csv, "
     "pairs.csv, disagreements.csv, renders/ and report.html in the --out folder; the same command goes on where it "
     "was stopped.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_COMPARE |
         VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_command_compare},
    {"tradeoff", "SCENE", "Show what accuracy costs in time, parameter by parameter",
     "Values the scene at the setting of the options and at points around it, each with one parameter changed, and at "
     "an exhaustive one (all "
     "validation pixels, twice the rays), which the others' scores are held against. Times the steps of all points "
     "first, in turn, and "
     "says how "
     "long the rest takes; a higher --downscale makes it affordable. Leaves points/, tradeoff.db, retrainings.db, "
     "tradeoff.csv and report.html "
     "in the --out folder; the same command goes on where it was stopped.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_TRADEOFF |
         VW_OPTIONS_JSON,
     vw_command_tradeoff},
    {"report", "OUT...", "Write the report of what OUT holds, or one of several, anew",
     "Takes what value, reproduce, benchmark, compare and tradeoff leave. Shows the photos where the scene can be "
     "opened as the training "
     "did: run it "
     "from the same folder when paths were relative.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_REPORT | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON, vw_command_report},
    {"verify", "OUT", "Check that nothing in the ledger of OUT was edited, removed, added or reordered",
     "Recomputes all hashes and scores. Who rewrites a whole ledger, hashes and all, is found out by --expect, or by "
     "--replay, which opens "
     "the scene as the training did.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_VERIFY | VW_OPTIONS_JSON, vw_command_verify},
    {"select", "OUT", "List the photos worth training on, in the format that the scene came in",
     "Takes one of --positive, --significant, --not-harmful, --top and --drop; needs no GPU and none of the scene's "
     "images. Writes the "
     "scene's NeRF-W TSV "
     "with the rows of the chosen photos, transforms.json with their frames (to PATH.json as one file that tells "
     "splits apart by "
     "nerfstudio's train_filenames, val_filenames and test_filenames; to any other PATH as a folder of "
     "transforms_{train,val,test}.json), "
     "COLMAP's image list, or plain names, one a line. Validation and test photos stay as they are. Paths in "
     "transforms.json lead from "
     "PATH; viewworth opens it when PATH lies in the scene's folder or in one above. All other lists go to value "
     "--train. The scene must "
     "still name all photos that were valued; whether photos or poses have changed since is not looked at (verify "
     "--replay does). Run it "
     "from the same folder as value when paths were relative.",
     VW_OPTIONS_SELECT | VW_OPTIONS_JSON, vw_command_select},
    {"import-steps", "LOG.csv", "Value photos by the per-step log of any other trainer",
     "LOG.csv has the columns step, epoch, photo, psnr and l1, in any order and among others: the photo that a step "
     "trained on, and the "
     "validation after it. Step 0 is the untrained state. Leaves ledger.db and scores.csv in the --out folder.",
     VW_OPTIONS_IMPORT | VW_OPTIONS_JSON, vw_command_import_steps},
};

static void print_help(void) {
    printf("viewworth: what each photo is worth to a 3-D reconstruction\n\nusage: viewworth COMMAND "
           "[options]\n\ncommands:\n");
    for (size_t i = 0; i < VW_ARRAY_COUNT(commands); i++) {
        char call[32];
        snprintf(call, sizeof call, "%s %s", commands[i].name, commands[i].operand ? commands[i].operand : "");
        printf("  %-20s %s\n", call, commands[i].summary);
    }
    printf("\nviewworth COMMAND --help says more; viewworth --version names the version.\n");
}

static enum vw_status run_command(const struct vw_command *command, int argc, char **argv) {
    struct vw_options options;
    enum vw_status status = vw_options_parse(command, argc, argv, &options);
    if (status) return status;
    if (options.help) {
        vw_options_print_help(command);
        return VW_OK;
    }
    vw_log_set_quiet(options.quiet);
    return command->run(&options);
}

static enum vw_status run(int argc, char **argv) {
    if (argc < 2) return vw_fail(VW_ERROR_USAGE, "no command given; see viewworth --help");
    if (strcmp(argv[1], "--help") == 0) {
        print_help();
        return VW_OK;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("viewworth %s\n", vw_version());
        return VW_OK;
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(commands); i++)
        if (strcmp(argv[1], commands[i].name) == 0) return run_command(&commands[i], argc - 1, argv + 1);
    return vw_fail(VW_ERROR_USAGE, "unknown command \"%s\"; see viewworth --help", argv[1]);
}

int main(int argc, char **argv) {
    enum vw_status status = run(argc, argv);
    if ((fflush(stdout) || ferror(stdout)) && !status)
        status = vw_fail(VW_ERROR_IO, "stdout: cannot write; check where it goes");
    if (status) fprintf(stderr, "viewworth: %s\n", vw_error_message());
    return vw_exit_code(status);
}

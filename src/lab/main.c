// viewworth-lab: how good scores of photos are. The table of its commands.
#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/program.h"
#include "lab/commands/commands.h"

enum command_group { EVALUATE, CORRUPT };

// clang-format off
static const struct vw_program_command commands[] = {
    {EVALUATE, "reproduce", "SCENE",
     "Value the photos with several seeds and measure how well the scores agree",
     "Writes to the --out folder: seed_N/ with the files of value for every seed, report.html, reproduce.csv "
     "(metrics of agreement by pair of seeds, method and number of epochs) and scatter.csv (the scores of each pair "
     "side by side). With --lasting, takes the backward pass of every run and also writes "
     "lasting_seeds.csv: lasting credit over the seeds, with intervals, and which photos it cannot tell apart. "
     "Resumes runs that are not finished and reuses finished ones.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS |
         VW_LAB_REPRODUCE | VW_OPTIONS_LASTING | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_lab_reproduce},
    {EVALUATE, "benchmark", "SCENE", "Evaluate the scoring methods against ground truth",
     "Values the scene with two seeds and trains on random halves of its photos with two other seeds. Then measures "
     "how well the scores of each method find corrupted photos and predict the results of those trainings.\n"
     "Writes to the --out folder: seed_N/, retrainings.db and benchmark.csv. Run the same command again to resume it.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_LAB_BENCHMARK |
         VW_OPTIONS_LASTING | VW_OPTIONS_JSON,
     vw_lab_benchmark},
    {EVALUATE, "copies", "SCENE", "Copy photos as a dishonest provider would, and count the copies that are found",
     "Copies up to 24 photos in one way after the other: cut off, shifted, mirrored, exposed otherwise, compressed, "
     "masked, with another pose. Prints how many are listed as near-duplicates of their originals, and how many pairs "
     "of the scene's own photos are.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE, vw_lab_copies},
    {EVALUATE, "probe", "OUT", "Measure the noise of a finished run, and score photos from the same states",
     "Takes the steps of the run in OUT again and compares them with its ledger. At some steps of every photo, it also "
     "validates twice, takes a step of learning rate 0, and takes steps on other pixels of the photo.\n"
     "Writes to OUT: probes.csv (each probe) and probe_scores.csv (scores, with the error that the choice of pixels "
     "causes).",
     VW_OPTIONS_DEVICE | VW_LAB_PROBES | VW_OPTIONS_JSON, vw_lab_probe},
    {EVALUATE, "report", "OUT...", "Write the HTML report of viewworth report, with the results of benchmark",
     "Shows benchmark.csv of the folders beside all that viewworth report shows.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_REPORT | VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON, vw_lab_report},

    {CORRUPT, "value", "SCENE", "Value photos as viewworth does, with corrupted photos",
     "Writes what viewworth value writes. --corrupt spoils some train photos, so that it is known which ones scores "
     "should find.",
     VW_OPTIONS_OF_VALUE, vw_command_value},
    {CORRUPT, "compare", "SCENE", "Compare sets of photos as viewworth does, with corrupted photos",
     "--corrupt spoils some train photos.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_COMPARE |
         VW_OPTIONS_THUMBNAILS | VW_OPTIONS_JSON,
     vw_command_compare},
    {EVALUATE, "tradeoff", "SCENE", "Measure what accuracy costs in time, and what scores then predict",
     "Does what viewworth tradeoff does, and also evaluates the scores of every configuration by trainings on random "
     "halves of the photos.",
     VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_RUNS | VW_OPTIONS_TRADEOFF |
         VW_LAB_TRADEOFF | VW_OPTIONS_JSON,
     vw_lab_tradeoff},
};
// clang-format on

static const char *const groups[] = {
    [EVALUATE] = "Evaluate methods", [CORRUPT] = "Value and compare with corrupted photos", NULL};

static const struct vw_program lab = {
    .name = "viewworth-lab",
    .summary = "how good scores of photos are",
    .description = "viewworth-lab evaluates methods that score photos, those of viewworth and others of the "
                   "literature: by corrupted photos, by retrainings, and by how well seeds agree.",
    .groups = groups,
    .commands = commands,
    .command_count = VW_ARRAY_COUNT(commands),
    .tables = {{vw_option_table, &vw_option_count}, {vw_lab_option_table, &vw_lab_option_count}},
    .defaults = &vw_lab_options_default.common,
    .options_bytes = sizeof(struct vw_lab_options),
};

int main(int argc, char **argv) { return vw_program_run(&lab, argc, argv); }

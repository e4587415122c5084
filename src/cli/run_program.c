#include "cli/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "cli/help.h"
#include "cli/output/progress.h"
#include "cli/params.h"
#include "viewworth/log.h"
#include "viewworth/version.h"

static enum vw_status run_command(const struct vw_program *program, const struct vw_program_command *command, int argc,
                                  char **argv, struct vw_options *options) {
    enum vw_status status = vw_options_parse(program, command, argc, argv, options);
    if (status) return status;
    if (options->help) {
        vw_help_print_command(program, command, false);
        return VW_OK;
    }
    vw_log_set_sink(vw_log_to_stderr, &options->quiet);
    status = vw_params_set_memory(options);
    if (!status) status = command->run(options);
    vw_log_set_sink(NULL, NULL); // the options end before the thread
    return status;
}

static enum vw_status find_command(const struct vw_program *program, const char *name,
                                   const struct vw_program_command **command) {
    const char *nearest = NULL;
    uint32_t least = UINT32_MAX;
    for (uint32_t i = 0; i < program->command_count; i++) {
        *command = &program->commands[i];
        if (strcmp(name, (*command)->name) == 0) return VW_OK;
        vw_take_nearer(name, (*command)->name, &least, &nearest);
    }
    if (nearest) return vw_fail(VW_ERROR_USAGE, "unknown command \"%s\"; is %s meant?", name, nearest);
    return vw_fail(VW_ERROR_USAGE, "unknown command \"%s\"; see %s --help", name, program->name);
}

static enum vw_status find_and_run(const struct vw_program *program, int argc, char **argv) {
    const struct vw_program_command *command = NULL;
    enum vw_status status = find_command(program, argv[1], &command);
    if (status) return status;
    struct vw_options *options = vw_allocate(1, program->options_bytes);
    status = options ? run_command(program, command, argc - 1, argv + 1, options) : VW_ERROR_MEMORY;
    free(options);
    return status;
}

static enum vw_status help(const struct vw_program *program, const char *name) {
    const struct vw_program_command *command = NULL;
    enum vw_status status = name ? find_command(program, name, &command) : VW_OK;
    if (command && !status) vw_help_print_command(program, command, true);
    else if (!status) vw_help_print_program(program);
    return status;
}

static enum vw_status run(const struct vw_program *program, int argc, char **argv) {
    if (argc < 2) return vw_fail(VW_ERROR_USAGE, "no command given; see %s --help", program->name);
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) return help(program, NULL);
    if (strcmp(argv[1], "help") == 0) return help(program, argc > 2 ? argv[2] : NULL);
    if (strcmp(argv[1], "--version") == 0) {
        printf("%s %s\n", program->name, vw_version());
        return VW_OK;
    }
    if (strcmp(argv[1], "--generate-docs") == 0) return vw_manual_write(program, argc == 3 ? argv[2] : "");
    return find_and_run(program, argc, argv);
}

int vw_program_run(const struct vw_program *program, int argc, char **argv) {
    enum vw_status status = vw_streams_prepare() ? run(program, argc, argv)
                                                 : vw_fail(VW_ERROR_IO, "/dev/null: cannot be opened; mount /dev");
    if ((fflush(stdout) || ferror(stdout)) && !status)
        status = vw_fail(VW_ERROR_IO, "stdout: cannot write; check where it goes");
    if (status) fprintf(stderr, "%s: %s\n", program->name, vw_error_message());
    return vw_exit_code(status);
}

#include <stdlib.h>

#include "base/memory.h"
#include "base/signing.h"
#include "cli/commands/commands.h"
#include "cli/output/json_output.h"
#include "cli/output/print.h"

enum vw_status vw_command_keygen(const struct vw_options *options) {
    char key[VW_PUBLIC_KEY_TEXT_BYTES];
    if (!options->to || !*options->to)
        return vw_fail(VW_ERROR_USAGE, "keygen: --to is missing; name the file for the secret key");
    char *public_path = vw_format_text("%s.pub", options->to);
    enum vw_status status = public_path ? vw_keys_make(options->to, key) : VW_ERROR_MEMORY;
    if (!status && options->json)
        status = vw_json_print(json_pack("{s:s, s:s, s:s}", "secret_key_file", options->to, "public_key_file",
                                         public_path, "public_key", key));
    else if (!status)
        vw_print("secret key  %s (keep it to yourself)\npublic key  %s (give it to those who verify)\n            %s\n",
                 options->to, public_path, key);
    free(public_path);
    return status;
}

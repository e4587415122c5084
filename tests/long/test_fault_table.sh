#!/usr/bin/env bash
# The whole table of scripts/faults, more than 200 kills among them. Takes the program's path.
# label: unsanitized
export VIEWWORTH_FAULTS=20
exec "$(dirname "$0")/../cli/test_faults.sh" "$@"

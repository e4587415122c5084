#!/usr/bin/env bash
# The pictures of README.md show the program's page of today, by their headings. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
[[ -x ${CHROMIUM:-/usr/bin/chromium} && -x ${CHROMEDRIVER:-/usr/bin/chromedriver} ]] && /usr/bin/python3 -c 'import selenium' 2>/dev/null ||
    { echo "SKIPPED: install chromium, chromium-driver and python3-selenium"; exit 77; }
check "scripts/lab/pictures would make the same" run env VIEWWORTH="$program" "$root/scripts/lab/pictures" --check
conclude "$@"

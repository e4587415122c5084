#!/usr/bin/env bash
# A finished run whose ledger was edited: commands that would write to it refuse, and those that only read say so in one line. Takes the
# program's path.
# label: once
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/tests/support/tiny.json
printf 'name,provider\nview_000,alice\nview_001,bob\n' >"$folder/providers.csv"

value() { "$program" value "$scene" --out "$folder/$1" "${small[@]}" --providers "$folder/providers.csv" --epochs 3 --quiet "${@:2}"; }
content() { (cd "$folder/$1" && find . -type f ! -name .viewworth.lock -exec sha256sum {} + | sort); }
# refuses COMMAND...: with the row and the remedy, and leaves OUT as it was.
refuses() {
    local before
    before=$(content edited)
    fails 1 'step 4 .*was edited.*nothing is written to it: restore the file from a copy' "$@" && [[ $(content edited) == "$before" ]]
}
# says COMMAND...: the command succeeds, and one line on stderr says that the ledger was edited.
says() {
    run "$@" && [[ $(grep -c 'the ledger was edited' "$folder/stderr") -eq 1 ]] && ! grep -q 'the ledger was edited' "$folder/stdout"
}
silent() { run "$@" && ! grep -q 'was edited' "$folder/stderr"; }

check "value" run value run
cp -r "$folder/run" "$folder/edited"
sqlite3 "$folder/edited/ledger.db" 'UPDATE step SET val_psnr = val_psnr + 1 WHERE step = 4'

check "worth refuses" refuses "$program" worth "$folder/edited" --retrainings 8
check "worth --payout refuses" refuses "$program" worth "$folder/edited" --payout 100
check "lasting refuses" refuses "$program" lasting "$folder/edited"
check "value --resume refuses" refuses value edited --resume
check "value --resume --epochs refuses" refuses value edited --resume --epochs 4
check "select refuses to train" eval '! "$program" select "$folder/edited" --to "$folder/list.txt" 2>"$folder/stderr" &&
    grep -q "step 4 .*was edited" "$folder/stderr" && [[ ! -e $folder/list.txt ]]'
check "select says so" says "$program" select "$folder/edited" --rule top:2 --to "$folder/list.txt"
check "worth that reads says so" says "$program" worth "$folder/edited"
check "render says so" says "$program" render "$folder/edited" --to "$folder/render.png"
check "report says so" says "$program" report "$folder/edited" --to "$folder/report.html" --no-thumbnails
check "merge refuses" fails 1 'step 4 .*was edited' "$program" merge "$folder/edited" --out "$folder/merged"
check "nothing is said of a ledger that verifies" silent "$program" select "$folder/run" --rule top:2 --to "$folder/another.txt"
conclude "$@"

#!/usr/bin/env bash
# SHA256SUMS of a finished run, by sha256sum and by verify: what it lists, when it is written, and that verify finds a listed file that
# was changed or removed, a file that was added, and another chain head. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

value() { "$program" value "$scene" --out "$folder/$1" "${small[@]}" --epochs 3 --quiet "${@:2}"; }
verify() { "$program" verify "$folder/$1" "${@:2}"; }
row() { prints "^$1 +$2( |$)" verify "${@:3}"; } # row ITEM RESULT OUT [OPTION]...: of verify's table
# listed OUT: sha256sum takes every line but the comment, and the comment is the ledger's chain head.
listed() {
    (cd "$folder/$1" && sha256sum -c --strict --quiet SHA256SUMS) &&
        [[ $(head -n 1 "$folder/$1/SHA256SUMS") == "# viewworth chain head $(query "$1" 'SELECT final_hash FROM run')" ]]
}
names() { tail -n +2 "$folder/$1/SHA256SUMS" | cut -c67- | tr '\n' ' '; }
copy() { rm -rf "${folder:?}/copy" && cp -r "$folder/run" "$folder/copy"; }

# ---- When it is written, and what it lists ------------------------------------------------------------------------------

check "value" run value run
check "leaves a list that sha256sum takes, with the chain head" listed run
check "of all results, sorted" test "$(names run)" = \
    "advice.csv duplicates.csv field.vwf ledger.db map.json matrix.csv reconstruction.json report.html ""residuals.json scores.csv \
splits.json "
check "a finished run is listed again, with the same files" eval 'cp "$folder/run/SHA256SUMS" "$folder/list"
    run value run --resume && listed run && cmp "$folder/run/SHA256SUMS" "$folder/list"'
check "train lists" eval 'run "$program" train "$scene" --out "$folder/trained" "${small[@]}" --epochs 2 --quiet && listed trained'
check "without tables" test "$(names trained)" = "field.vwf ledger.db splits.json "
printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.3\n1,0,a,11,0.2\n2,0,b,12,0.1\n3,1,a,13,0.1\n4,1,b,14,0.1\n' >"$folder/log.csv"
check "import-steps lists" eval 'run "$program" import-steps "$folder/log.csv" --out "$folder/imported" && listed imported'
check "more epochs are listed" eval 'run value more && run value more --resume --epochs 4 && listed more'
check "lasting lists again" eval 'run "$program" lasting "$folder/more" --no-gate --quiet && listed more && row SHA256SUMS intact more'
check "worth lists again" eval 'run "$program" worth "$folder/more" --retrainings 8 --quiet && listed more && row SHA256SUMS intact more'
paid() { [[ -e $folder/more/payout.csv ]]; }
removed() { grep -q "payout.csv is removed, .* value --resume with --payout AMOUNT" "$folder/stderr"; }
pay() { echo provider >"$folder/more/payout.csv"; } # tests/run/test_run_verify.c has a real one
check "worth removes a payout and says how to ask again" eval 'pay &&
    run "$program" worth "$folder/more" --retrainings 9 --quiet && listed more && ! paid && removed'
check "lasting, too" eval 'pay &&
    run "$program" lasting "$folder/more" --lasting-matrix --no-gate --quiet && listed more && ! paid && removed'
check "value --resume, too" eval 'pay && run value more --resume --epochs 4 && listed more && ! paid && removed'
check "report lists its file again" eval 'echo >>"$folder/more/report.html"
    run "$program" report "$folder/more" --no-thumbnails && listed more'
cp "$folder/more/SHA256SUMS" "$folder/list"
report() { "$program" report "$folder/more" --quiet "$@"; }
check "and no other: not where one was changed" eval 'cp "$folder/more/map.json" "$folder" && echo >>"$folder/more/map.json"
    fails 1 "map.json: is not the file that SHA256SUMS lists" report && mv "$folder/map.json" "$folder/more"'
check "nor where one was added" eval 'echo name >"$folder/more/payout_photos.csv"
    fails 1 "payout_photos.csv: is not listed" report && rm "$folder/more/payout_photos.csv"'
check "nor in the place of another result" fails 2 'scores.csv: is a result of the run' report --to "$folder/more/scores.csv"
check "refused reports leave the list" eval 'cmp "$folder/more/SHA256SUMS" "$folder/list" && verify more >/dev/null'
check "steps that are not finished have no list" eval '
    "$program" value "$scene" --out "$folder/stopped" "${small[@]}" --epochs 100000 --quiet 2>/dev/null & stopped=$!
    while kill -0 "$stopped" && [[ ! -e $folder/stopped/ledger.db ]]; do sleep 0.1; done
    kill -INT "$stopped"; wait "$stopped"
    [[ -e $folder/stopped/ledger.db && ! -e $folder/stopped/SHA256SUMS ]]'

# ---- What a stranger laid there -----------------------------------------------------------------------------------------

# lay OUT: puts a forged file in the place of every derived one.
derived=(SHA256SUMS duplicates.csv field.ply map.json matrix.csv payout.csv payout_photos.csv providers.csv reconstruction.json report.html
    residuals.json scores.csv)
lay() {
    mkdir -p "$folder/$1"
    for name in "${derived[@]}"; do echo forged >"$folder/$1/$name"; done
}
unforged() { ! grep -qx forged "$folder/$1"/*; } # unforged OUT
check "value makes or removes every derived file" eval 'lay fresh && run value fresh && listed fresh && unforged fresh'
check "so does a finished run" eval 'lay run && run value run --resume && listed run && unforged run &&
    [[ ! -e $folder/run/payout.csv ]] && row SHA256SUMS intact run'
check "worth, which makes what value made" eval 'lay fresh && run "$program" worth "$folder/fresh" --retrainings 8 --quiet &&
    listed fresh && unforged fresh && [[ $(names fresh) == "$(names run)" ]]'

# ---- What cannot be made ------------------------------------------------------------------------------------------------

copy && cp "$folder/more/field.vwf" "$folder/copy"
check "value fails without the run's field" fails 1 'field.vwf: is not the field that the run ended with' value copy --resume
check "worth, too" fails 1 'field.vwf: is not the field that the run ended with' "$program" worth "$folder/copy" --retrainings 8 --quiet
copy && rm "$folder/copy/map.json" && mkdir "$folder/copy/map.json"
check "value refuses a folder in place of a map" fails 2 'map.json: is not a file' value copy --resume
copy && echo '{' >"$folder/copy/compare.json"
check "value fails without a report" fails 2 'no report: .*compare.json: line 2' value copy --resume
check "and leaves no list" test ! -e "$folder/copy/SHA256SUMS"
check "worth, too" fails 2 'no report: .*compare.json: line 2' "$program" worth "$folder/copy" --retrainings 8 --quiet

# ---- What verify finds: test_run_verify.c edits the list, links files and adds tables --------------------------------------

before=$(checksums run)
check "an intact run" row SHA256SUMS intact run
check "with its report" row report.html intact run
check "verify writes nothing" test "$(checksums run)" = "$before"
for name in $(names run); do
    copy && printf x >>"$folder/copy/$name"
    check "a byte more of $name is found" eval '! verify copy 2>&1 | grep -q intact'
    copy && rm "$folder/copy/$name"
    check "$name is missed" eval '! verify copy 2>&1 | grep -q intact'
done
copy && touch "$folder/copy/keep.txt"
check "a file of the user is named" row keep.txt 'not checked' copy
check "and in JSON" eval 'verify copy --json >"$folder/answer.json" && [[ $(sqlite3 :memory: "SELECT json_extract(
    CAST(readfile('"'$folder/answer.json'"') AS TEXT), '"'\$.not_listed[#-1]'"')") == keep.txt ]]'
copy && sed -i '1s/[0-9a-f]\{64\}/'"$(printf '%064d' 1)"'/' "$folder/copy/SHA256SUMS"
check "another head is found" fails 1 'SHA256SUMS: is of another state of the run' verify copy
check "a folder that cannot be written is verified" eval 'chmod 500 "$folder/run"; row scores.csv intact run; chmod 700 "$folder/run"'
check "a replay settles what the ledger claims" row 'scene, shaders, device' intact run --replay 3
sqlite3 "$folder/trained/ledger.db" "UPDATE image SET sha256 = replace(sha256, '1', '2')"
check "an edited photo is found" fails 1 'image row was edited' verify trained
conclude "$@"

#!/usr/bin/env bash
# field.ply and --initial: a run of splats leaves its splats for other programs, listed in SHA256SUMS, and another run begins from them;
# the file's hash is part of that run's identity, and a file that is not splats is refused in one line. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

splats=(--field splats --splats 150 --rays 256 --val-rays 64 --effects none --device llvmpipe --quiet)
value() { "$program" value "$scene" --out "$folder/$1" "${splats[@]}" --epochs 2 "${@:2}"; }
train() { "$program" train "$scene" --out "$folder/$1" "${splats[@]}" --epochs 2 "${@:2}"; }
lists() { (cd "$folder/$1" && sha256sum -c --strict --quiet SHA256SUMS && grep -q ' field.ply$' SHA256SUMS); }

check "train leaves splats" eval 'run train first && lists first && grep -aq "^comment SplatRenderMode: default$" "$folder/first/field.ply"'
check "value leaves the same" eval 'run value valued && lists valued && says "^files .*/field.ply" &&
    cmp "$folder/first/field.ply" "$folder/valued/field.ply"'
check "with its path in JSON" answers "j->>'splats' LIKE '%/field.ply'" "$program" value "$scene" --out "$folder/valued" "${splats[@]}" \
    --epochs 2 --resume --json
check "another field leaves none, and removes what lies there" eval 'mkdir "$folder/hash" && touch "$folder/hash/field.ply" &&
    run "$program" train "$scene" --out "$folder/hash" "${small[@]}" --epochs 1 --quiet && [[ ! -e $folder/hash/field.ply ]]'
check "a changed file is found" eval 'cp -r "$folder/valued" "$folder/copy" && printf x >>"$folder/copy/field.ply" &&
    fails 1 "field.ply" "$program" verify "$folder/copy"'

check "a run begins from the file" run value second --initial "$folder/first/field.ply"
# hundredths OUT ORDER: of dB of validation PSNR, at the first or last step
hundredths() { query "$1" "SELECT CAST(round(val_psnr * 100) AS INTEGER) FROM step ORDER BY step $2 LIMIT 1"; }
check "where the other one ended" test "$(hundredths second ASC)" = "$(hundredths valued DESC)"
check "it takes its steps again" run "$program" verify "$folder/second" --replay 3
check "it is resumed with the file" run value second --initial "$folder/first/field.ply" --resume
cp "$folder/second/field.ply" "$folder/other.ply"
check "and not with another one" fails 2 'initial_sha256' value second --initial "$folder/other.ply" --resume
mkdir "$folder/own" && cp "$folder/other.ply" "$folder/own/field.ply"
check "nor with the file that the run replaces" fails 2 'is in --out, which replaces it' value own --initial "$folder/own/field.ply"
check "which stays" cmp "$folder/other.ply" "$folder/own/field.ply"
check "nor without one" fails 2 'initial_sha256' value second --resume
check "a replay asks for the file" eval 'cp "$folder/second/field.ply" "$folder/first/field.ply" &&
    fails 2 "first/field.ply: is not the file that the run begins from" \
    "$program" verify "$folder/second" --replay 3 --quiet'
check "a file of higher degree names the option" fails 2 '--harmonics 1' train third --initial "$folder/second/field.ply" --harmonics 0
check "a file that is no splats is refused by name" fails 2 'ledger.db: does not begin with the line ply' \
    train third --initial "$folder/first/ledger.db"
check "a file that is missing, too" fails 2 'none.ply' train third --initial "$folder/none.ply"
check "the hash grid has no splats to begin with" fails 2 '--initial: needs --field splats' \
    "$program" train "$scene" --out "$folder/third" "${small[@]}" --quiet --initial "$folder/second/field.ply"
check "nothing is written" test ! -e "$folder/third"
conclude "$@"

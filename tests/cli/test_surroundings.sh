#!/usr/bin/env bash
# Rare surroundings: closed streams, pipes without a reader, limits of file size, names that are not UTF-8, caches that others may write to,
# and runs that come to nothing. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"
tiny_run=("${small[@]}" --epochs 2 --quiet)
export XDG_CACHE_HOME=$folder/cache

# ---- Streams ----------------------------------------------------------------------------------------------------------------

# stays_off_files PROGRAM: started without streams, no file of the run gets the number of one.
stays_off_files() {
    local process stream end=$((SECONDS + 60)) places=
    "$1" value "$scene" --out "$folder/closed" "${small[@]}" --epochs 100000 <&- >&- 2>&- &
    process=$!
    until [[ -s $folder/closed/ledger.db ]]; do [[ $SECONDS -lt $end ]] && kill -0 "$process" || break; sleep 0.1; done
    for stream in 0 1 2; do places+=$(readlink "/proc/$process/fd/$stream"); done
    kill "$process"
    wait "$process"
    rm -rf "$folder/closed"
    [[ $places == /dev/null/dev/null/dev/null ]] || { echo "$places"; return 1; }
}
check "without streams, files are not taken for them" stays_off_files "$program"
check "nor by viewworth-lab" stays_off_files "$lab"
check "a closed stdout is an error" eval '! "$program" devices >&- 2>"$folder/stderr" && grep -q "stdout: cannot write" "$folder/stderr"'
check "so is a full one" eval '"$program" --help >/dev/full 2>"$folder/stderr"; test $? -eq 1'
# The reader is gone before the first byte.
unread() {
    local code=0
    exec 3> >(exec true)
    wait $!
    "$program" --help >&3 2>"$folder/stderr" || code=$?
    exec 3>&-
    [[ $code -eq 1 && $(wc -l <"$folder/stderr") -eq 1 ]]
}
check "and one that nobody reads, which kills nothing" unread

# ---- Limits -----------------------------------------------------------------------------------------------------------------

large=("${tiny_run[@]}" --log2-table 17 --base-resolution 64) # its field has some MiB
check "a run to compare with" run "$program" value "$scene" --out "$folder/free" "${large[@]}"
limited() { (ulimit -f "$1" && exec "$program" value "$scene" --out "$folder/limited" "${large[@]}"); }
check "a limit of file size that the field exceeds ends the run" eval 'limited 1200 >"$folder/stdout" 2>"$folder/stderr"; test $? -eq 1'
check "with an error" grep -q '^viewworth: .*field.vwf: cannot write: File too large' "$folder/stderr"
check "whose ledger is intact" run "$program" verify "$folder/limited"
check "and goes on" run "$program" value "$scene" --out "$folder/limited" "${large[@]}" --resume
check "to the same end" same_run free limited

# ---- Names ------------------------------------------------------------------------------------------------------------------

latin=$folder/$'caf\xe9'
mkdir "$latin" && cp "$scene" "$latin/tiny.json"
for path in "$latin/tiny.json" "$folder/"$'a\nb' "$folder/"$'a\x1b[2J' "$folder/"$'\xe2\x80\xae'; do
    check "a scene that cannot be shown" fails 2 'is not UTF-8 or has control characters' "$program" info "$path" --json
    check "and such a folder of results" fails 2 'is not UTF-8 or has control characters' "$program" value "$scene" --out "$path"
done
named() { rm -rf "$folder/many" && mkdir -p "$folder/many" && cp -r "$folder/free" "$folder/many/$1"; }
for name in $'caf\xe9' $'a\nb' $'a\tb'; do
    named "$name"
    check "a run whose folder cannot be shown" fails 2 'is not UTF-8 or has control characters' \
        "$program" merge "$folder/many" --out "$folder/merged"
    check "which leaves nothing" test ! -e "$folder/merged/scores.csv"
done
named '＝1;"=2'
check "a folder named as a formula" run "$program" merge "$folder/many" --out "$folder/merged"
check "is none in the merged tables" test "$(sed -n 2p "$folder/merged/summary.csv" | cut -d, -f1)" = "\"'＝1;'\"\"=2\""
sqlite3 "$folder/many"/*/ledger.db "UPDATE run SET scene_path = CAST(x'61ff' AS TEXT)"
check "a ledger whose texts are not UTF-8" fails 2 'damaged: column scene_path' "$program" report "$folder/many"/* --json
rm -rf "$folder/merged"/*.csv && : >"$folder/merged/merged.db-journal"
named plain
check "a journal that a merged ledger would find beside it" fails 2 'merged.db-journal: is left of another file' \
    "$program" merge "$folder/many" --out "$folder/merged"
check "which writes nothing" test ! -e "$folder/merged/scores.csv"

# ---- The cache --------------------------------------------------------------------------------------------------------------

check "the cache folder is the user's alone" test "$(stat -c %a "$folder/cache/viewworth")" = 700
seal=$(cat "$folder"/cache/viewworth/* | sha256sum)
chmod 777 "$folder/cache/viewworth"
mapped() { rm -rf "$folder/mapped" && run "$program" train "$scene" --out "$folder/mapped" --epochs 1 "${small[@]}" --quiet; }
check "one that others may write to" mapped
check "is told in one line" test "$(grep -c 'cache/viewworth: is not used, because another user' "$folder/stderr")" = 1
rm "$folder"/cache/viewworth/*
check "and not written" eval 'mapped && test -z "$(ls "$folder/cache/viewworth")"'
chmod 700 "$folder/cache/viewworth"
check "until it is private again" eval 'mapped && test "$(cat "$folder"/cache/viewworth/* | sha256sum)" = "$seal"'

# ---- Runs that come to nothing ----------------------------------------------------------------------------------------------

void=(--field mlp --mlp-depth 8 --width 16 --lr 1e6 --rays 64 --samples 16 --val-rays 64 --effects none --device llvmpipe --epochs 1
    --burn-in 0)
check "a short run without a finite step fails" fails 1 'no step was finite' "$program" value "$scene" --out "$folder/void" "${void[@]}" \
    --quiet
check "has no results" test ! -e "$folder/void/scores.csv" -a ! -e "$folder/void/SHA256SUMS"
check "and keeps its steps" test "$(query void 'SELECT count(*), sum(nonfinite), status FROM step, run')" = '7|6|failed'
printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.1\n1,0,a,nan,nan\n2,1,b,11,inf\n' >"$folder/void.csv"
check "so does a log of none" fails 2 'void.csv: no step has finite values' "$program" import-steps "$folder/void.csv" \
    --out "$folder/new/out"
check "before OUT is made" test ! -e "$folder/new"
printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.1\n1,0,a,11,0.1\n2,3,b,12,0.1\n' >"$folder/late.csv"
check "and one whose epochs no ledger has" fails 2 'late.csv:4: field epoch: "3"' "$program" import-steps "$folder/late.csv" \
    --out "$folder/new/out"
check "before OUT is made, too" test ! -e "$folder/new"
sed -i 's/^2,3/2,2/' "$folder/late.csv"
check "the last epoch that a ledger has is taken" run "$program" import-steps "$folder/late.csv" --out "$folder/new/out"
check "and read again" run "$program" verify "$folder/new/out"
conclude "$@"

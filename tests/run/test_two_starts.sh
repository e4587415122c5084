#!/usr/bin/env bash
# Two commands at once on one OUT: one wins, the other says so. A killed run leaves no lock. Hostile links send nothing elsewhere. Takes the
# program's path.
. "$(dirname "$0")/../support/program_test.sh"
tiny=("${small[@]}" --quiet)
printf 'view_001\nview_002\n' >"$folder/some"
busy='another viewworth process \(pid [0-9]+\) writes there; wait until it ends'

# ---- Two starts ----------------------------------------------------------------------------------------------------------

# pair OUT: starts twice at once. Exactly one run is made, and the other start says why it ends, at once and in one line.
pair() {
    local out=$folder/$1 codes=() pids=() i
    for i in 0 1; do
        "$program" train "$scene" --out "$out" --epochs 1 "${tiny[@]}" >"$out.$i.stdout" 2>"$out.$i.stderr" &
        pids[i]=$!
    done
    for i in 0 1; do wait "${pids[i]}"; codes[i]=$?; done
    local loser=$((codes[0] == 0))
    [[ ${codes[loser]} -eq 2 && ${codes[1 - loser]} -eq 0 && ! -s $out.$loser.stdout && $(wc -l <"$out.$loser.stderr") -eq 1 ]] &&
        grep -qE "^viewworth: .*$out: ($busy|another viewworth process writes there|already contains a run)" "$out.$loser.stderr" &&
        "$program" verify "$out" --quiet >/dev/null && rm -rf "$out"* && return
    echo "exit codes ${codes[*]}"
    cat "$out".*.stderr
    return 1
}
pairs() { local i; for ((i = 1; i <= $1; i++)); do pair "pair_$i" || return; done; }
check "20 times two starts at once: one wins, with its ledger intact" pairs 20

# ---- While a run goes on -------------------------------------------------------------------------------------------------

"$program" value "$scene" --out "$folder/long" --epochs 100000 "${tiny[@]}" >"$folder/long.log" 2>&1 &
long=$!
until [[ -s $folder/long/ledger.db ]] || ! kill -0 "$long" 2>/dev/null; do sleep 0.05; done
refuses() { fails 2 "/long: $busy" "$program" "$@"; }
check "value says that a run goes on" refuses value "$scene" --out "$folder/long" "${tiny[@]}"
check "value --resume" refuses value "$scene" --out "$folder/long" --resume "${tiny[@]}"
check "train" refuses train "$scene" --out "$folder/long" "${tiny[@]}"
check "report" refuses report "$folder/long" --no-thumbnails
check "render" refuses render "$folder/long" --quiet --device llvmpipe
check "import-steps" fails 2 'already contains a run' "$program" import-steps "$folder/none.csv" --out "$folder/long"
for command in compare tradeoff; do
    more=()
    [[ $command != compare ]] || more=(--list "$folder/some" --list random)
    check "$command" refuses "$command" "$scene" --out "$folder/long" --epochs 4 "${more[@]}" "${tiny[@]}"
done
check "readers take no lock" prints 'report' "$program" report "$folder/long" --no-thumbnails --to "$folder/elsewhere.html"
check "the run itself goes on" kill -0 "$long"
kill -KILL "$long"
wait "$long" 2>/dev/null

"$program" value "$scene" --out "$folder/long" --epochs 100000 "${tiny[@]}" --resume >"$folder/long.log" 2>&1 &
long=$!
until [[ $(<"$folder/long/.viewworth.lock") == "$long" ]] || ! kill -0 "$long" 2>/dev/null; do sleep 0.05; done
check "a killed run can be resumed at once" kill -KILL "$long"
wait "$long" 2>/dev/null

# ---- What is refused leaves nothing ---------------------------------------------------------------------------------------

check "a refused start" fails 2 'no such scene' "$program" value "$folder/none" --out "$folder/a" "${tiny[@]}"
check "leaves no folder" test ! -e "$folder/a"

# ---- Hostile links --------------------------------------------------------------------------------------------------------

mkdir "$folder/mine" && echo precious >"$folder/mine/file"
untouched() { [[ $(ls "$folder/mine") == file && $(<"$folder/mine/file") == precious ]]; }
hostile() { # hostile NAME PATTERN COMMAND...: refused with OUT/NAME a link to a folder or to a file of ours
    local name=$1 pattern=$2 target=$folder/mine
    shift 2
    rm -rf "$folder/hostile" && mkdir -p "$(dirname "$folder/hostile/$name")"
    [[ $name != *.* ]] || target=$folder/mine/file
    ln -s "$target" "$folder/hostile/$name"
    fails 2 "hostile/$pattern.*through a link" "$program" "$@" --out "$folder/hostile" "${tiny[@]}" && untouched
}
check "renders/ a link" hostile renders renders compare "$scene" --list "$folder/some" --list random --epochs 2
check "renders/retrainings/ a link" hostile renders/retrainings renders/retrainings \
    compare "$scene" --list "$folder/some" --list random --epochs 2
check "configurations/ a link" hostile configurations configurations tradeoff "$scene" --epochs 2 --parameters rays
check "a link in place of a file" hostile scores.csv scores.csv value "$scene" --epochs 2 # test_out_lock.c has the others
conclude

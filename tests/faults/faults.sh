# For scripts/faults, to be sourced after $program, $root, $build and $folder are set: how a run is started with a fault, and how what it
# leaves is judged. Every injection adds a line "FAULT|OUTCOME|STEPS" to $folder/outcomes, and one to $folder/problems for each rule that
# is broken: no crash, one line that names the remedy, nothing half-written, no recorded step lost, equal rows after --resume.

. "$root/tests/support/run_rows.sh"
scene=$root/tests/support/tiny.json
tiny=(--rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 6 --width 16
    --device llvmpipe --quiet)
training=(--epochs 20 --effects none "${tiny[@]}")
# The clock jumps when some steps are taken, so that a checkpoint is due in the middle of a run of half a second.
checkpoint_early=(FAULT_CLOCK=40 FAULT_CLOCK_STEADY=1 FAULT_CLOCK_AFTER=12)
preloaded=$build/faults/fault_calls.so
layer=(VK_INSTANCE_LAYERS=VK_LAYER_VIEWWORTH_faults VK_LAYER_PATH="$build/faults")

whole=whole # the undisturbed run that others are compared with

# value OUT [SETTING=VALUE]... [COMMAND...]: the run, with these settings of tests/faults/fault_calls.c and fault_layer.c
value() {
    exec env "${@:2}" "$program" value "$scene" --out "$folder/$1" --resume "${training[@]}" \
        >"$folder/$1.stdout" 2>"$folder/$1.stderr" </dev/null
}

# undisturbed OUT: makes the run that others are compared with from now on
undisturbed() {
    whole=$1
    (value "$1") || { cat "$folder/$1.stderr"; exit 1; }
    rows "$1" >"$folder/$1.rows"
    query "$1" 'SELECT * FROM step ORDER BY step' >"$folder/$1.steps"
}

# ---- Rules ---------------------------------------------------------------------------------------------------------------

problem() { # problem OUT TEXT
    echo "$1: $2" >>"$folder/problems"
}

# A hashed file (field, checkpoint) ends with the SHA-256 of what is before.
is_whole() { [[ $(head -c -32 "$1" | sha256sum | cut -c 1-64) == $(tail -c 32 "$1" | od -An -v -tx1 | tr -d ' \n') ]]; }

# Every output is absent, or old or new and whole.
check_outputs() { # check_outputs OUT
    local file name
    for file in "$folder/$1"/*; do
        name=${file##*/}
        case $name in
        checkpoint_?.vwc) is_whole "$file" || problem "$1" "$name is not whole" ;;
        field.vwf | *.csv) cmp -s "$file" "$folder/$whole/$name" || problem "$1" "$name is neither absent nor that of the whole run" ;;
        report.html) [[ $(tail -c 8 "$file" | tr -d '\n') == "</html>" ]] || problem "$1" "$name is not whole" ;;
        esac
    done
}

# A journal may stay where there was no way to end a transaction: who goes on with the run ends it.
check_leftovers() { # check_leftovers OUT [journal]
    local left
    left=$(find "$folder/$1" -name '*.part*' -printf '%f ' -o -name '*-journal' ! -name "ledger.db-${2:-}" -printf '%f ')
    [[ -z $left ]] || problem "$1" "leaves behind $left"
}

check_message() { # check_message OUT: one line beside warnings, with a remedy behind a semicolon, and with $says
    local stderr=$folder/$1.stderr
    [[ $(grep -vc '^warning: ' "$stderr") -eq 1 ]] && grep -qE "^viewworth: .*${says:-}.*; ." "$stderr" && return
    problem "$1" "is not one line that names a remedy: $(tr '\n' '~' <"$stderr")"
}

# A copy of the ledger in which SQLite has ended the transaction of whoever was killed. `verify`, which never writes, asks for that,
# if there is one.
roll_back() { # roll_back OUT: prints the name of the copy
    "$program" verify "$folder/$1" >"$folder/$1.verify" 2>&1 || grep -qE '^viewworth: .*--resume' "$folder/$1.verify" ||
        problem "$1" "verify: $(<"$folder/$1.verify")"
    mkdir "$folder/$1.copy"
    cp "$folder/$1"/ledger.db* "$folder/$1.copy"
    query "$1.copy" 'BEGIN IMMEDIATE; COMMIT'
    echo "$1.copy"
}

# The ledger is intact, and its steps are the first of the whole run. Prints how many.
check_ledger() { # check_ledger OUT
    local steps=0 copy=$1
    if [[ -e $folder/$1/ledger.db ]]; then
        [[ ! -s $folder/$1/ledger.db-journal ]] || copy=$(roll_back "$1")
        "$program" verify "$folder/$copy" >"$folder/$1.verify" 2>&1 || problem "$1" "verify: $(<"$folder/$1.verify")"
        steps=$(query "$copy" 'SELECT count(*) FROM step')
        diff -q <(query "$copy" 'SELECT * FROM step ORDER BY step') <(head -n "$steps" "$folder/$whole.steps") >/dev/null ||
            problem "$1" "its steps are not those of the whole run"
    fi
    echo "$((steps > 0 ? steps - 1 : 0))"
}

# The run goes on to the same rows, field and tables. Prints how many recorded steps were taken again, to compare them.
check_resume() { # check_resume OUT RECORDED_STEPS
    local out=$1 from training=("${training[@]/--quiet/}")
    mapfile -t training < <(printf '%s\n' "${training[@]}" | grep .)
    (value "$out") || { problem "$out" "is not resumed: $(grep '^viewworth: ' "$folder/$out.stderr")"; return; }
    from=$(sed -nE 's/^resume .*from (the checkpoint of )?step ([0-9]+);.*/\2/p' "$folder/$out.stderr")
    diff -q <(rows "$out") "$folder/$whole.rows" >/dev/null || problem "$out" "its rows after --resume are not those of the whole run"
    check_outputs "$out"
    [[ -e $folder/$out/field.vwf && -e $folder/$out/scores.csv && -e $folder/$out/report.html ]] || problem "$out" "an output is missing"
    check_leftovers "$out"
    "$program" verify "$folder/$out" >/dev/null 2>&1 || problem "$out" "verify fails after --resume"
    echo "$((${from:-$2} <= $2 ? $2 - ${from:-$2} : 0))"
}

# judge FAULT OUT CODE [SIGNAL]: SIGNAL is the one that was sent
judge() {
    local fault=$1 out=$2 code=$3 outcome recorded again
    case $code in
    0) outcome='went on' ;;
    1 | 2)
        outcome=message
        check_message "$out"
        ;;
    "$((128 + ${4:-0}))") outcome=killed ;;
    *)
        outcome=crashed
        problem "$out" "ends with code $code: $(tail -n 3 "$folder/$out.stderr" | tr '\n' '~')"
        ;;
    esac
    check_outputs "$out"
    [[ $outcome == killed || ! -e $folder/$out ]] || check_leftovers "$out" journal
    recorded=$(check_ledger "$out")
    again=$(check_resume "$out" "$recorded")
    echo "$fault|$outcome|${again:-0}" >>"$folder/outcomes"
    grep -q "^$out: " "$folder/problems" || rm -rf "${folder:?}/$out" "$folder/$out".*
}

# ---- Injections ----------------------------------------------------------------------------------------------------------

# inject FAULT OUT SIGNAL (0: none) SETTING=VALUE...
inject() {
    local code=0
    { (value "$2" "${@:4}") || code=$?; } 2>/dev/null # where the shell says who was killed
    judge "$1" "$2" "$code" "$3"
}

# Two at a time: in_parallel COMMAND...
in_parallel() {
    while [[ $(jobs -rp | wc -l) -ge $workers ]]; do wait -n; done
    "$@" &
}

# spread COUNT: at most $most of the numbers 1 to COUNT, evenly spread
spread() {
    seq "$1" | awk -v most="$most" -v count="$1" 'int(NR * most / count + 0.5) > int((NR - 1) * most / count + 0.5) || count <= most'
}

spread_lines() { # at most $most lines of those given, evenly spread
    local lines i
    mapfile -t lines
    for i in $(spread "${#lines[@]}"); do echo "${lines[i - 1]}"; done
}

# For scripts/faults, to be sourced after faults.sh: one function fault_<name> for each fault of its table. They find in $folder what an
# undisturbed run calls: files.log, phases and device.log.

count_calls() { # makes those files
    (value counted "LD_PRELOAD=$preloaded" "FAULT_LOG=$folder/files.log" "FAULT_FOLDER=$folder/counted" "${checkpoint_early[@]}")
    (value counted_device "${layer[@]}" "FAULT_LOG=$folder/device.log")
    # The phase of every call that changes files. Temporary files belong to what they become: so the log is read from its end.
    tac "$folder/files.log" | awk '
        $2 == "rename" || $2 == "link" || $3 ~ /^ledger\.db/ { target = $3 }
        target ~ /^checkpoint/ { print "checkpoint"; next }
        target ~ /^(field|scores)/ { print "scores"; next }
        { print target ~ /^ledger/ ? "steps" : "report" }' | tac | awk '
        $1 == "scores" { scored = 1 }
        $1 == "steps" && (scored || NR <= 60) { $1 = scored ? "scores" : "first batch" }
        { print NR "|" $1 " " $2 }' | sed 's/ $//' >"$folder/phases"
}

# hit_call OUT NUMBER: this call that changes a file in OUT is hit
hit_call() { hit=("LD_PRELOAD=$preloaded" "FAULT_FOLDER=$folder/$1" "FAULT_FILE=$2" "${checkpoint_early[@]}"); }

half() { # half OUT: a run that was killed halfway
    local hit
    hit_call "$1" $(($(wc -l <"$folder/phases") / 2))
    { (value "$1" "${hit[@]}" FAULT_SIGNAL=9) || true; } 2>/dev/null
}

# ---- Files ---------------------------------------------------------------------------------------------------------------

fail_files() { # fail_files FAULT SETTING...: the calls that change files fail, one after the other
    local n hit
    for n in $(spread "$(wc -l <"$folder/phases")"); do
        hit_call "$1-$n" "$n"
        in_parallel inject "$1" "$1-$n" 0 "${hit[@]}" "${@:2}"
    done
}

fault_disk-full() { fail_files disk-full FAULT_ERROR=28 FAULT_REPEAT=1; }
fault_write-error() { fail_files write-error FAULT_ERROR=5; }

fault_read-only() { # from the start, and when a run goes on
    local hit out
    half read-only-half
    for out in read-only-new read-only-half; do
        hit_call "$out" 1
        inject read-only "$out" 0 "${hit[@]}" FAULT_ERROR=30 FAULT_REPEAT=1
    done
}

fault_slow-disk() { # every sync takes 20 ms: the run waits for the disk alone, and comes to the same end
    inject slow-disk slow-disk 0 "LD_PRELOAD=$preloaded" "FAULT_FOLDER=$folder/slow-disk" FAULT_SYNC_MS=20 "${checkpoint_early[@]}"
}

# On a disk of N KiB, which this user may be allowed to mount for himself.
on_small_disk() { # on_small_disk OUT KIB
    local code=0 out=$folder/$1
    mkdir "$out"
    export -f value
    # shellcheck disable=SC2016
    unshare -Urm bash -c 'mount -t tmpfs -o size="$2"k none "$1"; shift 2; "$@"; code=$?; cp -a "$0/." "$0.copy"; exit $code' "$out" \
        "$out" "$2" "$program" value "$scene" --out "$out" --resume "${training[@]}" >"$out.stdout" 2>"$out.stderr" || code=$?
    rm -r "$out"
    mv "$out.copy" "$out"
    judge small-disk "$1" "$code"
}

fault_small-disk() {
    local n
    if ! unshare -Urm mount -t tmpfs none "$folder" 2>/dev/null; then
        echo "small-disk is skipped: this user may not mount a disk (unshare -Urm)" >&2
        return
    fi
    for n in $(spread 140); do in_parallel on_small_disk "small-disk-$n" $((4 * n)); done # KiB; all files of the run have 500
}

# ---- The ledger ----------------------------------------------------------------------------------------------------------

fault_locked() { # for ever, and for a second
    half locked-long
    half locked-shortly
    coproc sqlite3 "$folder/locked-long/ledger.db"
    echo "BEGIN EXCLUSIVE; SELECT 'held';" >&"${COPROC[1]}"
    read -r _ <&"${COPROC[0]}"
    local code=0 writer=${COPROC[1]}
    (value locked-long "LD_PRELOAD=$preloaded" FAULT_SLEEP=1) || code=$?
    echo .quit >&"$writer"
    wait "$COPROC_PID" 2>/dev/null
    judge locked locked-long "$code"
    (echo 'BEGIN EXCLUSIVE;' && sleep 1) | sqlite3 "$folder/locked-shortly/ledger.db" &
    inject locked locked-shortly 0
    wait
}

# commands_refuse FAULT OUT: whatever reads a ledger takes it or says in one line why not
commands_refuse() {
    local command code outcome='went on'
    for command in 'verify OUT' 'value SCENE --out OUT --resume' 'report OUT' 'select OUT --to OUT/list.txt --rule top:3'; do
        read -ra words <<<"${command//OUT/$folder/$2}"
        words=("${words[@]/SCENE/$scene}")
        [[ ${words[0]} != value ]] || words+=("${training[@]}")
        code=0
        "$program" "${words[@]}" >"$folder/$2.stdout" 2>"$folder/$2.stderr" </dev/null || code=$?
        [[ $code -eq 0 ]] || outcome=message
        [[ $code -le 2 ]] || problem "$2" "$command ends with code $code"
        [[ $code -eq 0 || $code -gt 2 ]] || check_message "$2"
    done
    echo "$1|$outcome|0" >>"$folder/outcomes"
}

damage() { # damage OUT OFFSET_BYTES: inverts 16 bytes of a finished ledger
    local ledger=$folder/$1/ledger.db bytes
    cp -r "$folder/whole" "$folder/$1"
    bytes=$(dd if="$ledger" bs=1 skip="$2" count=16 status=none | od -An -v -tu1)
    for byte in $bytes; do printf "\\x$(printf %x $((byte ^ 255)))"; done |
        dd of="$ledger" bs=1 seek="$2" conv=notrunc status=none
    commands_refuse damaged "$1"
}

fault_damaged() {
    local n size
    size=$(stat -c %s "$folder/whole/ledger.db")
    for n in $(spread 400); do in_parallel damage "damaged-$n" $(((size - 16) * n / 400)); done
}

fault_newer() {
    cp -r "$folder/whole" "$folder/newer"
    sqlite3 "$folder/newer/ledger.db" 'PRAGMA user_version = 999'
    cp "$folder/newer/ledger.db" "$folder/newer.db"
    commands_refuse newer newer
    grep -q 'version' "$folder/newer.stderr" || problem newer "does not say that the version is another"
    cmp -s "$folder/newer.db" "$folder/newer/ledger.db" || problem newer "changes a ledger of another version"
}

# ---- Signals -------------------------------------------------------------------------------------------------------------

# Between and within the calls that change files; and before there are any, by time.
send_signals() { # send_signals FAULT NUMBER
    local phase n hit
    for phase in 'first batch' steps checkpoint scores report; do
        for n in $(awk -F '|' -v phase="$phase" '$2 == phase { print $1 }' "$folder/phases" | spread_lines); do
            hit_call "$1-$n" "$n"
            in_parallel inject "$1: $phase" "$1-$n" "$2" "${hit[@]}" "FAULT_SIGNAL=$2"
        done
    done
    wait
    send_early_signals "$1" "$2"
}

# ends_at LINE: when the run writes this line, in seconds; 0 if never
ends_at() {
    local line started=$EPOCHREALTIME training=("${training[@]/--quiet/--no-thumbnails}")
    (value timed) &
    until grep -q "^$1" "$folder/timed.stderr" 2>/dev/null; do sleep 0.002; done
    awk -v a="$started" -v b="$EPOCHREALTIME" 'BEGIN { print b - a }'
    wait
    rm -rf "$folder/timed"*
}

send_early_signals() { # send_early_signals FAULT NUMBER: while the scene is loaded, and during the pilot run of --effects auto
    local phase n from to whole=$whole
    local training=(--epochs 20 --effects auto "${tiny[@]}")
    undisturbed whole_auto
    to=$(ends_at scene)
    for phase in loading pilot; do
        from=0
        [[ $phase == loading ]] || from=$to to=$(ends_at field)
        for n in $(spread 1000); do
            in_parallel inject "$1: $phase" "$1-$phase-$n" "$2" timeout --foreground --preserve-status -s "$2" \
                "$(awk -v a="$from" -v b="$to" -v n="$n" 'BEGIN { print a + (b - a) * n / 1001 }')"
        done
        wait
    done
}

fault_kill() { send_signals kill 9; }
fault_terminate() { send_signals terminate 15; }

# ---- The device ----------------------------------------------------------------------------------------------------------

fail_device() { # fail_device FAULT KIND SETTING...: its submissions and waits, or its allocations
    local n
    for n in $(spread "$(grep -c " $2\$" "$folder/device.log")"); do in_parallel inject "$1" "$1-$n" 0 "${layer[@]}" "$3=$n" "${@:4}"; done
}

fault_device-lost() { fail_device device-lost device FAULT_DEVICE_LOST; }
fault_device-hangs() {
    local says='the device did not finish'
    fail_device device-hangs device FAULT_DEVICE_HANGS
    wait
}
fault_device-memory() {
    local says='no room for its [0-9.]+ MiB'
    fail_device device-memory allocation FAULT_DEVICE_MEMORY FAULT_REPEAT=1
    wait
}

# ---- The host ------------------------------------------------------------------------------------------------------------

fault_host-memory() { # at all places that allocate: ten times as many as of other faults
    local place most=$((10 * most))
    (value counted_memory "LD_PRELOAD=$preloaded" "FAULT_LOG=$folder/memory.log" FAULT_MEMORY=list "${checkpoint_early[@]}")
    for place in $(cut -d ' ' -f 3 "$folder/memory.log" | spread_lines); do
        in_parallel inject host-memory "host-memory-$place" 0 "LD_PRELOAD=$preloaded" "FAULT_MEMORY=$place" "${checkpoint_early[@]}"
    done
}

fault_clock() { # by a year and by a day back; with a budget, whose end is not the same
    local jump after steady
    for jump in 31536000 -86400; do
        for after in $(printf '%s\n' 3 20 | spread_lines); do
            for steady in 0 1; do
                in_parallel inject clock "clock-$jump-$after-$steady" 0 "LD_PRELOAD=$preloaded" "FAULT_CLOCK=$jump" \
                    "FAULT_CLOCK_AFTER=$after" "FAULT_CLOCK_STEADY=$steady"
            done
        done
        [[ $most -lt 2 && $jump -gt 0 ]] || in_parallel jump_while_training "$jump"
        [[ $most -lt 10 ]] || in_parallel jump_with_budget "$jump" # takes ten seconds
    done
}

jump_while_training() { # jump_while_training SECONDS: a checkpoint is written after a second, and one at the end
    local out=clock-checkpoint$1 training=("${training[@]/20/900}")
    (value "$out" "LD_PRELOAD=$preloaded" "FAULT_CLOCK=$1" FAULT_CLOCK_AFTER=20) || problem "$out" "fails: $(<"$folder/$out.stderr")"
    [[ -e $folder/$out/checkpoint_1.vwc ]] || problem "$out" "has written one checkpoint or none"
    echo "clock|went on|0" >>"$folder/outcomes"
}

jump_with_budget() { # jump_with_budget SECONDS
    local out=clock-budget$1 training=(--budget 10s --effects none --device llvmpipe --quiet)
    (value "$out" "LD_PRELOAD=$preloaded" "FAULT_CLOCK=$1" FAULT_CLOCK_AFTER=20 timeout 60) ||
        problem "$out" "fails: $(<"$folder/$out.stderr")"
    echo "clock|went on|0" >>"$folder/outcomes"
}

# ---- Photos --------------------------------------------------------------------------------------------------------------

photo() { # photo SHADE: 16 x 12 pixels
    printf 'P6\n16 12\n255\n'
    head -c 576 /dev/zero | tr '\0' "\\$(printf %o "$1")"
}

make_scene() { # make_scene FOLDER: five photos around the origin
    local i frames=()
    mkdir -p "$1"
    for i in 0 1 2 3 4; do
        photo $((60 + 20 * i)) >"$1/$i.ppm"
        frames+=("{\"file_path\": \"$i.ppm\", \"transform_matrix\": [[1,0,0,$i],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}")
    done
    (IFS=, && printf '{"w": 16, "h": 12, "fl_x": 20, "frames": [%s]}\n' "${frames[*]}") >"$1/transforms.json"
}

change() { # change HOW FILE
    case $1 in
    changed) photo 200 >"$2.new" && mv "$2.new" "$2" ;;
    cut) head -c 100 "$2" >"$2.new" && mv "$2.new" "$2" ;;
    removed) rm "$2" ;;
    esac
}

state() { query "$1" 'SELECT scene_hash FROM run' && rows "$1"; } # which photos, and what they gave

# Photos are hashed before the first step and decoded when they are needed. What was read of a photo is all from before a change, or all
# from after it.
swap_while_loading() { # swap_while_loading HOW N: when the photo is opened for the Nth time
    local out=photos-$1-$2 scene=$folder/scene-$1-$2 code=0
    make_scene "$scene"
    cp "$scene/1.ppm" "$scene.new"
    change "$1" "$scene.new"
    (value "$out" "LD_PRELOAD=$preloaded" "FAULT_SWAP=$scene.new" "FAULT_SWAP_TO=$scene/1.ppm" "FAULT_SWAP_AT=$2") || code=$?
    case $code in
    0)
        [[ $(state "$out") == "$(<"$folder/photos_old.state")" || $(state "$out") == "$(<"$folder/photos_new.state")" ]] ||
            problem "$out" "has the hash of one photo and the pixels of another"
        echo "photos|went on|0" >>"$folder/outcomes"
        ;;
    1 | 2) check_message "$out" && echo "photos|message|0" >>"$folder/outcomes" ;;
    *) problem "$out" "ends with code $code" ;;
    esac
}

change_after_loading() { # change_after_loading HOW: the run is halfway, is killed, and must not go on with another photo
    local out=photos-$1-half scene=$folder/scene-$1-half code=0
    make_scene "$scene"
    half "$out"
    cp "$scene/1.ppm" "$scene.old"
    change "$1" "$scene/1.ppm"
    (value "$out") || code=$?
    [[ $code -eq 1 || $code -eq 2 ]] && check_message "$out" || problem "$out" "goes on with another photo: code $code"
    cp "$scene.old" "$scene/1.ppm"
    judge photos "$out" "$code"
}

fault_photos() {
    local how n scene=$folder/photos
    make_scene "$scene"
    undisturbed photos_new # the name of the run that has the changed photo in the end
    state photos_new >"$folder/photos_old.state"
    for how in changed cut removed; do change_after_loading "$how"; done
    change changed "$scene/1.ppm"
    rm -rf "$folder/photos_new"
    undisturbed photos_new
    state photos_new >"$folder/photos_new.state"
    for how in changed cut; do
        for n in $(spread 5); do in_parallel swap_while_loading "$how" "$n"; done
    done
}

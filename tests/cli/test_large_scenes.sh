#!/usr/bin/env bash
# Scenes whose pixels do not fit --memory: the same result from a file that leaves nothing behind; a photo that cannot be decoded
# ends a run before its first step, a resumed one's ledger stands, and of two trainings only its own ends. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
export XDG_CACHE_HOME=$folder/cache
quick=("${small[@]}" --epochs 2 --no-thumbnails)

photo() { # photo SHADE: a PPM image of 16 x 12 pixels
    printf 'P6\n16 12\n255\n'
    local i
    for ((i = 0; i < 192; i++)); do printf '%b' "\\x$(printf %02x $(($1 + i % 16)))\\x60\\x30"; done
}

make_scene() { # make_scene FOLDER COUNT
    local i frames=()
    mkdir -p "$1"
    for ((i = 0; i < $2; i++)); do
        photo $((40 + 3 * i)) >"$1/$i.ppm"
        frames+=("{\"file_path\": \"$i.ppm\", \"transform_matrix\": [[1,0,0,$((i % 7))],[0,1,0,$((i / 7))],[0,0,1,4],[0,0,0,1]]}")
    done
    (IFS=, && printf '{"w": 16, "h": 12, "fl_x": 20, "frames": [%s]}\n' "${frames[*]}") >"$1/transforms.json"
}

value() { "$program" value "$folder/scene" --out "$folder/$1" "${quick[@]}" "${@:2}"; }
says() { grep -qE -- "$1" "$folder/stderr"; }
cache_is_clean() { [[ -z $(find "$folder/cache/viewworth" -type f ! -name 'pipelines-*' ! -name 'decisions*' 2>/dev/null) ]]; }

make_scene "$folder/scene" 40
check "a run in memory" run value heap --memory 1GB
check "it does not speak of a file" eval '! says "in a file of"'
check "the same run beyond --memory" run value mapped --memory 10kB
check "it says where the pixels are" says "pixels: .* more than --memory allows: in a file of $folder/cache/viewworth"
check "nothing else differs" same_run heap mapped
check "nothing is left in the cache" cache_is_clean
check "--memory needs a unit" fails 2 '--memory takes a size' "$program" value "$folder/scene" --out "$folder/none" --memory 10
check "--memory is above 0" fails 2 '--memory takes a size' "$program" value "$folder/scene" --out "$folder/none" --memory 0GB

# A disk without room: RLIMIT_FSIZE, which fails as a full disk does once its signal is ignored.
without_room() { (ulimit -f 8 && trap '' XFSZ && exec "$program" info "$folder/scene" --effects none --memory 10kB --quiet); }
check "a full disk" fails 1 "$folder/cache/viewworth.*: cannot reserve .* for pixels.*XDG_CACHE_HOME" without_room

# Killed while it has the file.
"$program" value "$folder/scene" --out "$folder/killed" "${small[@]}" --epochs 100000 --memory 10kB >/dev/null 2>&1 &
killed=$!
for ((i = 0; i < 600; i++)); do
    grep -q '(deleted)' "/proc/$killed/maps" 2>/dev/null && [[ -s $folder/killed/ledger.db ]] && break
    sleep 0.1
done
check "it maps a file without a name" grep -q 'cache/viewworth/.*(deleted)' "/proc/$killed/maps"
kill -9 "$killed"
wait "$killed" 2>/dev/null
check "nothing is left after kill -9" cache_is_clean

check "a run while all is well" run value resumed --quiet
# Twelve bytes short: a header that is fine, and pixels that are not.
head -c -12 "$folder/scene/33.ppm" >"$folder/short" && mv "$folder/short" "$folder/scene/33.ppm"
check "a photo that cannot be decoded" fails 1 '33.ppm: cannot decode the image' value broken --memory 10kB --quiet
check "it is seen before anything is recorded" test ! -e "$folder/broken/ledger.db"
check "a run that would go on ends" fails 2 'or one that has changed since' value resumed --quiet --resume --epochs 4
check "its ledger stands" run "$program" verify "$folder/resumed"

# Of two lists that are trained on at the same time, the one without that photo is finished and kept.
printf '%s.ppm\n' 33 34 35 >"$folder/broken.list"
printf '%s.ppm\n' 34 35 37 >"$folder/whole.list"
compare() {
    "$program" compare "$folder/scene" --list "$folder/broken.list" --list "$folder/whole.list" --seeds 1 --together 2 --quiet \
       --out "$folder/compared" "${small[@]}" --epochs 2
}
check "a list with it fails" fails 1 '33.ppm: cannot decode the image' compare
check "and takes no other along" test "$(sqlite3 "$folder/compared/retrainings.db" 'SELECT count(*) FROM retraining')" = 1
conclude "$@"

#!/usr/bin/env bash
# select from outside: a tiny scene of every format is valued, its photos selected, and the list opened again; what other programs read in it;
# names made to do harm; what is refused. Takes the program's path.
set -uo pipefail
program=$(realpath "$1")
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/support/shell_test.sh"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
. "$root/tests/support/run_rows.sh"
tiny=(--epochs 3 --rays 32 --samples 8 --val-rays 64 --levels 2 --log2-table 8 --width 16 --device llvmpipe --effects none --quiet)

# prints PATTERN COMMAND...: the command succeeds and its stdout has a line that matches.
prints() {
    "${@:2}" >"$folder/stdout" 2>"$folder/stderr" && grep -qE -- "$1" "$folder/stdout" && return
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# refuses PATTERN ARGUMENT...: exit code 2, nothing on stdout, and one line on stderr that matches.
refuses() {
    local code=0
    "$program" "${@:2}" --quiet >"$folder/stdout" 2>"$folder/stderr" || code=$?
    [[ $code -eq 2 && ! -s $folder/stdout && $(wc -l <"$folder/stderr") -eq 1 ]] && grep -qE "^viewworth: .*($1)" "$folder/stderr" && return
    echo "exit code $code:"
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# answers SQL COMMAND...: the command's stdout is JSON, nothing else, and the expression on it, called j, is true.
answers() {
    "${@:2}" >"$folder/answer.json" 2>"$folder/stderr" &&
        [[ $(sqlite3 :memory: "WITH answer AS (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)
            SELECT CASE WHEN json_valid(j) THEN ($1) END FROM answer") == 1 ]] && return
    cat "$folder/answer.json" "$folder/stderr"
    return 1
}

# file_says FILE SQL: the expression on a JSON file, called j, is true.
file_says() { answers "$2" cat "$1"; }

photo='iVBORw0KGgoAAAANSUhEUgAAAAgAAAAGCAIAAABxZ0isAAAAY0lEQVR4nA3JIQEAMQwEwYgIrpJTUhwRhSsguEpOyeOI+Q6dyCAX
KXKTh7ykyY9QoIWENjroIqMXFdSiRG3qUJcy9aKDXrToTR/60qZfOPDCwhsffLHxiwlmMWI2c5jLmPn4AeieQjFag8aUAAAAAElFTkSuQmCC' # 8 x 6 pixels

# write_photo FILE NUMBER: a photo unlike the others.
write_photo() {
    mkdir -p "$(dirname "$1")"
    base64 -d <<<"$photo" >"$1"
    printf '%s' "$2" >>"$1" # behind the image's end: only its hash differs
}

# ---- Scenes: 16 photos on a circle, of which 0 and 8 validate and 4 and 12 test, unless the files say otherwise ---------------

# Names that would do harm in a spreadsheet, a shell, a query or a page.
names=(p00.png '=cmd().png' '+1+1.png' "quote'; DROP TABLE image;--.png" 'p04.png' 'comma, "double".png' '-dash.png' '@at.png' 'p08.png'
    'süß 写真.png' '$(touch x) `y`.png' '<b>&amp;.png' 'p12.png' '%s%n.png' 'sub/p14.png' 'p15.png')

{
    echo 'CREATE TABLE photo(i, name);'
    for i in "${!names[@]}"; do echo "INSERT INTO photo VALUES ($i, '${names[i]//\'/\'\'}');"; done
} | sqlite3 "$folder/photos.db"

# frames PREFIX WHERE: an array of frames of transforms.json for these photos, with keys that viewworth does not read.
frames() {
    sqlite3 "$folder/photos.db" "SELECT json_group_array(json_object('file_path', '$1' || name, 'sharpness',
        json(printf('%d.345678901234567', 12 + i)), 'depth_file_path', 'depth/' || i || '.png', 'colmap_im_id', 9007199254740993,
        'transform_matrix', json_array(json_array(cos(a), 0, sin(a), 3 * sin(a)), json_array(0, 1, 0, json('0.10000000000000001')),
            json_array(-sin(a), 0, cos(a), 3 * cos(a)), json_array(0, 0, 0, 1)))) FROM (SELECT *, i * 0.39269908169872414 AS a FROM photo)
        WHERE $2"
}

write_photos() { # write_photos FOLDER
    local i
    for i in "${!names[@]}"; do write_photo "$1/${names[i]}" "$i"; done
}

# The model of the same cameras, in FOLDER.
write_model() {
    local i
    mkdir -p "$1"
    echo '1 PINHOLE 8 6 9.5 9.25 4.125 3.0625' >"$1/cameras.txt"
    for i in "${!names[@]}"; do
        awk -v i="$i" 'BEGIN { a = i * 0.39269908169872414; printf "%d 0 %.17g 0 %.17g 0 -0.1 3 1 ", 100 + i, cos(a / 2), -sin(a / 2) }'
        printf '%s\n\n' "${names[i]}"
    done >"$1/images.txt"
    : >"$1/points3D.txt"
}

single=$folder/single
write_photos "$single/images"
printf '{"fl_x": 9.5, "fl_y": 9.25, "cx": 4.125, "cy": 3.0625, "w": 8, "h": 6, "k1": 0.1000000000000000055, "aabb_scale": 16,
    "ply_file_path": "points.ply", "frames": %s, "applied_scale": 0.30000000000000004}\n' "$(frames images/ 1)" \
    >"$single/transforms.json"

blender=$folder/blender
write_photos "$blender/pictures"
write_blender() { printf '{"camera_angle_x": 0.8, "frames": %s}\n' "$(frames ./pictures/ "$2")" >"$blender/transforms_$1.json"; }
write_blender train 'i % 4 IN (1, 2)'
write_blender val 'i % 4 = 3'
write_blender test 'i % 4 = 0'

colmap=$folder/colmap
write_photos "$colmap/images"
write_model "$colmap/sparse/0"

tourism=$folder/tourism
write_photos "$tourism/dense/images"
write_model "$tourism/dense/sparse"
{
    printf 'id\tsplit\tfilename\tdataset\n'
    printf '%s\n' "107.0 train" " train" "103.0 test" "101.0 test" "109 train" "110 train" "104.0 test" "105.0 train" " test" | {
        i=0
        while IFS=' ' read -r id split; do
            [[ -n $split ]] || { split=$id id=; }
            printf '%s\t%s\t%s\ttiny\n' "$id" "$split" "${names[i++]}"
        done
    }
    printf '7\ttrain\tnot registered.png\ttiny\n8\ttest\tnor this.png\ttiny\n'
} >"$tourism/tiny.tsv"

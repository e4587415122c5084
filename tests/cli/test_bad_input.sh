#!/usr/bin/env bash
# Broken and hostile input: each is refused with exit code 2, one line that names file and field, and no --out folder. Prints the table of
# cases. tests/scene and tests/fuzz refuse more in each format. Usage: test_bad_input.sh PROGRAM
set -uo pipefail
program=$(realpath "$1")
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/support/shell_test.sh"

folder=$(mktemp -d)
trap 'umount "$folder/full" 2>/dev/null; rm -rf "$folder"' EXIT
scene=$folder/scene
out=$folder/out
tiny=(--epochs 3 --rays 64 --samples 16 --val-rays 64 --levels 4 --log2-table 10 --width 16)
device=(--device llvmpipe)
variables=()
as_nobody=()
seconds_most=60
chmod 777 "$folder"

# become_nobody: from here on cases run without root's right to read and write everything; fails where that cannot be done.
become_nobody() {
    [[ $EUID -ne 0 ]] && return
    as_nobody=(setpriv --reuid=65534 --regid=65534 --clear-groups)
    "${as_nobody[@]}" "$program" --version >"$folder/stdout" 2>&1 && return
    as_nobody=()
    return 1
}

# ---- Cases ----------------------------------------------------------------------------------------------------------------

# run_case WANTED_CODE CASE PATTERN ARGUMENT...: runs `value ARGUMENT... --out OUT`, prints a row of the table, and passes when the exit
# code and the only line, which is on stderr, are as wanted and no --out folder is left.
run_case() {
    local wanted=$1 what=$2 pattern=$3 code=0 message
    shift 3
    timeout "$seconds_most" env ${variables[@]+"${variables[@]}"} ${as_nobody[@]+"${as_nobody[@]}"} \
        "$program" value "$@" --out "$out" --quiet "${tiny[@]}" "${device[@]}" >"$folder/stdout" 2>"$folder/stderr" </dev/null || code=$?
    message=$(sed "s,$folder/,,g" "$folder/stderr")
    printf '%-44s | %d | %s\n' "$what" "$code" "$message"
    [[ $code -eq $wanted && ! -s $folder/stdout && ! -e $out && $(wc -l <"$folder/stderr") -eq 1 ]] &&
        grep -qE "^viewworth: .*($pattern)" "$folder/stderr" && { passed=$((passed + 1)); return; }
    failed=$((failed + 1))
    echo "[  FAILED  ] $what: wanted exit code $wanted and one line with: $pattern"
    rm -rf "$out"
}
refused() { run_case 2 "$@"; }

# reset: a fresh scene folder of three good photos.
reset() {
    rm -rf "$scene"
    mkdir -p "$scene/images"
    local i
    for i in 0 1 2; do base64 -d <<<"$photo" >"$scene/images/$i.png"; done
}
photo='iVBORw0KGgoAAAANSUhEUgAAAAgAAAAGCAIAAABxZ0isAAAAY0lEQVR4nA3JIQEAMQwEwYgIrpJTUhwRhSsguEpOyeOI+Q6dyCAX
KXKTh7ykyY9QoIWENjroIqMXFdSiRG3qUJcy9aKDXrToTR/60qZfOPDCwhsffLHxiwlmMWI2c5jLmPn4AeieQjFag8aUAAAAAElFTkSuQmCC' # 8 x 6 pixels
one='[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]'

# frame NAME [MATRIX [KEYS]]: a frame of transforms.json.
frame() { printf '{%s "file_path": "%s", "transform_matrix": %s}' "${3-}" "$1" "${2-$one}"; }
# transforms KEYS FRAME...: writes transforms.json.
transforms() {
    local keys=$1 IFS=,
    shift
    printf '{%s "frames": [%s]}\n' "$keys" "$*" >"$scene/transforms.json"
}
good=("$(frame images/0.png)" "$(frame images/1.png)" "$(frame images/2.png)")

# with_matrix CASE PATTERN MATRIX: refused because of the pose of the second photo.
with_matrix() {
    reset
    transforms '"fl_x": 8,' "${good[0]}" "$(frame images/1.png "$3")" "${good[2]}"
    refused "$1" "transforms.json.*($2)" "$scene"
}
with_keys() {
    reset
    transforms "$3" "${good[@]}"
    refused "$1" "transforms.json.*($2)" "$scene"
}
# with_photo CASE PATTERN: refused because of what became of images/1.png.
with_photo() {
    transforms '"fl_x": 8,' "${good[@]}"
    refused "$1" "images/1.png.*($2)" "$scene"
}
with_name() {
    transforms '"fl_x": 8,' "${good[0]}" "$(frame "$3")" "${good[2]}"
    refused "$1" "transforms.json: frame 1 .*file_path.*($2)" "$scene"
}

printf '%-44s | %s | %s\n' case code message

# ---- transforms.json ------------------------------------------------------------------------------------------------------

reset
printf '{"fl_x": 8,\n "frames": [}\n' >"$scene/transforms.json"
refused "JSON syntax error" 'transforms.json:2:[0-9]+: not valid JSON' "$scene"
with_matrix "NaN in a matrix" ':1:[0-9]+: not valid JSON.*NaN' '[[NaN,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]'
with_matrix "1e999 in a matrix" ':1:[0-9]+: not valid JSON.*1e999' '[[1,0,0,1e999],[0,1,0,0],[0,0,1,0],[0,0,0,1]]'
with_matrix "a matrix that is no rotation" 'transform_matrix.*not a rotation' '[[1,0.5,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]'
with_keys "a focal length of 0" 'field fl_x' '"fl_x": 0,'
with_keys "a key twice" ':1:[0-9]+:.*duplicate' '"fl_x": 8, "fl_x": 9,'
reset
head -c 20000 /dev/zero | tr '\0' '[' >"$scene/transforms.json"
refused "JSON nested 20,000 deep" 'transforms.json:1:[0-9]+:.*depth' "$scene"
reset
yes '{},' | head -n 4000000 | tr -d '\n' >"$scene/transforms.json"
refused "JSON of 4 million objects" 'transforms.json:1:[0-9]+:.*too much memory' "$scene"
reset
truncate -s 1000000000 "$scene/transforms.json"
refused "JSON of 1 GB" 'transforms.json: larger than' "$scene"
reset
printf '\x00\xff\xfe not JSON' >"$scene/transforms.json"
refused "bytes that are no text" 'transforms.json:1:' "$scene"
refused "no such scene" 'none: no such scene' "$folder/none"
mkdir -p "$folder/empty"
refused "an empty folder" 'empty: no scene found' "$folder/empty"

zeros() { head -c "$1" /dev/zero; }

# ---- Photos ---------------------------------------------------------------------------------------------------------------

reset
rm "$scene/images/1.png"
mkdir "$scene/images/1.png"
with_photo "a folder in place of a photo" 'not a plain file'
reset
rm "$scene/images/1.png"
mkfifo "$scene/images/1.png"
with_photo "a pipe in place of a photo" 'not a plain file'
reset
: >"$scene/images/1.png"
with_photo "a photo of 0 bytes" 'cannot open the image'
reset
printf 'FOR4\0\0\0\x40CIMGTBHD\0\0\0\x20\x7f\xff\xff\xff\0\0\0\0\0\0\0\0' >"$scene/images/1.png"
with_photo "an IFF in place of a photo" 'no format that is read, which are PNG, JPEG'
echo 'not a photo' >"$scene/images/1.null?RES=16000x16000"
transforms '"fl_x": 8,' "${good[0]}" "$(frame 'images/1.null?RES=16000x16000')" "${good[2]}"
refused "a name that asks OpenImageIO for 256 megapixels" 'RES=16000x16000: cannot open.*no format that is read' "$scene"
reset
{ printf '\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x01\x86\xa0\x00\x01\x86\xa0\x08\x02\x00\x00\x00\x27\x30\x9c\x9f'
    printf '\x00\x00\x00\x00IDAT\x35\xaf\x06\x1e'; } >"$scene/images/1.png"
with_photo "a PNG of 100,000 x 100,000 pixels" '100000 x 100000 pixels'
reset
truncate -s 50 "$scene/images/1.png"
transforms '"fl_x": 8,' "${good[@]}"
run_case 1 "a photo cut off behind its header" 'images/1.png: cannot decode' "$scene"
reset
chmod 0 "$scene/images/1.png"
if become_nobody; then
    with_photo "a photo that may not be read" 'Permission denied'
    as_nobody=()
else
    echo "SKIPPED: a photo that may not be read: root may read everything"
fi
reset
with_name "a name with .." 'leaves the scene folder' ../scene/images/1.png
with_name "a name with .. inside" 'leaves the scene folder' images/../../scene/images/1.png
with_name "an absolute name" 'leaves the scene folder' "$scene/images/1.png"
with_name "a name with a line end" 'control characters' 'images/1.png\nviewworth: fine'
cp "$scene/images/1.png" "$folder/elsewhere.png"
ln -sf "$folder/elsewhere.png" "$scene/images/1.png"
with_name "a link that leaves the folder" 'through a link' images/1.png
rm "$scene/images/1.png"
ln -s / "$scene/images/away"
with_name "a linked folder that leaves the folder" 'through a link' "images/away$folder/elsewhere.png"
reset
mv "$scene/images" "$folder/images"
ln -s "$folder/images" "$scene/images"
transforms '"fl_x": 8,' "${good[@]}"
refused "images/ a link that leaves the folder" 'through a link' "$scene"
rm -rf "$folder/images"
reset
transforms '"fl_x": 8,' "${good[@]}"
mv "$scene/transforms.json" "$folder/t.json"
ln -s "$folder/t.json" "$scene/transforms.json"
refused "transforms.json a link that leaves the folder" 'through a link' "$scene"
reset
transforms '"fl_x": 8,' "${good[0]}" "${good[1]}" "${good[0]}"
refused "a photo twice" 'frame 2 .*appears twice' "$scene"
transforms '"fl_x": 8,' "$(frame images/0.png "$one" '"mask_path": "../m.png",')" "${good[1]}" "${good[2]}"
refused "a mask with .." 'mask_path leaves' "$scene"
transforms '"fl_x": 8,' "$(frame images/0.png "$one" '"mask_path": "m.png",')" "${good[1]}" "${good[2]}"
refused "a mask that is not there" 'mask_path: .*does not exist' "$scene"

# ---- Splits ---------------------------------------------------------------------------------------------------------------

reset
transforms '"fl_x": 8,' "${good[0]}"
refused "a single photo" 'a single photo' "$scene"
transforms '"fl_x": 8,' "${good[0]}" "${good[1]}"
refused "nothing to validate" 'no view is left to validate' "$scene"
transforms '"fl_x": 8,' "${good[@]}"
: >"$folder/list"
refused "an empty list" 'list: has no names' "$scene" --val "$folder/list"
printf 'images/9.png\n' >"$folder/list"
refused "a list that names no photo of the scene" 'list:1: images/9.png' "$scene" --val "$folder/list"
printf 'images/0.png\nimages/1.png\n' >"$folder/list"
printf 'images/1.png\n' >"$folder/list2"
refused "a photo in two lists" 'list2:1: images/1.png is in two splits' "$scene" --train "$folder/list" --val "$folder/list2"
reset
transforms '"fl_x": 8,' "${good[@]}"
printf 'name,provider\nimages/0.png\n' >"$folder/list"
refused "a providers file with a field too few" 'list:2: there must be two fields' "$scene" --providers "$folder/list"
refused "an unknown format" 'format bundler' "$scene" --format bundler

# ---- COLMAP and PhotoTourism: three photos of one SIMPLE_PINHOLE camera, and a point that two of them see ------------------

u32() { printf "\\x$(printf %x $(($1 & 255)))\\x$(printf %x $(($1 >> 8 & 255)))\\x0\\x0"; } # below 2^16
u64() { u32 "$1"; zeros 4; }
real() { zeros 6; printf "\\x${1:2:2}\\x${1:0:2}"; } # by its two highest bytes
one_real=3ff0 two_real=4000 three_real=4008 four_real=4010 eight_real=4020
huge_count='\xff\xff\xff\xff\xff\xff\xff\x7f'    # 2^63 - 1

colmap_camera() { u32 1; u32 "${2-0}"; u64 8; u64 6; real "${1-$eight_real}"; real "$four_real"; real "$three_real"; }
colmap_image() { # ID NAME [QUATERNION_W]
    u32 "$1"; real "${3-$one_real}"; zeros 24; real "$one_real"; zeros 16; u32 1
    printf '%s\0' "$2"; u64 1; real "$four_real"; real "$three_real"; u64 1
}
colmap_point() { u64 1; real "${1-$one_real}"; zeros 8; real "$two_real"; zeros 3; real "$one_real"; u64 2; u32 1; u32 0; u32 2; u32 0; }
colmap() { # a fresh scene folder with a model in sparse/0
    reset
    model=$scene/sparse/0
    mkdir -p "$model"
    { u64 1; colmap_camera; } >"$model/cameras.bin"
    { u64 3; colmap_image 1 0.png; colmap_image 2 1.png; colmap_image 3 2.png; } >"$model/images.bin"
    { u64 1; colmap_point; } >"$model/points3D.bin"
}
in_model() { refused "$1" "sparse/0/$2" "$scene"; }

colmap
check "the COLMAP scene is good before it is broken" "$program" info "$scene" --pilot-steps 0 "${device[@]}" --quiet >"$folder/stdout"
for file in cameras images points3D; do
    colmap
    truncate -s -1 "$model/$file.bin"
    in_model "$file.bin cut short by a byte" "$file.bin"
    colmap
    printf "$huge_count" | dd of="$model/$file.bin" conv=notrunc status=none
    in_model "$file.bin with a count of 2^63-1" "$file.bin"
done
colmap
for name in ../0.png /etc/passwd; do
    { u64 3; colmap_image 1 "$name"; colmap_image 2 1.png; colmap_image 3 2.png; } >"$model/images.bin"
    in_model "the name $name in images.bin" 'images.bin'
done
colmap
rm "$model/images.bin"
refused "a model without images" 'sparse/0: .*images' "$scene"
colmap
cp "$scene/images/0.png" "$folder/cameras.bin"
ln -sf "$folder/cameras.bin" "$model/cameras.bin"
in_model "cameras.bin a link that leaves the folder" 'cameras.bin.*link'

tsv() { # a fresh PhotoTourism folder with this TSV
    colmap
    mkdir "$scene/dense"
    mv "$scene/images" "$scene/dense/images"
    mv "$model" "$scene/dense/sparse"
    printf "$1" >"$scene/splits.tsv"
}
tsv 'filename\tid\tsplit\n0.png\t1\ttrain\n1.png\t2\tval\n'
refused "a TSV with an unknown split" 'splits.tsv:3: field split' "$scene"
tsv 'filename\tid\tsplit\n../0.png\t1\ttrain\n'
refused "a TSV with a name with .." 'splits.tsv:2: field filename' "$scene"

# ---- Recipes --------------------------------------------------------------------------------------------------------------

recipe() { # CASE PATTERN SED_EXPRESSION: the recipe clean.json, changed
    sed -E "$3" "$root/scenes/clean.json" >"$folder/recipe.json"
    refused "$1" "recipe.json.*($2)" "$folder/recipe.json"
}
recipe "a recipe of 10^9 pixels a side" 'width_px' 's/"width_px": *[0-9]+/"width_px": 1000000000/'
recipe "a recipe of 4096 cameras of 4096 x 4096 pixels" 'pixels' \
    's/"count": *[0-9]+/"count": 4096/; s/"(width|height)_px": *[0-9]+/"\1_px": 4096/g'
recipe "a recipe with an unknown key" 'unknown key' 's/"width_px"/"width_pixels"/'

# ---- The machine ----------------------------------------------------------------------------------------------------------

reset
transforms '"fl_x": 8,' "${good[@]}"
keep_out=$out
out=$scene/images/0.png
code=0
"$program" value "$scene" --out "$out" --quiet "${tiny[@]}" "${device[@]}" >"$folder/stdout" 2>"$folder/stderr" || code=$?
printf '%-44s | %d | %s\n' "--out is a file" "$code" "$(sed "s,$folder/,,g" "$folder/stderr")"
check "--out that is a file is refused" test "$code $(wc -l <"$folder/stderr")" = '2 1'
out=/proc/viewworth
refused "--out where no folder can be made" 'out /proc/viewworth: cannot write' "$scene"
if become_nobody; then
    mkdir "$folder/locked"
    chmod 555 "$folder/locked"
    out=$folder/locked/out
    refused "--out that is not writable" 'locked: Permission denied' "$scene"
    as_nobody=()
else
    echo "SKIPPED: --out that is not writable: root may write everywhere"
fi
mkdir "$folder/full"
if mount -t tmpfs -o size=64k tmpfs "$folder/full" 2>/dev/null; then
    out=$folder/full/out
    refused "a disk that is full at the start" 'cannot write in .*full: No space left' "$scene"
else
    echo "SKIPPED: a disk that is full at the start: a small file system cannot be mounted here"
fi
out=$keep_out
# Photos that are missing are left out; that is said even with --quiet, and stands in the report.
reset
cp "$scene/images/0.png" "$scene/images/3.png"
cp "$scene/images/1.png" "$scene/images/4.png"
transforms '"fl_x": 8,' "${good[@]}" "$(frame images/3.png)" "$(frame images/4.png)" "$(frame images/lost.png)"
check "a photo that is missing does not stop a run" "$program" value "$scene" --out "$folder/lost" --quiet "${tiny[@]}" "${device[@]}" \
    2>"$folder/stderr"
check "it is a warning" grep -q 'warning: .*1 photos skipped: their image file does not exist (first: images/lost.png)' "$folder/stderr"
check "and stands in the report" grep -q 'photos skipped.*lost.png' "$folder/lost/report.html"
mkdir "$folder/elsewhere"
cp "$program" "$folder/elsewhere/viewworth"
keep_program=$program
program=$folder/elsewhere/viewworth
run_case 1 "a program without viewworth-decode beside it" 'images/0.png.*cannot start viewworth-decode.*neither beside the program' "$scene"
program=$keep_program
device=()
variables=(VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent)
refused "no Vulkan device" '[Vv]ulkan' "$scene"
conclude "$@"

#!/usr/bin/env bash
# Broken and hostile input, from outside: a few cases are refused with exit code 2, one line that names file and field, and no --out folder.
# Prints the table of cases. tests/scene, tests/image and tests/fuzz try all cases of each format. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"
scene=$folder/scene
out=$folder/out
tiny=(--epochs 3 "${small[@]:0:18}")
device=(--device llvmpipe)
variables=()
as_nobody=()
seconds_most=60
chmod 777 "$folder"

# become_nobody: from here on cases run without root's right to read and write everything; fails where that cannot be done.
become_nobody() {
    [[ $EUID -ne 0 ]] && return
    as_nobody=(setpriv --reuid=65534 --regid=65534 --clear-groups env MESA_SHADER_CACHE_DISABLE=true)
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
    for i in 0 1 2; do write_photo "$scene/images/$i.png"; done
}
# frame NAME: a frame of transforms.json.
frame() { printf '{"file_path": "%s", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}' "$1"; }
# transforms FRAME...: writes transforms.json.
transforms() {
    local IFS=,
    printf '{"fl_x": 8, "frames": [%s]}\n' "$*" >"$scene/transforms.json"
}
good=("$(frame images/0.png)" "$(frame images/1.png)" "$(frame images/2.png)")

# with_photo CASE PATTERN: refused because of what became of images/1.png.
with_photo() {
    transforms "${good[@]}"
    refused "$1" "images/1.png.*($2)" "$scene"
}
with_name() {
    transforms "${good[0]}" "$(frame "$3")" "${good[2]}"
    refused "$1" "transforms.json: frame 1 .*file_path.*($2)" "$scene"
}

printf '%-44s | %s | %s\n' case code message

# ---- transforms.json ------------------------------------------------------------------------------------------------------

reset
printf '{"fl_x": 8,\n "frames": [}\n' >"$scene/transforms.json"
refused "JSON syntax error" 'transforms.json:2:[0-9]+: not valid JSON' "$scene"
reset
yes '{},' | head -n 4000000 | tr -d '\n' >"$scene/transforms.json"
refused "JSON of 4 million objects" 'transforms.json:1:[0-9]+:.*too much memory' "$scene"
refused "no such scene" 'none: no such scene' "$folder/none"
mkdir -p "$folder/empty"
refused "an empty folder" 'empty: no scene found; give' "$folder/empty"
mkdir -p "$folder/bare"
write_photo "$folder/bare/0.png"
refused "photos without poses" 'bare: .*photos without poses; .*colmap .* --image_path [^ ]*/bare, or ns-process-data images' "$folder/bare"
refused "a photo" 'bare/0.png: is not a scene; give the folder of a scene' "$folder/bare/0.png"
touch "$folder/bare/poses_bounds.npy"
refused "poses of LLFF" 'poses_bounds.npy is not read; add sparse/0' "$folder/bare"

# ---- Photos ---------------------------------------------------------------------------------------------------------------

reset
printf 'FOR4\0\0\0\x40CIMGTBHD\0\0\0\x20\x7f\xff\xff\xff\0\0\0\0\0\0\0\0' >"$scene/images/1.png"
with_photo "an IFF in place of a photo" 'no format that is read, which are PNG, JPEG'
echo 'not a photo' >"$scene/images/1.null?RES=16000x16000"
transforms "${good[0]}" "$(frame 'images/1.null?RES=16000x16000')" "${good[2]}"
refused "a name that asks OpenImageIO for 256 megapixels" 'RES=16000x16000: cannot open.*no format that is read' "$scene"
reset
{ printf '\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x01\x86\xa0\x00\x01\x86\xa0\x08\x02\x00\x00\x00\x27\x30\x9c\x9f'
    printf '\x00\x00\x00\x00IDAT\x35\xaf\x06\x1e'; } >"$scene/images/1.png"
with_photo "a PNG of 100,000 x 100,000 pixels" '100000 x 100000 pixels'
reset
truncate -s 50 "$scene/images/1.png"
transforms "${good[@]}"
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
cp "$scene/images/1.png" "$folder/elsewhere.png"
ln -s / "$scene/images/away"
with_name "a linked folder that leaves the folder" 'through a link' "images/away$folder/elsewhere.png"

# ---- Splits ---------------------------------------------------------------------------------------------------------------

reset
transforms "${good[0]}" "${good[1]}"
refused "nothing to validate" 'no view is left to validate' "$scene"

# ---- The machine ----------------------------------------------------------------------------------------------------------

reset
transforms "${good[@]}"
keep_out=$out
out=$scene/images/0.png
code=0
"$program" value "$scene" --out "$out" --quiet "${tiny[@]}" "${device[@]}" >"$folder/stdout" 2>"$folder/stderr" || code=$?
printf '%-44s | %d | %s\n' "--out is a file" "$code" "$(sed "s,$folder/,,g" "$folder/stderr")"
check "--out that is a file is refused" test "$code $(wc -l <"$folder/stderr")" = '2 1'
out=/proc/viewworth
run_case 1 "--out where no folder can be made" '/proc/viewworth: cannot create the folder' "$scene"
if become_nobody; then
    mkdir "$folder/locked"
    chmod 555 "$folder/locked"
    out=$folder/locked/out
    refused "--out that is not writable" 'locked: Permission denied' "$scene"
    as_nobody=()
else
    echo "SKIPPED: --out that is not writable: root may write everywhere"
fi
out=$keep_out
# Photos that are missing are left out; that is said even with --quiet, and stands in the report.
reset
cp "$scene/images/0.png" "$scene/images/3.png"
cp "$scene/images/1.png" "$scene/images/4.png"
transforms "${good[@]}" "$(frame images/3.png)" "$(frame images/4.png)" "$(frame images/lost.png)"
check "a photo that is missing does not stop a run" "$program" value "$scene" --out "$folder/lost" --quiet "${tiny[@]}" "${device[@]}" \
    2>"$folder/stderr"
check "it is a warning" grep -q 'warning: .*1 photo skipped, without an image file (first: images/lost.png)' "$folder/stderr"
check "and stands in the report" grep -q 'photo skipped.*lost.png' "$folder/lost/report.html"
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

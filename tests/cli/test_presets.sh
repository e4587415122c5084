#!/usr/bin/env bash
# --preset: what it sets, that explicit options override it, and that every preset trains. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
small=(--rays 16 --samples 8 --val-rays 32 --width 16 --epochs 2 --pilot-steps 0 --quiet)
mlp=(--importance-samples 16 --mlp-depth 2)

value() { # value PRESET [OPTION]...: into a folder of its name
    "$program" value "$scene" --preset "$1" --out "$folder/$1" "${small[@]}" "${@:2}"
}
holds() { # holds PRESET TEXT: in the config that the run has
    query "$1" 'SELECT config_json FROM run' | grep -qF -- "$2" || { query "$1" 'SELECT config_json FROM run'; return 1; }
}

check "an unknown preset is refused with those there are" fails 2 'none.*hash.*splats.*nerf.*nerf-w.*ha-nerf.*paper' value best
check "the preset hash trains" run value hash --log2-table 8
check "it has instant-ngp's grid" holds hash '"features":4'
check "and keeps an explicit size of it" holds hash '"log2_table":8'
check "the preset splats trains" run "$program" value "$scene" --preset splats --out "$folder/splats" --rays 256 --splats 100 \
    --epochs 2 --pilot-steps 0 --quiet
check "it has the loss of Kerbl et al." holds splats '"loss":"l1"'
check "and its SSIM" holds splats '"ssim_weight":0.2'
check "the preset nerf trains" run value nerf "${mlp[@]}"
check "its learning rate decays" holds nerf '"learning_rate_decay":0.1'
check "it is of the field mlp" holds nerf '"field":"mlp"'
check "it has a coarse network" holds nerf '"coarse_network":"own"'
check "and keeps an explicit depth" holds nerf '"mlp_depth":2'
check "the preset nerf-w trains" run value nerf-w "${mlp[@]}"
check "it has codes and transients" holds nerf-w '+appearance_code,+transient'
check "the preset ha-nerf trains" run value ha-nerf "${mlp[@]}"
check "it has HA-NeRF's encoder and visibility" holds ha-nerf '+appearance_encoder,+visibility'
check "and its consistency loss" holds ha-nerf '"consistency_weight":0.001'
check "whose steps have the same bits again" run "$program" verify "$folder/ha-nerf" --replay 5 --quiet
check "the preset paper trains" run value paper "${mlp[@]}"
check "by L1" holds paper '"loss":"l1"'
conclude "$@"

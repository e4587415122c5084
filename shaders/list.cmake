# Every compute shader that is embedded, in the order the data passes through them.
viewworth_add_shader(rays/draw_pixels) # where the device draws them
viewworth_add_shader(rays/draw_pixels VARIANT tiles DEFINE VW_OF_TILES) # for splats
viewworth_add_shader(rays/generate_rays)
viewworth_add_shader(effects/appearance_code/mix_code)
viewworth_add_shader(effects/appearance_encoder/convolve_photo) # of the effect appearance_encoder, as the eight that follow
viewworth_add_shader(effects/appearance_encoder/convolve_photo VARIANT back DEFINE VW_BACK)
viewworth_add_shader(effects/appearance_encoder/pool_photo)
viewworth_add_shader(effects/appearance_encoder/spread_photo)
viewworth_add_shader(effects/appearance_encoder/gradient_photo)
viewworth_add_shader(effects/appearance_encoder/shrink_colours) # of its consistency loss, as the three that follow
viewworth_add_shader(effects/appearance_encoder/spread_photo VARIANT codes DEFINE VW_CODES)
viewworth_add_shader(effects/appearance_encoder/spread_colours DEFINE VW_BACK)
viewworth_add_shader(effects/appearance_encoder/add_gradients)
viewworth_add_shader(effects/visibility/predict_visibility) # of the effect, as three below
viewworth_add_shader(effects/visibility/predict_visibility VARIANT uncertainty DEFINE VW_UNCERTAINTY) # of that effect, as two below
viewworth_add_shader(rays/place_samples) # --importance-samples
viewworth_add_shader(field_hash/forward_field)
viewworth_add_shader(field_mlp/encode_samples) # the field mlp, with three variants below
viewworth_add_shader(field_mlp/multiply_layer)
viewworth_add_shader(field_mlp/multiply_layer VARIANT back DEFINE VW_BACK)
viewworth_add_shader(field_mlp/activate_samples)
viewworth_add_shader(field_mlp/activate_samples VARIANT back DEFINE VW_BACK)
viewworth_add_shader(effects/transient/feed_transient) # of that effect alone, as the other two
viewworth_add_shader(effects/transient/feed_transient VARIANT features DEFINE VW_FEATURES)
viewworth_add_shader(rays/composite_rays)
viewworth_add_shader(rays/composite_rays VARIANT depth DEFINE VW_DEPTH) # of renders alone, as two below
viewworth_add_shader(effects/appearance/fit_views)
viewworth_add_shader(rays/reduce_views)
viewworth_add_shader(rays/backward_rays)
viewworth_add_shader(rays/backward_rays VARIANT effects DEFINE VW_RAY_EFFECTS) # sky, weights of rays, and what fit_photo needs
viewworth_add_shader(effects/transient/backward_transient)
viewworth_add_shader(effects/transient/backward_transient VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(field_hash/backward_field)
viewworth_add_shader(field_hash/backward_field VARIANT transient DEFINE VW_TRANSIENT)
viewworth_add_shader(networks/gradient_weights)
viewworth_add_shader(networks/reduce_weights)
viewworth_add_shader(networks/gradient_weights VARIANT layer DEFINE VW_LAYER)
viewworth_add_shader(networks/reduce_weights VARIANT layer DEFINE VW_LAYER)
viewworth_add_shader(effects/sky/gradient_sky) # of the effect alone
viewworth_add_shader(effects/visibility/gradient_visibility)
viewworth_add_shader(effects/visibility/gradient_visibility VARIANT uncertainty DEFINE VW_UNCERTAINTY)
viewworth_add_shader(effects/visibility/reduce_visibility)
viewworth_add_shader(effects/visibility/reduce_visibility VARIANT uncertainty DEFINE VW_UNCERTAINTY)
viewworth_add_shader(field_hash/scatter_grid)
viewworth_add_shader(field_hash/scatter_grid VARIANT split DEFINE VW_SPLIT_ATOMICS) # where 64-bit atomics are missing
viewworth_add_shader(field_hash/scatter_grid VARIANT walk DEFINE VW_WALK_LEVELS) # on CPUs of few cores
viewworth_add_shader(effects/pose/gradient_positions) # of the effect pose alone, as gradient_pose and update_pose
viewworth_add_shader(effects/pose/gradient_pose)
viewworth_add_shader(rays/reduce_loss)
viewworth_add_shader(effects/transient/update_transient)
viewworth_add_shader(effects/appearance/fit_photo)
viewworth_add_shader(effects/appearance_code/update_code)
viewworth_add_shader(effects/pose/update_pose)
viewworth_add_shader(effects/visibility/update_visibility)
viewworth_add_shader(field_hash/update_grid)
viewworth_add_shader(networks/update_weights)
viewworth_add_shader(adjoint/slope_views) # the rest of the backward pass of lasting credit
viewworth_add_shader(adjoint/direct_adjoint)
viewworth_add_shader(adjoint/reduce_adjoint)
viewworth_add_shader(adjoint/multiply_blocks)
viewworth_add_shader(adjoint/perturb_params)
viewworth_add_shader(adjoint/difference_rays)
viewworth_add_shader(adjoint/difference_rays VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(adjoint/normalise_slopes)
viewworth_add_shader(adjoint/gather_grid)
viewworth_add_shader(adjoint/gather_weights)
viewworth_add_shader(adjoint/gather_code)
viewworth_add_shader(splats/mark_tiles) # splats, up to update_splats
viewworth_add_shader(splats/project_splats)
viewworth_add_shader(splats/place_pairs)
viewworth_add_shader(splats/emit_pairs)
viewworth_add_shader(splats/colour_splats)
viewworth_add_shader(splats/colour_splats VARIANT depth DEFINE VW_DEPTH)
viewworth_add_shader(splats/count_digits)
viewworth_add_shader(splats/place_digits)
viewworth_add_shader(splats/scatter_pairs)
viewworth_add_shader(splats/blend_tiles)
viewworth_add_shader(splats/show_pixels) # of an evaluator
viewworth_add_shader(splats/show_pixels VARIANT depth DEFINE VW_DEPTH)
viewworth_add_shader(splats/compare_windows)
viewworth_add_shader(splats/compare_windows VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(splats/slope_pixels)
viewworth_add_shader(splats/slope_pixels VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(splats/blend_tiles_back)
viewworth_add_shader(splats/backward_splats)
viewworth_add_shader(splats/update_splats)
viewworth_add_shader(recipe/trace_recipe) # draws the photos of recipes

# Every compute shader that is embedded, in the order the data passes through them.
viewworth_add_shader(generate_rays)
viewworth_add_shader(mix_code)
viewworth_add_shader(convolve_photo) # of the effect appearance_encoder, as the eight that follow
viewworth_add_shader(convolve_photo VARIANT back DEFINE VW_BACK)
viewworth_add_shader(pool_photo)
viewworth_add_shader(spread_photo)
viewworth_add_shader(gradient_photo)
viewworth_add_shader(shrink_colours) # of its consistency loss, as the three that follow
viewworth_add_shader(spread_photo VARIANT codes DEFINE VW_CODES)
viewworth_add_shader(spread_colours DEFINE VW_BACK)
viewworth_add_shader(add_gradients)
viewworth_add_shader(predict_visibility) # of the effect, as three below
viewworth_add_shader(refresh_occupancy) # the four that skip empty space
viewworth_add_shader(refresh_occupancy VARIANT half DEFINE VW_HALF_GRID) # --table-precision float16, as the other two
viewworth_add_shader(mark_samples)
viewworth_add_shader(place_rays)
viewworth_add_shader(list_samples)
viewworth_add_shader(place_samples) # --importance-samples
viewworth_add_shader(forward_field)
viewworth_add_shader(forward_field VARIANT half DEFINE VW_HALF_GRID)
viewworth_add_shader(encode_samples) # the field mlp, with three variants below
viewworth_add_shader(multiply_layer)
viewworth_add_shader(multiply_layer VARIANT back DEFINE VW_BACK)
viewworth_add_shader(activate_samples)
viewworth_add_shader(activate_samples VARIANT back DEFINE VW_BACK)
viewworth_add_shader(feed_transient) # of that effect alone, as the other two
viewworth_add_shader(feed_transient VARIANT features DEFINE VW_FEATURES)
viewworth_add_shader(composite_rays)
viewworth_add_shader(fit_views)
viewworth_add_shader(reduce_views)
viewworth_add_shader(backward_rays)
viewworth_add_shader(backward_rays VARIANT effects DEFINE VW_RAY_EFFECTS) # sky, appearance, visibility
viewworth_add_shader(backward_transient)
viewworth_add_shader(backward_transient VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(backward_field)
viewworth_add_shader(backward_field VARIANT transient DEFINE VW_TRANSIENT)
viewworth_add_shader(gradient_weights)
viewworth_add_shader(reduce_weights)
viewworth_add_shader(gradient_weights VARIANT layer DEFINE VW_LAYER)
viewworth_add_shader(reduce_weights VARIANT layer DEFINE VW_LAYER)
viewworth_add_shader(gradient_sky) # of the effect alone
viewworth_add_shader(gradient_visibility)
viewworth_add_shader(reduce_visibility)
viewworth_add_shader(scatter_grid)
viewworth_add_shader(scatter_grid VARIANT split DEFINE VW_SPLIT_ATOMICS) # where 64-bit atomics are missing
viewworth_add_shader(scatter_grid VARIANT walk DEFINE VW_WALK_LEVELS) # on CPUs of few cores
viewworth_add_shader(gradient_positions) # of the effect pose alone, as gradient_pose and update_pose
viewworth_add_shader(gradient_positions VARIANT half DEFINE VW_HALF_GRID)
viewworth_add_shader(gradient_pose)
viewworth_add_shader(reduce_loss)
viewworth_add_shader(update_transient)
viewworth_add_shader(update_appearance)
viewworth_add_shader(update_code)
viewworth_add_shader(update_pose)
viewworth_add_shader(update_visibility)
viewworth_add_shader(update_grid)
viewworth_add_shader(update_grid VARIANT half DEFINE VW_HALF_GRID)
viewworth_add_shader(update_weights)
viewworth_add_shader(slope_views) # the rest of the backward sweep of lasting credit
viewworth_add_shader(direct_adjoint)
viewworth_add_shader(reduce_adjoint)
viewworth_add_shader(multiply_blocks)
viewworth_add_shader(perturb_params)
viewworth_add_shader(difference_rays)
viewworth_add_shader(difference_rays VARIANT effects DEFINE VW_RAY_EFFECTS)
viewworth_add_shader(normalise_slopes)
viewworth_add_shader(gather_grid)
viewworth_add_shader(gather_weights)
viewworth_add_shader(gather_photo)
viewworth_add_shader(gather_code)
viewworth_add_shader(trace_recipe) # draws the photos of recipes
viewworth_add_shader(multiply_registers) # measures what the device can do, as does
viewworth_add_shader(copy_memory)

//! Whole images: those that are known, those of another renderer, and those that must be the same however they are made.

#[path = "../common/mod.rs"]
mod common;

mod alpha;
mod aov;
mod blender;
mod caustics;
mod closed_form;
mod coloured_glass;
mod delta_lights;
mod devices;
mod emissive;
mod estimators;
mod features;
mod filters;
mod followed_back;
mod gltf_extensions;
mod in_memory;
mod instances;
mod lamps_in_view;
mod large_spheres;
mod light_groups;
mod light_paths;
mod light_sampling;
mod lobes;
mod mattes;
mod motion;
mod multiscatter;
mod narrow_lobes;
mod normal_maps;
mod numbers;
mod one_sided;
mod panes;
mod parted_lights;
mod projections;
mod recipe;
mod references;
#[cfg(target_os = "linux")]
mod rounding;
mod same_bytes;
mod scheduling;
mod sobol;
mod sweeps;
mod thin_faces;
mod trade_offs;
mod truth;
mod uv_sets;
mod varying_media;
mod vertex_colours;
mod volume_references;
mod walk;
mod warnings;

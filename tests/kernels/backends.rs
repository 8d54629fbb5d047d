//! naga writes every kernel for Metal and DirectX 12 too. No compiler of theirs reads the text here; what naga cannot write is found.

use gpu_rt::flatten::flatten;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::spirv;
use gpu_rt::options::{FeatureSet, RenderOptions, Scatter};
use gpu_rt::plan::{Kernels, UniformTables};
use gpu_rt::scene::Scene;
use naga::ShaderStage;
use naga::back::{hlsl, msl};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};

use crate::common::everything::{Everything, World};
use crate::common::files::files;

/// A kernel's text in a language: of its module, its entry point and its overrides.
type Write = fn(&naga::Module, &str, &[(&str, f64)]) -> Result<String, String>;

/// The kernel as MSL, with wgpu's settings.
fn as_msl(module: &naga::Module, entry_point: &str, overrides: &[(&str, f64)]) -> Result<String, String> {
    let (module, info) = spirv::resolved(module, entry_point, overrides).map_err(|error| error.to_string())?;
    let restrict = BoundsCheckPolicy::Restrict;
    let bounds_check_policies =
        BoundsCheckPolicies { index: restrict, buffer: restrict, image_load: restrict, ..Default::default() };
    let options = msl::Options { lang_version: (2, 4), bounds_check_policies, ..msl::Options::default() };
    let entry = Some((ShaderStage::Compute, entry_point.to_string()));
    let pipeline = msl::PipelineOptions { entry_point: entry, ..msl::PipelineOptions::default() };
    let written = msl::write_string(&module, &info, &options, &pipeline);
    let (text, translated) = written.map_err(|error| error.to_string())?;
    translated.entry_point_names.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
    Ok(text)
}

/// The kernel as HLSL, with wgpu's settings.
fn as_hlsl(module: &naga::Module, entry_point: &str, overrides: &[(&str, f64)]) -> Result<String, String> {
    let (module, info) = spirv::resolved(module, entry_point, overrides).map_err(|error| error.to_string())?;
    let options = hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, ..hlsl::Options::default() };
    let pipeline = hlsl::PipelineOptions { entry_point: Some((ShaderStage::Compute, entry_point.to_string())) };
    let mut text = String::new();
    let written = hlsl::Writer::new(&mut text, &options, &pipeline).write(&module, &info, None);
    let names = written.map_err(|error| error.to_string())?.entry_point_names;
    names.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
    Ok(text)
}

/// Every kernel of the scene in every way of linking, with tables in storage buffers and in uniforms.
fn check(name: &str, scene: &Scene, features: FeatureSet) {
    let options = RenderOptions { features, ..RenderOptions::default() };
    let flat = flatten(scene, (scene.image.width, scene.image.height), &options);
    let flat = flat.unwrap_or_else(|error| panic!("{name}: {error}"));
    let in_storage = DeviceClass::default();
    let in_uniforms = DeviceClass { software: true, max_uniform_bytes: 1 << 16, max_uniforms: 32, ..in_storage };
    for class in [in_storage, in_uniforms] {
        let tables = UniformTables::new(&flat, class);
        for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
            let kernels = Kernels::link(&flat.features.with_options(&options), &options, scatter, &tables);
            for kernel in kernels.unwrap_or_else(|error| panic!("{name}: {error}")).all() {
                let at = format!("{name}, {features:?}, {scatter:?}, {}", kernel.name);
                for (language, write) in [("MSL", as_msl as Write), ("HLSL", as_hlsl)] {
                    let text = write(&kernel.module, kernel.stage, &[("WORKGROUP_SIZE", 64.0)])
                        .unwrap_or_else(|error| panic!("{at} as {language}: {error}"));
                    assert!(text.contains(kernel.stage), "{at}: the {language} has no entry point");
                }
            }
        }
    }
}

#[test]
fn metal_and_directx_get_every_kernel_of_the_scenes_that_ship() {
    let scenes = files("scenes", ".ron", false);
    assert!(scenes.len() > 5, "{scenes:?}");
    for path in scenes {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        check(&path.display().to_string(), &scene, FeatureSet::Scene);
    }
}

#[test]
fn metal_and_directx_get_every_kernel_with_everything_on() {
    let everything = Everything::new();
    for features in [FeatureSet::Scene, FeatureSet::All] {
        check("everything", &everything.scene(World::default()), features);
    }
}

/// An entry point that is missing, and a workgroup of no invocations.
#[test]
fn a_kernel_that_no_backend_can_write_is_found() {
    let text = "override N: u32 = 32u;\n@group(0) @binding(0) var<storage, read_write> x: array<u32>;\n\
                @compute @workgroup_size(N) fn f() {\n    x[0] = N;\n}\n";
    let module = naga::front::wgsl::parse_str(text).expect("it is WGSL");
    for write in [as_msl as Write, as_hlsl] {
        assert!(write(&module, "f", &[]).is_ok());
        assert!(write(&module, "f", &[("N", 0.0)]).is_err());
        assert!(write(&module, "unknown", &[]).is_err());
    }
}

//! What the end-to-end tests share.

pub mod measure;
pub mod picture;
pub mod reference;

/// A GPU device, a software one if need be, with the adapter's own limits; `None` where the machine has no adapter and
/// `KINORA_NO_GPU=1` says that this is known.
///
/// # Panics
/// Where no adapter is found, or it gives no device, and `KINORA_NO_GPU` is not 1: a test that silently tests nothing is
/// worse than one that fails.
pub fn gpu() -> Option<(wgpu::Device, wgpu::Queue)> {
    if std::env::var_os("KINORA_NO_GPU").is_some_and(|value| value == "1") {
        return None;
    }
    // Not OpenGL: Mesa's software OpenGL had not run the construct tests after a minute, its software Vulkan needs seconds.
    let backends = wgpu::Backends::PRIMARY;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .expect("no GPU adapter: install mesa-vulkan-drivers, or set KINORA_NO_GPU=1 to do without");
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    Some(pollster::block_on(adapter.request_device(&descriptor)).expect("the GPU adapter gives no device"))
}

/// The scene of a file in the repository, with parameters as `-D` gives them; its warnings are failures too.
///
/// # Panics
/// The file has a mistake.
pub fn scene(path: &str, params: &[(&str, &str)]) -> kinora_scene::Scene {
    use kinora_lang::files::{self, Folder};
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    let (folder, name) = Folder::of(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let loaded = files::load(&folder, Default::default(), &name).unwrap_or_else(|error| panic!("{}", error.message()));
    let params = params.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
    let overrides = kinora_lang::Overrides { params, ..Default::default() };
    match kinora_lang::eval(&kinora_lang::parse(&loaded.source), &folder, &overrides) {
        Ok(evaluated) if evaluated.warnings.is_empty() => baked(evaluated.scene),
        Ok(evaluated) => panic!("{name}: {:?}", evaluated.warnings),
        Err(found) => panic!("{name}: {found:?}"),
    }
}

/// The scene with its bodies where they are at all times.
///
/// # Panics
/// They are nowhere.
pub fn baked(mut scene: kinora_scene::Scene) -> kinora_scene::Scene {
    use kinora_animator::physics::{Next, NoCache, bake};
    let found = bake(&scene, &mut NoCache, false, &mut |_| Next::Step).unwrap_or_else(|error| panic!("{error}"));
    scene.physics.baked = found.map(|bake| bake.baked);
    scene
}

/// The world of a text in the scene language at time 0; its warnings are failures too.
///
/// # Panics
/// The text has a mistake.
pub fn world(text: &str) -> kinora_scene::World {
    world_with(text, &kinora_lang::files::Memory::default())
}

/// As [`world`], of a text that names `files`.
///
/// # Panics
/// The text has a mistake.
pub fn world_with(text: &str, files: &kinora_lang::files::Memory) -> kinora_scene::World {
    world_at(text, files, 0)
}

/// As [`world_with`], of a frame.
///
/// # Panics
/// The text has a mistake.
pub fn world_at(text: &str, files: &kinora_lang::files::Memory, frame: i64) -> kinora_scene::World {
    let scene = scene_of(text, files);
    kinora_animator::sample(&scene, scene.clock.shutter_of(frame)).expect("the frame has a world")
}

/// A scene from its text, with its bodies' ways.
///
/// # Panics
/// The text makes no scene, or there are warnings.
pub fn scene_of(text: &str, files: &kinora_lang::files::Memory) -> kinora_scene::Scene {
    use kinora_lang::source::{FileId, Source};
    let source = Source::new(FileId(0), "test.kin", text);
    match kinora_lang::eval(&kinora_lang::parse(&source), files, &Default::default()) {
        Ok(evaluated) if evaluated.warnings.is_empty() => baked(evaluated.scene),
        Ok(evaluated) => panic!("{text}\n{:?}", evaluated.warnings),
        Err(found) => panic!("{text}\n{found:?}"),
    }
}

/// A frame on a backend.
///
/// # Panics
/// The frame cannot be made.
pub fn render(scene: &kinora_scene::Scene, frame: i64, choice: kinora_renderer::Choice) -> kinora_renderer::Film {
    let world = kinora_animator::sample(scene, scene.clock.shutter_of(frame)).expect("the frame has a world");
    let backend = kinora_renderer::open(choice, kinora_renderer::Options::default()).expect("the backend opens");
    kinora_renderer::Renderer::new(backend).render(&world, &()).expect("the world renders")
}
